// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/layered_denoiser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/guides.h"
#include "core/parallel.h"
#include "denoise/fill_guides/fill_guides.h"
#include "denoise/picture_motion.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/rescaled_moment_shared.h"
#include "denoise/stage_timer.h"
#include "denoise/stages/select_guides.h"

namespace stillray {
namespace {

/// The virtual images that may have a layer.
constexpr GuideSource kImages[] = {GuideSource::kReflection, GuideSource::kRefraction};
constexpr size_t kImageCount = 2;

const PlannedLayer* LayerOf(const LayerList& list, GuideSource source) {
  const auto* at = std::find_if(list.begin(), list.end(),
                                [&](const PlannedLayer& layer) { return layer.guides == source; });
  return at == list.end() ? nullptr : at;
}

/// Second moments that were divided by the square of one albedo's luminance, for another albedo.
Image1 RescaledMoments(const Signal& signal, const Image3& own, const Image3& albedo) {
  Image1 moment(signal.second_moment.width(), signal.second_moment.height());
  const auto at = [](const Image3& image, int x, int y) {
    return image.empty() ? vec3(1.0f) : vec3(image[0](x, y), image[1](x, y), image[2](x, y));
  };
  ParallelRows(moment.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < moment.width(); ++x) {
        moment(x, y) = RescaledMoment(signal.second_moment(x, y), at(signal.radiance, x, y),
                                      at(own, x, y), at(albedo, x, y));
      }
    }
  });
  return moment;
}

void AddTo(const Image3& more, Image3* sum) {
  for (int c = 0; c < 3; ++c) {
    ParallelRows(more.height(), 32, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        const float* from = more[c].Row(y);
        float* to = (*sum)[c].Row(y);
        for (int x = 0; x < more.width(); ++x) {
          to[x] += from[x];
        }
      }
    });
  }
}

/// The light of a layer with its selected guides, as a frame.
Frame MakeLayerFrame(const Frame& frame, GuideSource source, const Settings& settings) {
  Frame layer;
  layer.width = frame.width;
  layer.height = frame.height;
  layer.index = frame.index;
  layer.jitter_x = frame.jitter_x;
  layer.jitter_y = frame.jitter_y;
  layer.focal_pixels = frame.focal_pixels;
  layer.samples = frame.samples;
  layer.confidence = frame.confidence;
  const Guides& g = frame.guides;
  const Image3& own = SurfaceAlbedoOf(g, source);
  Image3& albedo = SurfaceAlbedoOf(layer.guides, source);
  cpu::SelectGuides({&g, &ImageOf(frame, source), &g.roughness, &own, &g.previous_normal},
                    SelectGuidesOf(settings, source), &layer.guides, &albedo);
  for (const Signal& signal : frame.signals) {
    if (IsLightOf(source, signal.kind)) {
      Signal& copy = layer.signals.emplace_back(signal);
      if (!signal.second_moment.empty()) {
        copy.second_moment = RescaledMoments(signal, own, albedo);
      }
    }
  }
  return layer;
}

/// Adds counts and times of a layer.
void AddCounts(const DenoisedFrame& layer, DenoisedFrame* out) {
  out->non_finite += layer.non_finite;
  out->negative += layer.negative;
  out->bad_guides += layer.bad_guides;
  for (const StageTime& timing : layer.timings) {
    AddTime(timing, &out->timings);
  }
}

/// The end of the names of a layer's outputs.
std::string SignalOf(GuideSource source) {
  return source == GuideSource::kReflection ? ".specular" : ".transmission";
}

/// "noisy.specular" is "noisy.light" in the layer.
std::string NameInLayer(const std::string& name) {
  return name.substr(0, name.find('.')) + ".light";
}

/// Whether an output is a picture of all light before the last stages.
bool IsPicture(const std::string& name) {
  return name == "temporal" || name.starts_with("atrous");
}

/// Puts the images of a layer in place of those that `out` has without its light. Its pictures hold
/// the layer's finished light, as emission.
void MergeOutputs(GuideSource source, const DenoisedFrame& layer, DenoisedFrame* out) {
  for (NamedImage& image : out->images) {
    const bool picture = IsPicture(image.name);
    if (!picture && !image.name.ends_with(SignalOf(source))) {
      continue;
    }
    const std::string name = picture ? image.name : NameInLayer(image.name);
    const auto found = std::find_if(layer.images.begin(), layer.images.end(),
                                    [&](const NamedImage& i) { return i.name == name; });
    if (found == layer.images.end()) {
      continue;
    }
    if (!picture) {
      image.channels = found->channels;
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      Image1& sum = image.channels[static_cast<size_t>(c)];
      const Image1& part = found->channels[static_cast<size_t>(c)];
      for (int y = 0; y < sum.height(); ++y) {
        for (int x = 0; x < sum.width(); ++x) {
          sum(x, y) += part(x, y) - layer.colour[c](x, y);
        }
      }
    }
  }
}

class LayeredDenoiser : public DenoiserBackend {
 public:
  LayeredDenoiser(const Settings& settings, DevicePrecision precision,
                  std::shared_ptr<DeviceBackend> device, std::unique_ptr<DenoiserBackend> main)
      : settings_(settings),
        precision_(precision),
        device_(std::move(device)),
        main_(std::move(main)) {}

  Status Denoise(const Frame& frame, std::span<const SignalHistory> future,
                 DenoisedFrame* out) override;
  Status Accumulate(const Frame& frame, std::vector<SignalHistory>* future) override;
  Status SetSettings(const Settings& settings) override;
  void SetResults(const Results& wanted) override { main_->SetResults(wanted); }
  Status ReadColour(Image3* colour) override { return main_->ReadColour(colour); }
  void SetOutputs(std::vector<std::string> names) override;
  void Reset() override;
  size_t memory_bytes() const override;
  DeviceMemory device_memory() const override;
  Result<std::vector<uint8_t>> SaveHistory() override;
  Status RestoreHistory(std::span<const uint8_t> bytes) override;

 private:
  Status Begin(const Frame& frame);
  Status PrepareSplit(const Frame& frame);
  Status DenoiseOnDevice(const Frame& frame, std::span<const SignalHistory> future,
                         DenoisedFrame* out);
  Status DenoiseOnHost(const Frame& frame, std::span<const SignalHistory> future,
                       DenoisedFrame* out);
  void AddLayers(const std::array<DenoisedFrame, kImageCount>& pictures, DenoisedFrame* out) const;
  std::vector<std::string> OutputsOfLayer(size_t image) const;
  Status MakeLayer(size_t image);
  Frame WithoutLayers(const Frame& frame) const;
  std::vector<SignalHistory> FutureWithoutLayers(const Frame& frame,
                                                 std::span<const SignalHistory> future) const;

  Settings settings_;
  DevicePrecision precision_;
  std::shared_ptr<DeviceBackend> device_;
  std::unique_ptr<DenoiserBackend> main_;
  std::vector<std::string> outputs_;
  std::array<std::unique_ptr<DenoiserBackend>, kImageCount> layer_;  ///< made when they are needed
  std::unique_ptr<FrameSplit> split_;  ///< nullptr unless the last frame was split on the device
  LayerList list_;                     ///< of the last frame
  Frame from_device_;                  ///< host copy of a frame on another device
};

/// Restarts the histories if the layers differ from those of the last frame.
Status LayeredDenoiser::Begin(const Frame& frame) {
  const LayerList list = LayersOf(settings_, FactsOf(frame));
  if (list != list_ && (list.count > 1 || list_.count > 1)) {
    Reset();
  }
  list_ = list;
  for (size_t i = 0; i < kImageCount; ++i) {
    if (LayerOf(list_, kImages[i]) == nullptr) {
      layer_[i].reset();
    } else if (layer_[i] == nullptr) {
      STILLRAY_RETURN_IF_ERROR(MakeLayer(i));
    }
  }
  return Status::Ok();
}

Status LayeredDenoiser::MakeLayer(size_t image) {
  Result<std::unique_ptr<DenoiserBackend>> made =
      device_->CreateDenoiser(SettingsOfLayer(settings_), precision_);
  STILLRAY_RETURN_IF_ERROR(made.status());
  layer_[image] = std::move(made.value());
  layer_[image]->SetOutputs(OutputsOfLayer(image));
  return Status::Ok();
}

void LayeredDenoiser::SetOutputs(std::vector<std::string> names) {
  outputs_ = std::move(names);
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] != nullptr) {
      layer_[i]->SetOutputs(OutputsOfLayer(i));
    }
  }
  main_->SetOutputs(outputs_);
}

/// The outputs of a layer that are part of those requested.
std::vector<std::string> LayeredDenoiser::OutputsOfLayer(size_t image) const {
  std::vector<std::string> names;
  for (const std::string& name : outputs_) {
    if (IsPicture(name)) {
      names.push_back(name);
    } else if (name.ends_with(SignalOf(kImages[image]))) {
      names.push_back(NameInLayer(name));
    }
  }
  return names;
}

/// The frame without the light of its layers, and without their guides. Signals stay, so that all
/// frames have the same ones, but are black.
Frame LayeredDenoiser::WithoutLayers(const Frame& frame) const {
  Frame rest = frame;
  for (size_t i = 0; i < kImageCount; ++i) {
    for (Signal& signal : rest.signals) {
      if (layer_[i] != nullptr && IsLightOf(kImages[i], signal.kind)) {
        signal.radiance = Image3(frame.width, frame.height);
        signal.second_moment = Image1();
      }
    }
  }
  rest.reflection = rest.refraction = VirtualGuides();
  if (rest.emission.empty()) {
    rest.emission = Image3(frame.width, frame.height);
  }
  return rest;
}

/// The light of the future without that of the layers.
std::vector<SignalHistory> LayeredDenoiser::FutureWithoutLayers(
    const Frame& frame, std::span<const SignalHistory> future) const {
  std::vector<SignalHistory> rest(future.begin(), future.end());
  for (const PlannedLayer& layer : list_) {
    if (layer.guides != GuideSource::kSurface && !rest.empty()) {
      rest[layer.first] = SignalHistory(frame.width, frame.height);
    }
  }
  return rest;
}

/// Makes `split_` for frames with layers that stay on the device, else releases it.
Status LayeredDenoiser::PrepareSplit(const Frame& frame) {
  if (list_.count <= 1 || !device_->Holds(frame)) {
    split_.reset();
  } else if (split_ == nullptr) {
    Result<std::unique_ptr<FrameSplit>> made = device_->CreateFrameSplit();
    STILLRAY_RETURN_IF_ERROR(made.status());
    split_ = std::move(made.value());
  }
  return Status::Ok();
}

Status LayeredDenoiser::Denoise(const Frame& frame, std::span<const SignalHistory> future,
                                DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(Begin(frame));
  STILLRAY_RETURN_IF_ERROR(PrepareSplit(frame));
  if (list_.count <= 1) {
    return main_->Denoise(frame, future, out);
  }
  if (split_ != nullptr) {
    return DenoiseOnDevice(frame, future, out);
  }
  const Result<const Frame*> host = OnHost(frame, &from_device_);
  STILLRAY_RETURN_IF_ERROR(host.status());
  return DenoiseOnHost(**host, future, out);
}

Status LayeredDenoiser::DenoiseOnDevice(const Frame& frame, std::span<const SignalHistory> future,
                                        DenoisedFrame* out) {
  std::array<DenoisedFrame, kImageCount> pictures;
  std::vector<Frame> layers;  // until the rest has been denoised
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] == nullptr) {
      continue;
    }
    const PlannedLayer& planned = *LayerOf(list_, kImages[i]);
    Result<Frame> layer = split_->MakeLayer(frame, kImages[i], settings_);
    STILLRAY_RETURN_IF_ERROR(layer.status());
    // On the host only for MergeOutputs.
    layer_[i]->SetResults({.colour = !outputs_.empty()});
    STILLRAY_RETURN_IF_ERROR(layer_[i]->Denoise(
        *layer, future.empty() ? future : future.subspan(planned.first, planned.count),
        &pictures[i]));
    layers.push_back(std::move(*layer));
  }
  const Result<Frame> rest = split_->MakeRest(frame);
  STILLRAY_RETURN_IF_ERROR(rest.status());
  STILLRAY_RETURN_IF_ERROR(main_->Denoise(*rest, FutureWithoutLayers(frame, future), out));
  split_->AddTimes(&out->timings);
  AddLayers(pictures, out);
  return Status::Ok();
}

Status LayeredDenoiser::DenoiseOnHost(const Frame& frame, std::span<const SignalHistory> future,
                                      DenoisedFrame* out) {
  Frame rest = WithoutLayers(frame);
  std::array<DenoisedFrame, kImageCount> pictures;
  std::array<Image1, kImageCount> images;
  const bool fills_guides = settings_.fill_guides && HasIncompleteGuides(frame);
  const bool sums_images = SumsImageAlbedo(FactsOf(frame).albedos, fills_guides);
  const bool uses_lengths = UsesImageLengths(settings_, fills_guides);
  Image1 length = uses_lengths ? Image1(frame.width, frame.height) : Image1();
  ShownImages shown;
  shown.length = uses_lengths ? &length : nullptr;
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] == nullptr) {
      continue;
    }
    const PlannedLayer& planned = *LayerOf(list_, kImages[i]);
    const Frame of_layer = MakeLayerFrame(frame, kImages[i], settings_);
    layer_[i]->SetResults(Results());
    FindImages(frame.guides, of_layer.guides, SurfaceAlbedoOf(frame.guides, kImages[i]),
               OtherAlbedoOf(frame.guides, kImages[i]), &images[i]);
    FollowImages(images[i], frame.guides, of_layer.guides.motion, &rest.guides.motion);
    STILLRAY_RETURN_IF_ERROR(layer_[i]->Denoise(
        of_layer, future.empty() ? future : future.subspan(planned.first, planned.count),
        &pictures[i]));
    AddTo(pictures[i].colour, &rest.emission);
    if (uses_lengths) {
      Image1 of_layer_length;
      STILLRAY_RETURN_IF_ERROR(layer_[i]->ReadLength(&of_layer_length));
      TakeLengths(images[i], of_layer_length, &length);
    }
    if (kImages[i] == GuideSource::kReflection && sums_images) {
      // For sum_albedo alone: the rest has no light that it divides.
      rest.guides.specular_albedo = of_layer.guides.specular_albedo;
      shown.depth = &images[i];
    }
  }
  const std::vector<SignalHistory> of_rest = FutureWithoutLayers(frame, future);
  main_->ShowImages(shown);
  const Status denoised = main_->Denoise(rest, of_rest, out);
  main_->ShowImages({});
  STILLRAY_RETURN_IF_ERROR(denoised);
  AddLayers(pictures, out);
  return Status::Ok();
}

/// Adds counts, times and outputs of the layers.
void LayeredDenoiser::AddLayers(const std::array<DenoisedFrame, kImageCount>& pictures,
                                DenoisedFrame* out) const {
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] != nullptr) {
      AddCounts(pictures[i], out);
      MergeOutputs(kImages[i], pictures[i], out);
    }
  }
}

/// Takes frames with layers over the host: frames whose future is used are kept there.
Status LayeredDenoiser::Accumulate(const Frame& given, std::vector<SignalHistory>* future) {
  STILLRAY_RETURN_IF_ERROR(Begin(given));
  if (list_.count <= 1) {
    return main_->Accumulate(given, future);
  }
  const Result<const Frame*> host = OnHost(given, &from_device_);
  STILLRAY_RETURN_IF_ERROR(host.status());
  const Frame& frame = **host;
  STILLRAY_RETURN_IF_ERROR(main_->Accumulate(WithoutLayers(frame), future));
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] != nullptr) {
      std::vector<SignalHistory> of_layer;
      STILLRAY_RETURN_IF_ERROR(
          layer_[i]->Accumulate(MakeLayerFrame(frame, kImages[i], settings_), &of_layer));
      (*future)[LayerOf(list_, kImages[i])->first] = std::move(of_layer.front());
    }
  }
  return Status::Ok();
}

Status LayeredDenoiser::SetSettings(const Settings& settings) {
  settings_ = settings;
  for (std::unique_ptr<DenoiserBackend>& layer : layer_) {
    if (layer != nullptr) {
      STILLRAY_RETURN_IF_ERROR(layer->SetSettings(SettingsOfLayer(settings)));
    }
  }
  return main_->SetSettings(settings);
}

void LayeredDenoiser::Reset() {
  main_->Reset();
  for (std::unique_ptr<DenoiserBackend>& layer : layer_) {
    if (layer != nullptr) {
      layer->Reset();
    }
  }
}

size_t LayeredDenoiser::memory_bytes() const {
  size_t sum = main_->memory_bytes() + (split_ != nullptr ? split_->memory().bytes : 0);
  for (const std::unique_ptr<DenoiserBackend>& layer : layer_) {
    sum += layer != nullptr ? layer->memory_bytes() : 0;
  }
  return sum;
}

DeviceMemory LayeredDenoiser::device_memory() const {
  DeviceMemory sum = main_->device_memory();
  const auto add = [&](const DeviceMemory& more) {
    sum.allocations += more.allocations;
    sum.resources += more.resources;
    sum.bytes += more.bytes;
    sum.largest = std::max(sum.largest, more.largest);
  };
  for (const std::unique_ptr<DenoiserBackend>& layer : layer_) {
    if (layer != nullptr) {
      add(layer->device_memory());
    }
  }
  if (split_ != nullptr) {
    add(split_->memory());
  }
  return sum;
}

// Saved histories: that of `main`; with layers also those of the layers, behind it, then a trailer
// with their sizes.
struct Trailer {
  uint64_t main_bytes = 0;
  uint64_t layer_bytes[kImageCount] = {};
  char magic[8] = {'l', 'a', 'y', 'e', 'r', 's', '0', '1'};
};

Result<std::vector<uint8_t>> LayeredDenoiser::SaveHistory() {
  Result<std::vector<uint8_t>> bytes = main_->SaveHistory();
  if (!bytes.ok() || list_.count <= 1) {
    return bytes;
  }
  Trailer trailer;
  trailer.main_bytes = bytes->size();
  for (size_t i = 0; i < kImageCount; ++i) {
    if (layer_[i] != nullptr) {
      const Result<std::vector<uint8_t>> of_layer = layer_[i]->SaveHistory();
      STILLRAY_RETURN_IF_ERROR(of_layer.status());
      trailer.layer_bytes[i] = of_layer->size();
      bytes->insert(bytes->end(), of_layer->begin(), of_layer->end());
    }
  }
  const auto* end = reinterpret_cast<const uint8_t*>(&trailer);
  bytes->insert(bytes->end(), end, end + sizeof(trailer));
  return bytes;
}

Status LayeredDenoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  Trailer trailer;
  const Trailer expected;
  const bool long_enough = bytes.size() >= sizeof(trailer);
  if (long_enough) {
    std::memcpy(&trailer, bytes.data() + bytes.size() - sizeof(trailer), sizeof(trailer));
  }
  if (!long_enough || std::memcmp(trailer.magic, expected.magic, sizeof(trailer.magic)) != 0) {
    STILLRAY_RETURN_IF_ERROR(main_->RestoreHistory(bytes));
    layer_ = {};
    list_ = LayerList();
    return Status::Ok();
  }
  const size_t room = bytes.size() - sizeof(trailer);
  const bool fits = trailer.main_bytes <= room && trailer.layer_bytes[0] <= room &&
                    trailer.layer_bytes[1] <= room &&
                    trailer.main_bytes + trailer.layer_bytes[0] + trailer.layer_bytes[1] == room;
  if (!fits) {
    return Status::BadData("saved history is damaged: the sizes of its layers do not fit");
  }
  FrameFacts facts;
  facts.has_reflection = trailer.layer_bytes[0] > 0;
  facts.has_refraction = trailer.layer_bytes[1] > 0;
  if (facts.has_refraction) {
    facts.lights = 1u << static_cast<uint32_t>(SignalKind::kDirectTransmission);
  }
  size_t begin = trailer.main_bytes;
  for (size_t i = 0; i < kImageCount; ++i) {
    layer_[i].reset();
    if (trailer.layer_bytes[i] > 0) {
      STILLRAY_RETURN_IF_ERROR(MakeLayer(i));
      STILLRAY_RETURN_IF_ERROR(
          layer_[i]->RestoreHistory(bytes.subspan(begin, trailer.layer_bytes[i])));
      begin += trailer.layer_bytes[i];
    }
  }
  list_ = LayersOf(settings_, facts);
  return main_->RestoreHistory(bytes.first(trailer.main_bytes));
}

}  // namespace

std::unique_ptr<DenoiserBackend> MakeLayeredDenoiser(const Settings& settings,
                                                     DevicePrecision precision,
                                                     std::shared_ptr<DeviceBackend> device,
                                                     std::unique_ptr<DenoiserBackend> main) {
  return std::make_unique<LayeredDenoiser>(settings, precision, std::move(device), std::move(main));
}

}  // namespace stillray
