// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Hardware limits: peak arithmetic rate and memory bandwidth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray {

/// The instruction set used by the vector code on this CPU: "AVX3", "AVX2", ...
const char* InstructionSet();

/// Peak rate of float fused multiply-adds per second on one thread, with full vectors and enough
/// independent chains to saturate all units. Takes about 2 ms.
double MultiplyAddsPerSecond();

/// Copies memory with all threads, in arrays too large for the caches.
class CopyTest {
 public:
  /// \param bytes  total bytes read and written
  explicit CopyTest(size_t bytes);
  /// Copies once. \return milliseconds
  double Run();
  size_t bytes() const { return 2 * from_.size(); }

 private:
  std::vector<char> from_;
  std::vector<char> to_;
};

}  // namespace stillray
