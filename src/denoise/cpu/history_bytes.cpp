// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/history_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "core/checksum.h"
#include "denoise/stages/follow_light_shared.h"

namespace stillray {
namespace {

struct Header {
  char magic[8] = {};
  uint32_t version = 9;
  uint32_t byte_order = kHistoryByteOrder;
  int32_t width = 0;
  int32_t height = 0;
  uint32_t signal_count = 0;
  /// 1: history, 2: output image, 4: compressed luminances, 8: history without the last feedback,
  /// 16: held guides, 32: with ids, 64: some frame was jittered, 128: layer of the reflection, 256:
  /// of the refraction, 512: radiance of follow_light, 1024: signals by channel of colour, 2048:
  /// octahedral normals, 4096: antialiased albedo
  uint32_t flags = 0;
  uint32_t held_planes = 0;  ///< bit n: the n-th plane of VisitHeldPlanes is present
  float feedback_progress = 0;
  uint32_t residual_signals = 0;  ///< bit n: the n-th signal of all layers has a mean residual
  uint32_t reserved = 0;
  uint64_t checksum = 0;  ///< of all bytes, with this member set to 0
};
static_assert(sizeof(Header) == 56, "no bytes between members");

uint64_t ChecksumOf(Header header, std::span<const uint8_t> payload) {
  header.checksum = 0;
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(&header), sizeof(Header));
  return AddToChecksum(payload, AddToChecksum(bytes));
}

/// Calls visit(plane) for every plane of the state, in the order of the saved bytes.
template <typename State, typename Visit>
void VisitPlanes(State& state, const Visit& visit) {
  const auto visit_all = [&](auto& planes) {
    for (auto& plane : planes.channel) {
      visit(plane);
    }
  };
  for (auto& layer : state.layers) {
    for (auto& signal : layer.signals) {
      visit_all(signal.colour);
      visit(signal.mean);
      visit(signal.variance);
      visit(signal.length);
      visit(signal.weights2);
      visit(signal.compressed);
      visit_all(signal.behind);
    }
    visit(layer.guides.inverse_depth);
    visit_all(layer.guides.normal);
    visit(layer.guides.packed_normal);
    visit(layer.guides.id);
    for (auto& residual : layer.residuals) {
      if (!residual.length.empty()) {
        visit_all(residual.colour);
        visit(residual.length);
      }
    }
  }
  visit_all(state.picture);
  if (state.progress.has_albedo) {
    visit_all(state.albedo);
  }
  if (state.progress.has_followed) {
    visit(state.followed);
  }
  VisitHeldPlanes(state.held, visit);
  visit(state.held.guides.id);
}

size_t PayloadBytes(const Header& header) {
  const size_t signal_planes =
      7u + ((header.flags & 4u) != 0 ? 1u : 0u) + ((header.flags & 8u) != 0 ? 3u : 0u);
  const size_t layers =
      1u + ((header.flags & 128u) != 0 ? 1u : 0u) + ((header.flags & 256u) != 0 ? 1u : 0u);
  const size_t guides = (header.flags & 2048u) != 0 ? 3u : 5u;
  const size_t planes = header.signal_count * signal_planes + layers * guides + 3 +
                        ((header.flags & 4096u) != 0 ? 3u : 0u) +
                        static_cast<size_t>(std::popcount(header.held_planes)) +
                        4 * static_cast<size_t>(std::popcount(header.residual_signals)) +
                        ((header.flags & 32u) != 0 ? 1u : 0u);
  const size_t blocks = (header.flags & 512u) == 0
                            ? 0u
                            : static_cast<size_t>(FollowSize(header.width)) *
                                  static_cast<size_t>(FollowSize(header.height));
  return header.signal_count * sizeof(float) + 4 * blocks +
         planes * 4 * static_cast<size_t>(header.width) * static_cast<size_t>(header.height);
}

uint32_t PlanesOf(const HeldGuides& held) {
  uint32_t mask = 0;
  uint32_t bit = 1;
  VisitHeldPlanes(held, [&](const Image1& plane) {
    mask |= plane.empty() ? 0u : bit;
    bit <<= 1;
  });
  return mask;
}

/// Allocates the planes in `held_planes`. \return false if it has bits of planes that do not exist
bool MakePlanes(const Header& header, HeldGuides* held) {
  uint32_t mask = header.held_planes;
  VisitHeldPlanes(*held, [&](Image1& plane) {
    if ((mask & 1u) != 0) {
      plane = Image1(header.width, header.height);
    }
    mask >>= 1;
  });
  if ((header.flags & 32u) != 0) {
    held->guides.id = Plane<uint32_t>(header.width, header.height);
  }
  return mask == 0;
}

uint32_t ResidualsOf(const History& state) {
  uint32_t mask = 0;
  uint32_t first = 0;
  for (const LayerHistory& layer : state.layers) {
    for (size_t i = 0; i < layer.residuals.size(); ++i) {
      mask |= layer.residuals[i].length.empty() ? 0u : 1u << (first + i);
    }
    first += static_cast<uint32_t>(layer.signals.size());
  }
  return mask;
}

/// Allocates the mean residuals in `residual_signals`, which must have no bits of signals that do
/// not exist.
void MakeResiduals(const Header& header, std::vector<LayerHistory>* layers) {
  uint32_t mask = header.residual_signals;
  for (LayerHistory& layer : *layers) {
    layer.residuals.resize(layer.signals.size());
    for (SignalHistory& residual : layer.residuals) {
      if ((mask & 1u) != 0) {
        residual = EmptyResidual(header.width, header.height);
      }
      mask >>= 1;
    }
  }
}

bool HasLayer(const LayerList& list, GuideSource source) {
  return std::any_of(list.begin(), list.end(),
                     [&](const PlannedLayer& layer) { return layer.guides == source; });
}

/// The layers of a saved history. \return kBadData if frames with these settings do not have them
Result<LayerList> LayersOf(const Header& header, const Settings& settings) {
  const size_t with_transmission = GroupsOf(settings.signals, true).size();
  FrameFacts facts;
  facts.has_reflection = (header.flags & 128u) != 0;
  facts.has_refraction = (header.flags & 256u) != 0;
  if (header.signal_count == with_transmission) {
    facts.lights = 1u << static_cast<uint32_t>(SignalKind::kDirectTransmission);
  }
  const LayerList list = LayersOf(settings, facts);
  if (HasLayer(list, GuideSource::kReflection) != facts.has_reflection ||
      HasLayer(list, GuideSource::kRefraction) != facts.has_refraction) {
    return Status::BadData(
        "saved history follows virtual guides, under these settings no signal does");
  }
  return list;
}

bool HoldsNan(const float* row, int width) {
  return std::any_of(row, row + width, [](float value) { return std::isnan(value); });
}
bool HoldsNan(const uint32_t* /*row*/, int /*width*/) {
  return false;
}

bool BeginsWith(std::span<const uint8_t> bytes, const char (&magic)[8]) {
  return bytes.size() >= sizeof(magic) && std::memcmp(bytes.data(), magic, sizeof(magic)) == 0;
}

}  // namespace

KeptHistory KeptBy(const Settings& s) {
  return {GroupsOf(s.signals, false).size(), GroupsOf(s.signals, true).size(), LayoutOf(s),
          s.signals == SignalGrouping::kChannels};
}

bool IsHistoryOfCpu(std::span<const uint8_t> bytes) {
  return BeginsWith(bytes, kHistoryMagic);
}

Status CheckClaims(const HistoryClaims& claims, const KeptHistory& kept) {
  if (claims.width < 1 || claims.height < 1 || claims.width > 32768 || claims.height > 32768) {
    return Status::BadData(
        fmt::format("saved history claims a size of {}x{}", claims.width, claims.height));
  }
  if (claims.signals != kept.least && claims.signals != kept.most) {
    return Status::BadData(fmt::format("saved history has {} signals, the settings ask for {}",
                                       claims.signals, kept.least));
  }
  if (claims.by_channel != kept.by_channel) {
    return Status::BadData(
        fmt::format("saved history has signals of {}, the settings ask for those of {}",
                    claims.by_channel ? "channels" : "kinds of light",
                    kept.by_channel ? "channels" : "kinds of light"));
  }
  if (claims.layout.with_compressed != kept.layout.with_compressed) {
    return Status::BadData(fmt::format(
        "saved history was made with limit_history {}, the settings have it {}",
        claims.layout.with_compressed ? "on" : "off", kept.layout.with_compressed ? "on" : "off"));
  }
  if (claims.layout.with_behind != kept.layout.with_behind) {
    return Status::BadData(
        fmt::format("saved history was made with{} feedback_when=blend, the settings are with{} it",
                    claims.layout.with_behind ? "" : "out", kept.layout.with_behind ? "" : "out"));
  }
  if (!(claims.feedback_progress >= 0 && claims.feedback_progress <= 1)) {
    return Status::BadData("saved history has a feedback progress out of 0..1");
  }
  return Status::Ok();
}

Status CheckNormals(bool saved_octahedral, bool octahedral) {
  const auto name = [](bool packed) { return packed ? "octahedral" : "plain"; };
  return saved_octahedral == octahedral
             ? Status::Ok()
             : Status::BadData(fmt::format("saved history has {} normals, this denoiser keeps {} "
                                           "ones",
                                           name(saved_octahedral), name(octahedral)));
}

std::vector<uint8_t> HistoryToBytes(const History& state) {
  Header header;
  std::memcpy(header.magic, kHistoryMagic, sizeof(kHistoryMagic));
  header.width = state.width;
  header.height = state.height;
  for (const PlannedLayer& layer : state.list) {
    header.signal_count += static_cast<uint32_t>(layer.count);
  }
  header.flags =
      (state.progress.has_history ? 1u : 0u) | (state.progress.has_picture ? 2u : 0u) |
      (state.layout().with_compressed ? 4u : 0u) | (state.layout().with_behind ? 8u : 0u) |
      (state.held.empty() ? 0u : 16u) | (state.held.guides.id.empty() ? 0u : 32u) |
      (state.progress.jittered ? 64u : 0u) |
      (HasLayer(state.list, GuideSource::kReflection) ? 128u : 0u) |
      (HasLayer(state.list, GuideSource::kRefraction) ? 256u : 0u) |
      (state.progress.has_followed ? 512u : 0u) | (state.progress.has_albedo ? 4096u : 0u) |
      (state.list.count > 0 && state.list.layer[0].by_channel ? 1024u : 0u) |
      (!state.layers.empty() && state.layers.front().guides.packs_normals() ? 2048u : 0u);
  header.held_planes = PlanesOf(state.held);
  header.feedback_progress = state.progress.feedback_progress;
  header.residual_signals = ResidualsOf(state);
  std::vector<uint8_t> bytes(sizeof(Header));
  std::memcpy(bytes.data(), &header, sizeof(Header));
  bytes.reserve(sizeof(Header) + PayloadBytes(header));
  for (const LayerHistory& layer : state.layers) {
    for (const SignalHistory& signal : layer.signals) {
      const auto* scale = reinterpret_cast<const uint8_t*>(&signal.compressed_scale);
      bytes.insert(bytes.end(), scale, scale + sizeof(float));
    }
  }
  VisitPlanes(state, [&](const auto& plane) {
    for (int y = 0; y < plane.height(); ++y) {
      const auto* row = reinterpret_cast<const uint8_t*>(plane.Row(y));
      bytes.insert(bytes.end(), row, row + static_cast<size_t>(plane.width()) * 4);
    }
  });
  header.checksum = ChecksumOf(header, std::span(bytes).subspan(sizeof(Header)));
  std::memcpy(bytes.data(), &header, sizeof(Header));
  return bytes;
}

Result<History> HistoryFromBytes(std::span<const uint8_t> bytes, const Settings& settings) {
  if (BeginsWith(bytes, kDeviceHistoryMagic)) {
    return Status::BadData(
        "saved history was made on a Vulkan device, this denoiser works on the CPU");
  }
  Header header;
  const Header expected;
  if (bytes.size() < sizeof(Header)) {
    return Status::BadData(fmt::format("saved history has {} bytes, expected at least {}",
                                       bytes.size(), sizeof(Header)));
  }
  std::memcpy(&header, bytes.data(), sizeof(Header));
  if (!IsHistoryOfCpu(bytes) || header.version != expected.version ||
      header.byte_order != expected.byte_order) {
    return Status::BadData(
        "saved history was not written by this version of stillray on such a machine");
  }
  const HistoryLayout layout = {(header.flags & 4u) != 0, (header.flags & 8u) != 0};
  STILLRAY_RETURN_IF_ERROR(CheckClaims({header.width, header.height, header.signal_count, layout,
                                        header.feedback_progress, (header.flags & 1024u) != 0},
                                       KeptBy(settings)));
  const bool packs_normals = (header.flags & 2048u) != 0;
  STILLRAY_RETURN_IF_ERROR(CheckNormals(packs_normals, PacksNormals(settings.normals)));
  const Result<LayerList> layers = LayersOf(header, settings);
  STILLRAY_RETURN_IF_ERROR(layers.status());
  if (header.residual_signals >> header.signal_count != 0) {
    return Status::BadData(
        fmt::format("saved history names residuals of signals that do not exist: {:#x}",
                    header.residual_signals));
  }
  if (bytes.size() != sizeof(Header) + PayloadBytes(header)) {
    return Status::BadData(fmt::format("saved history has {} bytes, expected {}", bytes.size(),
                                       sizeof(Header) + PayloadBytes(header)));
  }
  if (ChecksumOf(header, bytes.subspan(sizeof(Header))) != header.checksum) {
    return Status::BadData("saved history is damaged: its checksum is another");
  }
  const int border = BorderOf(settings);
  History state(header.width, header.height, *layers, layout, border);
  state.progress.has_history = (header.flags & 1u) != 0;
  state.progress.has_picture = (header.flags & 2u) != 0;
  state.progress.jittered = (header.flags & 64u) != 0;
  for (LayerHistory& layer : state.layers) {
    layer.guides = GuidePlanes(header.width, header.height, border, packs_normals);
  }
  state.progress.feedback_progress = header.feedback_progress;
  MakeResiduals(header, &state.layers);
  state.progress.has_albedo = (header.flags & 4096u) != 0;
  if (state.progress.has_albedo) {
    state.albedo = Image3(header.width, header.height);
  }
  state.progress.has_followed = (header.flags & 512u) != 0;
  if (state.progress.has_followed) {
    state.followed = Image1(FollowSize(header.width), FollowSize(header.height));
  }
  if (!MakePlanes(header, &state.held)) {
    return Status::BadData(fmt::format(
        "saved history names planes of guides that do not exist: {:#x}", header.held_planes));
  }
  const uint8_t* from = bytes.data() + sizeof(Header);
  for (LayerHistory& layer : state.layers) {
    for (SignalHistory& signal : layer.signals) {
      std::memcpy(&signal.compressed_scale, from, sizeof(float));
      from += sizeof(float);
    }
  }
  bool any_nan = false;
  VisitPlanes(state, [&](auto& plane) {
    for (int y = 0; y < plane.height(); ++y) {
      const size_t row_bytes = static_cast<size_t>(plane.width()) * 4;
      std::memcpy(static_cast<void*>(plane.Row(y)), from, row_bytes);
      from += row_bytes;
      any_nan = any_nan || HoldsNan(plane.Row(y), plane.width());
    }
  });
  // A NaN would stay in the history forever. The denoiser never writes one.
  if (any_nan) {
    return Status::BadData("saved history holds values that are no numbers");
  }
  return state;
}

}  // namespace stillray
