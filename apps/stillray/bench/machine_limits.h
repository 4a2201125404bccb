// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The limits of the machine: peak arithmetic rate and memory bandwidth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray {

/// The instruction set that the vector code runs on here: "AVX3", "AVX2", ...
const char* InstructionSet();

/// Fused multiply-adds of floats per second that one thread reaches with full vectors, chains
/// enough to keep every unit busy. Takes about 2 ms.
double MultiplyAddsPerSecond();

/// Copies memory with all threads, in arrays too large for the caches.
class CopyTest {
 public:
  /// \param bytes  read + written
  explicit CopyTest(size_t bytes);
  /// Copies once. \return milliseconds
  double Run();
  size_t bytes() const { return 2 * from_.size(); }

 private:
  std::vector<char> from_;
  std::vector<char> to_;
};

}  // namespace stillray
