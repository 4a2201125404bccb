// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/memory_table.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/run_summary.h"
#include "core/memory_blocks.h"

namespace stillray {
namespace {

std::string Bytes(uint64_t bytes) {
  return bytes > 0 ? FormatBytes(static_cast<int64_t>(bytes)) : "-";
}

std::string Row(const char* name, const MemoryBlocks& m) {
  return fmt::format("  {:<10}{:>7}{:>9}{:>9}{:>9}{:>8}{:>11} .. {:<9}{:>11} .. {}\n", name,
                     m.blocks, m.allocations, Bytes(m.block_bytes), Bytes(m.allocated_bytes),
                     m.unused_ranges, Bytes(m.smallest_allocation), Bytes(m.largest_allocation),
                     Bytes(m.smallest_unused), Bytes(m.largest_unused));
}

nlohmann::ordered_json Json(const MemoryBlocks& m) {
  return {{"blocks", m.blocks},
          {"allocations", m.allocations},
          {"block_bytes", m.block_bytes},
          {"allocated_bytes", m.allocated_bytes},
          {"unused_ranges", m.unused_ranges},
          {"smallest_allocation", m.smallest_allocation},
          {"largest_allocation", m.largest_allocation},
          {"smallest_unused", m.smallest_unused},
          {"largest_unused", m.largest_unused}};
}

}  // namespace

std::string MemoryBlocksTable() {
  const MemoryBlocks host = CountedBlocks(MemoryPlace::kHost);
  const MemoryBlocks device = CountedBlocks(MemoryPlace::kDevice);
  std::string table =
      fmt::format("  {:<10}{:>7}{:>9}{:>9}{:>9}{:>8}{:>24}{:>24}\n", "pictures", "blocks", "allocs",
                  "in all", "used", "unused", "allocations of", "unused ranges of");
  table += Row("CPU", host);
  if (device.blocks > 0) {
    table += Row("devices", device);
    MemoryBlocks sum = host;
    sum += device;
    table += Row("sum", sum);
  }
  return table;
}

nlohmann::ordered_json MemoryBlocksJson() {
  const MemoryBlocks host = CountedBlocks(MemoryPlace::kHost);
  const MemoryBlocks device = CountedBlocks(MemoryPlace::kDevice);
  MemoryBlocks sum = host;
  sum += device;
  return {{"cpu", Json(host)}, {"devices", Json(device)}, {"sum", Json(sum)}};
}

}  // namespace stillray
