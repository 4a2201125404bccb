// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/history_bytes.h"

#include <cstring>

#include <fmt/format.h>

namespace stillray {
namespace {

struct Header {
  char magic[8] = {'s', 't', 'i', 'l', 'l', 'r', 'a', 'y'};
  uint32_t version = 2;
  uint32_t byte_order = 0x01020304;
  int32_t width = 0;
  int32_t height = 0;
  uint32_t signal_count = 0;
  uint32_t flags = 0;  ///< 1: history, 2: picture, 4: compressed luminances
};

/// Calls visit(plane) for every plane of the state, in the order of the file.
template <typename State, typename Visit>
void VisitPlanes(State& state, const Visit& visit) {
  const auto visit_all = [&](auto& planes) {
    for (auto& plane : planes.channel) {
      visit(plane);
    }
  };
  for (auto& signal : state.signals) {
    visit_all(signal.colour);
    visit(signal.mean);
    visit(signal.variance);
    visit(signal.length);
    visit(signal.weights2);
    visit(signal.compressed);
  }
  visit(state.guides.inverse_depth);
  visit_all(state.guides.normal);
  visit(state.guides.id);
  visit_all(state.picture);
}

size_t PayloadBytes(const Header& header) {
  const size_t signal_planes = (header.flags & 4u) != 0 ? 8 : 7;
  const size_t planes = header.signal_count * signal_planes + 8;
  return header.signal_count * sizeof(float) +
         planes * 4 * static_cast<size_t>(header.width) * static_cast<size_t>(header.height);
}

bool WithCompressed(const DenoiserState& state) {
  return !state.signals.empty() && !state.signals[0].compressed.empty();
}

}  // namespace

std::vector<uint8_t> HistoryToBytes(const DenoiserState& state) {
  Header header;
  header.width = state.width;
  header.height = state.height;
  header.signal_count = static_cast<uint32_t>(state.signals.size());
  header.flags = (state.has_history ? 1u : 0u) | (state.has_picture ? 2u : 0u) |
                 (WithCompressed(state) ? 4u : 0u);
  std::vector<uint8_t> bytes(sizeof(Header));
  std::memcpy(bytes.data(), &header, sizeof(Header));
  bytes.reserve(sizeof(Header) + PayloadBytes(header));
  for (const SignalHistory& signal : state.signals) {
    const auto* scale = reinterpret_cast<const uint8_t*>(&signal.compressed_scale);
    bytes.insert(bytes.end(), scale, scale + sizeof(float));
  }
  VisitPlanes(state, [&](const auto& plane) {
    for (int y = 0; y < plane.height(); ++y) {
      const auto* row = reinterpret_cast<const uint8_t*>(plane.Row(y));
      bytes.insert(bytes.end(), row, row + static_cast<size_t>(plane.width()) * 4);
    }
  });
  return bytes;
}

Result<DenoiserState> HistoryFromBytes(std::span<const uint8_t> bytes, size_t least, size_t most,
                                       bool with_compressed, int border) {
  Header header;
  const Header expected;
  if (bytes.size() < sizeof(Header)) {
    return Status::BadData(fmt::format("saved history has {} bytes, expected at least {}",
                                       bytes.size(), sizeof(Header)));
  }
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
      header.version != expected.version || header.byte_order != expected.byte_order) {
    return Status::BadData(
        "saved history was not written by this version of stillray on such a machine");
  }
  if (header.width < 1 || header.height < 1 || header.width > 32768 || header.height > 32768) {
    return Status::BadData(
        fmt::format("saved history claims a size of {}x{}", header.width, header.height));
  }
  if (header.signal_count != least && header.signal_count != most) {
    return Status::BadData(fmt::format("saved history has {} signals, the settings ask for {}",
                                       header.signal_count, least));
  }
  if (((header.flags & 4u) != 0) != with_compressed) {
    return Status::BadData(
        fmt::format("saved history was made with limit_history {}, the settings "
                    "have it {}",
                    with_compressed ? "off" : "on", with_compressed ? "on" : "off"));
  }
  if (bytes.size() != sizeof(Header) + PayloadBytes(header)) {
    return Status::BadData(fmt::format("saved history has {} bytes, expected {}", bytes.size(),
                                       sizeof(Header) + PayloadBytes(header)));
  }
  DenoiserState state(header.width, header.height, header.signal_count, with_compressed);
  state.has_history = (header.flags & 1u) != 0;
  state.has_picture = (header.flags & 2u) != 0;
  state.guides = GuidePlanes(header.width, header.height, border);
  const uint8_t* from = bytes.data() + sizeof(Header);
  for (SignalHistory& signal : state.signals) {
    std::memcpy(&signal.compressed_scale, from, sizeof(float));
    from += sizeof(float);
  }
  VisitPlanes(state, [&](auto& plane) {
    for (int y = 0; y < plane.height(); ++y) {
      const size_t row_bytes = static_cast<size_t>(plane.width()) * 4;
      std::memcpy(static_cast<void*>(plane.Row(y)), from, row_bytes);
      from += row_bytes;
    }
  });
  return state;
}

}  // namespace stillray
