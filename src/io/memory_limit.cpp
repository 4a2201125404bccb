// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include <fmt/format.h>

namespace stillray {

int64_t AvailableMemory() {
  int64_t bytes = int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGE_SIZE);
  struct rlimit limit {};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    bytes = std::min(bytes, static_cast<int64_t>(limit.rlim_cur));
  }
  return std::max<int64_t>(bytes, 0);
}

Status CheckExrFits(std::string_view bytes, const std::string& name, const ExrCost& cost) {
  const Result<ExrExtent> extent =
      MeasureExr(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), name);
  if (!extent.ok()) {
    return extent.status();
  }
  const int64_t needed =
      extent->pixels * (cost.bytes_per_pixel + extent->channels * cost.bytes_per_channel);
  const int64_t available = AvailableMemory();
  if (available == 0 || needed <= available) {
    return Status::Ok();
  }
  return Status::OutOfMemory(
      fmt::format("{}: a picture of {} x {} pixels with {} channels takes about {:.1f} GB; there "
                  "are {:.1f} GB",
                  name, extent->width, extent->height, extent->channels,
                  static_cast<double>(needed) / 1e9, static_cast<double>(available) / 1e9));
}

}  // namespace stillray
