// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/passes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/colour_shared.h"
#include "core/pixels.h"
#include "core/second_moments.h"
#include "denoise/plan.h"
#include "denoise/signal_groups.h"
#include "denoise/stages/select_guides.h"
#include "sequence/byte_blocks.h"
#include "sequence/memory.h"

namespace stillray {
namespace {

/// The output with the filtered, demodulated radiance of a signal.
constexpr const char* kFinalLight = "filtered";

const NamedImage* Find(const DenoisedFrame& denoised, const std::string& name) {
  const auto at = std::find_if(denoised.images.begin(), denoised.images.end(),
                               [&](const NamedImage& image) { return image.name == name; });
  return at == denoised.images.end() ? nullptr : &*at;
}

bool IsBlack(const Image3& image) {
  return !AnyPixel(image, [](float v) { return v > 0; });
}

/// The albedo that divides the layer, or nullptr if the layer includes it.
const Image3* DividedBy(const Frame& frame, const AovLayout& layout, const LightPart& part) {
  const bool divided =
      layout.light_is_divided && part.aov >= Aov::kDirectDiffuse && part.aov < Aov::kDirectVolume;
  if (!divided) {
    return nullptr;
  }
  return part.stored_albedo.empty() ? &AlbedoOf(frame.guides, part.kind) : &part.stored_albedo;
}

/// The member's fraction of the sum of estimates, 0..1. If all are zero, the last member gets
/// everything.
float Share(const std::vector<Image3>& estimates, size_t member, int c, int x, int y) {
  if (estimates.size() == 1) {
    return 1.0f;
  }
  float sum = 0;
  for (const Image3& estimate : estimates) {
    sum += std::max(estimate[c](x, y), 0.0f);
  }
  if (!(sum > 0) || !std::isfinite(sum)) {
    return member + 1 == estimates.size() ? 1.0f : 0.0f;
  }
  return std::max(estimates[member][c](x, y), 0.0f) / sum;
}

/// Smaller albedos are treated as black: radiance divided by them would exceed the range of halves.
constexpr float kLeastDivisor = 1e-3f;

/// Radiance as stored in a layer divided by albedo. It is zero on a black surface, although the
/// minimum divisor of albedo lets the filter leave a trace of its neighbours' radiance there.
float Divided(float seen, float colour) {
  return colour > 0 ? seen / std::max(colour, kLeastDivisor) : 0.0f;
}

/// Black surfaces get no radiance of other surfaces.
void TakeFromBlack(const Image3* stored, Image3* estimate) {
  if (stored == nullptr) {
    return;
  }
  ForEachPixel(estimate->width(), estimate->height(), [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      if (!((*stored)[c](x, y) > 0)) {
        (*estimate)[c](x, y) = 0;
      }
    }
  });
}

/// The guides of each signal, and its albedo: those of the visible surface, or of its virtual
/// image.
class SignalGuides {
 public:
  SignalGuides(const Frame& frame, const Settings& settings)
      : frame_(frame), settings_(settings), layers_(LayersOf(settings, FactsOf(frame))) {}

  /// \param signal    in the order of FramePlan::signals
  /// \param selected  [out] memory for guides that are not in the frame
  const Guides& Of(size_t signal, Guides* selected) const {
    const PlannedLayer& layer = *std::find_if(
        layers_.begin(), layers_.end(),
        [&](const PlannedLayer& l) { return signal >= l.first && signal < l.first + l.count; });
    const Guides& surface = frame_.guides;
    if (layer.guides == GuideSource::kSurface) {
      return surface;
    }
    cpu::SelectGuides({&surface, &ImageOf(frame_, layer.guides), &surface.roughness,
                       &SurfaceAlbedoOf(surface, layer.guides), &surface.previous_normal},
                      SelectGuidesOf(settings_, layer.guides), selected,
                      &SurfaceAlbedoOf(*selected, layer.guides));
    return *selected;
  }

 private:
  const Frame& frame_;
  const Settings& settings_;
  LayerList layers_;
};

/// Writes the parts of one signal.
/// \param guides  of the signal
/// \param light   the signal's filtered, demodulated radiance
void WriteLayers(const Frame& frame, const Guides& guides, const AovLayout& layout,
                 const std::vector<LightPart*>& members, const NamedImage& light,
                 const std::vector<Image3>& estimates, Image3* colour,
                 std::vector<NewLayer>* layers) {
  for (size_t i = 0; i < members.size(); ++i) {
    const LightPart& part = *members[i];
    if (part.aov == Aov::kColour) {
      continue;  // in no layer: only in the colour
    }
    const Image3& albedo = AlbedoOf(guides, part.kind);
    const Image3* stored = DividedBy(frame, layout, part);
    NewLayer layer{part.aov, Image3(frame.width, frame.height)};
    ForEachPixel(frame.width, frame.height, [&](int x, int y) {
      for (int c = 0; c < 3; ++c) {
        const float own =
            light.channels[static_cast<size_t>(c)](x, y) * Share(estimates, i, c, x, y);
        const bool divided = !albedo.empty() && std::isfinite(albedo[c](x, y));  // as remodulate
        const float seen = divided ? Remodulate(own, albedo[c](x, y)) : own;
        // Only the background behind volumes is filtered.
        const float unfiltered = part.aov == Aov::kBackground ? frame.background[c](x, y) : 0.0f;
        layer.values[c](x, y) = seen + unfiltered;
        if (stored != nullptr) {
          const float divisor = (*stored)[c](x, y);
          layer.values[c](x, y) = Divided(seen, divisor);
          // Removes radiance that no layer can represent.
          if (!(divisor >= kLeastDivisor)) {
            (*colour)[c](x, y) -= seen - layer.values[c](x, y) * (divisor > 0 ? divisor : 0.0f);
          }
        }
      }
    });
    layers->push_back(std::move(layer));
  }
}

}  // namespace

Status PassSplitter::Check(const Settings& settings, const AovLayout& layout) {
  const auto wrong = [](const char* name, const std::string& value, const char* expected) {
    return Status::InvalidArgument(
        fmt::format("--passes: {} is {}, expected {}", name, value, expected));
  };
  const auto value = [&](const char* name) { return GetParameter(settings, name).value(); };
  if (layout.from_colour) {
    return Status::InvalidArgument("--passes: the files have no light passes that could be used");
  }
  if (settings.signals != SignalGrouping::kSplit) {
    return wrong("signals", value("signals"), "split");
  }
  if (!settings.demodulate) {
    return wrong("demodulate", value("demodulate"), "on");
  }
  if (settings.firefly == Firefly::kCompress) {
    return wrong("firefly", value("firefly"), "off or clamp");
  }
  if (settings.antialias != Antialias::kOff) {
    return wrong("antialias", value("antialias"), "off: passes are not antialiased");
  }
  return Status::Ok();
}

PassSplitter::PassSplitter(const Settings& settings, const Device& device)
    : settings_(settings), device_(device) {}

std::vector<std::string> PassSplitter::Outputs() {
  return {kFinalLight};
}

Status PassSplitter::FilterPair(const Frame& frame, const Guides& guides, const std::string& name,
                                LightPart* first, LightPart* second,
                                std::vector<Image3>* estimates) {
  auto at = denoisers_.find(name);
  if (at == denoisers_.end()) {
    Result<Denoiser> made = Denoiser::Create(settings_, device_);
    if (!made.ok()) {
      return made.status();
    }
    at = denoisers_.emplace(name, std::move(made.value())).first;
  }
  Denoiser& denoiser = at->second;
  STILLRAY_RETURN_IF_ERROR(denoiser.SetOutputs({kFinalLight}));
  // Both replace diffuse signals, which the denoiser filters separately.
  Frame pair;
  pair.width = frame.width;
  pair.height = frame.height;
  pair.index = frame.index;
  pair.guides = guides;
  pair.guides.albedo = AlbedoOf(guides, first->kind);
  pair.guides.transmission_albedo = Image3();
  pair.samples = frame.samples;
  pair.confidence = frame.confidence;
  pair.signals.push_back({SignalKind::kDirectDiffuse, std::move(first->radiance), Image1()});
  if (second != nullptr) {
    pair.signals.push_back({SignalKind::kIndirectDiffuse, std::move(second->radiance), Image1()});
  }
  EstimateSecondMoments(&pair);
  DenoisedFrame denoised;
  STILLRAY_RETURN_IF_ERROR(denoiser.Denoise(pair, &denoised));
  constexpr const char* kPlaces[] = {"direct", "indirect"};
  for (size_t i = 0; i < pair.signals.size(); ++i) {
    const NamedImage* image = Find(denoised, fmt::format("{}.{}", kFinalLight, kPlaces[i]));
    if (image == nullptr) {
      return Status::Internal(fmt::format("the denoiser returned no {} light", kPlaces[i]));
    }
    Image3 estimate;
    for (int c = 0; c < 3; ++c) {
      estimate[c] = image->channels[static_cast<size_t>(c)];
    }
    estimates->push_back(std::move(estimate));
  }
  return Status::Ok();
}

/// Estimates the radiance of each member of a signal by filtering it separately. Starts with the
/// first frame that has radiance in two members.
Status PassSplitter::Estimate(const Frame& frame, const Guides& guides, const std::string& group,
                              const Members& members, std::vector<Image3>* estimates) {
  size_t lit = 0;
  for (const LightPart* part : members) {
    lit += IsBlack(part->radiance) ? 0 : 1;
  }
  if (members.size() == 1 || (lit < 2 && denoisers_.count(group + "0") == 0)) {
    for (LightPart* part : members) {
      estimates->push_back(std::move(part->radiance));
      if (lit == 1 && !IsBlack(estimates->back())) {
        for (int c = 0; c < 3; ++c) {
          estimates->back()[c].Fill(1.0f);
        }
      }
    }
    return Status::Ok();
  }
  for (size_t i = 0; i < members.size(); i += 2) {
    STILLRAY_RETURN_IF_ERROR(
        FilterPair(frame, guides, fmt::format("{}{}", group, i / 2), members[i],
                   i + 1 < members.size() ? members[i + 1] : nullptr, estimates));
  }
  return Status::Ok();
}

Status PassSplitter::Split(const Frame& frame, const AovLayout& layout,
                           std::vector<LightPart> parts, const DenoisedFrame& denoised,
                           Image3* colour, std::vector<NewLayer>* layers) {
  layers->clear();
  const SignalGuides signal_guides(frame, settings_);
  const std::span<const SignalGroup> groups =
      GroupsOf(SignalGrouping::kSplit, HasTransmission(frame));
  for (size_t signal = 0; signal < groups.size(); ++signal) {
    const SignalGroup& group = groups[signal];
    Members members;
    for (LightPart& part : parts) {
      if (std::find(group.kinds.begin(), group.kinds.end(), part.kind) != group.kinds.end()) {
        members.push_back(&part);
      }
    }
    if (members.empty()) {
      continue;
    }
    const NamedImage* light = Find(denoised, fmt::format("{}.{}", kFinalLight, group.name));
    if (light == nullptr) {
      return Status::Internal(fmt::format("the denoiser returned no {} light", group.name));
    }
    Guides selected;
    const Guides& guides = signal_guides.Of(signal, &selected);
    std::vector<Image3> estimates;
    STILLRAY_RETURN_IF_ERROR(Estimate(frame, guides, group.name, members, &estimates));
    for (size_t i = 0; i < members.size(); ++i) {
      TakeFromBlack(DividedBy(frame, layout, *members[i]), &estimates[i]);
    }
    WriteLayers(frame, guides, layout, members, *light, estimates, colour, layers);
  }
  return Status::Ok();
}

void PassSplitter::Reset() {
  for (auto& [name, denoiser] : denoisers_) {
    denoiser.Reset();
  }
}

size_t PassSplitter::memory_bytes() const {
  size_t bytes = 0;
  for (const auto& [name, denoiser] : denoisers_) {
    bytes += denoiser.memory_bytes();
  }
  return bytes;
}

DeviceMemory PassSplitter::device_memory() const {
  DeviceMemory sum;
  for (const auto& [name, denoiser] : denoisers_) {
    AddDeviceMemory(denoiser.device_memory(), &sum);
  }
  return sum;
}

Result<std::vector<uint8_t>> PassSplitter::SaveHistory() const {
  std::vector<uint8_t> bytes;
  for (const auto& [name, denoiser] : denoisers_) {
    AppendBlock(std::span(reinterpret_cast<const uint8_t*>(name.data()), name.size()), &bytes);
    const Result<std::vector<uint8_t>> history = denoiser.SaveHistory();
    STILLRAY_RETURN_IF_ERROR(history.status());
    AppendBlock(*history, &bytes);
  }
  return bytes;
}

Status PassSplitter::RestoreHistory(std::span<const uint8_t> bytes) {
  denoisers_.clear();
  while (!bytes.empty()) {
    std::span<const uint8_t> name;
    std::span<const uint8_t> history;
    if (!TakeBlock(&bytes, &name) || !TakeBlock(&bytes, &history)) {
      return Status::BadData("the history of the light passes is cut short");
    }
    Result<Denoiser> denoiser = Denoiser::Create(settings_, device_);
    if (!denoiser.ok()) {
      return denoiser.status();
    }
    STILLRAY_RETURN_IF_ERROR(denoiser->RestoreHistory(history));
    denoisers_.emplace(std::string(name.begin(), name.end()), std::move(denoiser.value()));
  }
  return Status::Ok();
}

}  // namespace stillray
