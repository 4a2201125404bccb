// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Bytes of the second cache of a core, for loops that choose how much they keep at hand.
#pragma once

#include <cstddef>

#ifdef __linux__
#include <unistd.h>
#endif

namespace stillray {

/// 1 MiB where the system does not say.
inline size_t SecondCacheBytes() {
  constexpr size_t kUnknown = size_t{1} << 20;
#ifdef _SC_LEVEL2_CACHE_SIZE
  static const long bytes = sysconf(_SC_LEVEL2_CACHE_SIZE);
  return bytes > 0 ? static_cast<size_t>(bytes) : kUnknown;
#else
  return kUnknown;
#endif
}

}  // namespace stillray
