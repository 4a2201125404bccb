// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Converts a file's layers to a Frame whose signals, emission and background sum to the file's
// colour.
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/guides.h"
#include "core/pixels.h"
#include "core/second_moments.h"
#include "io/aov_albedo.h"
#include "io/aov_importer.h"
#include "io/aov_samples.h"
#include "io/aov_seen.h"
#include "io/curved_images.h"
#include "io/fill_depth.h"
#include "io/hit_guides.h"
#include "io/light_confidence.h"
#include "io/mixed_motion.h"
#include "io/text.h"

namespace stillray::io {
namespace {

/// All numbers of a text attribute.
std::vector<float> Numbers(const std::map<std::string, std::string>& attributes,
                           const std::string& name) {
  std::vector<float> numbers;
  const auto at = attributes.find(name);
  if (at == attributes.end()) {
    return numbers;
  }
  const char* begin = at->second.data();
  const char* end = begin + at->second.size();
  while (begin < end) {
    float number = 0;
    const auto [stop, error] = std::from_chars(begin, end, number);
    if (error != std::errc() || !std::isfinite(number)) {
      break;
    }
    numbers.push_back(number);
    begin = stop;
    while (begin < end && *begin == ' ') {
      ++begin;
    }
  }
  return numbers;
}

bool IsNotZero(float value) {
  return value != 0;
}

bool HasLight(const Image3& light) {
  return AnyPixel(light, IsNotZero);
}

}  // namespace

Status Importer::CheckChannels() const {
  for (const AovSource& source : layout_.sources) {
    for (const std::string& channel : source.channels) {
      if (image_.Find(channel) == nullptr) {
        return Status::BadData(
            fmt::format("{}: has no channel {}, which serves as {} in the first frame", name_,
                        OneLine(channel), AovName(source.aov)));
      }
    }
  }
  const AovSource* samples = layout_.Find(Aov::kSamples);
  if (samples != nullptr && HoldsFractions(*samples) && CyclesSamples(image_, *samples) == 0) {
    return Status::BadData(fmt::format("{}: has no usable attribute {}, which the first frame has",
                                       name_, OneLine(SamplesAttribute(*samples))));
  }
  if (layout_.motion_from_cameras && !CameraOf(image_)) {
    return Status::BadData(fmt::format(
        "{}: has no usable worldToCamera and worldToNDC, which the first frame has", name_));
  }
  return Status::Ok();
}

Image1 Importer::Values(const std::string& name) const {
  const Channel& channel = *image_.Find(name);
  if (channel.type != PixelType::kUint32) {
    return channel.values;
  }
  Image1 values(image_.width, image_.height);
  ForEachPixel(image_.width, image_.height,
               [&](int x, int y) { values(x, y) = static_cast<float>(channel.integers(x, y)); });
  return values;
}

std::optional<Image1> Importer::Plane1(Aov aov) const {
  const AovSource* source = layout_.Find(aov);
  if (source == nullptr) {
    return std::nullopt;
  }
  return Values(source->channels[0]);
}

/// Empty if the layout lacks the layer.
Image3 Importer::Colour(Aov aov) const {
  Image3 image;
  if (const AovSource* source = layout_.Find(aov)) {
    for (int c = 0; c < 3; ++c) {
      image[c] = Values(source->channels[static_cast<size_t>(c)]);
    }
  }
  return image;
}

void Importer::ImportJitter() {
  const std::vector<float> jitter = Numbers(image_.attributes, "jitter");
  if (jitter.size() == 2 && std::fabs(jitter[0]) <= 0.5f && std::fabs(jitter[1]) <= 0.5f) {
    frame_.jitter_x = jitter[0];
    frame_.jitter_y = jitter[1];
  }
}

/// From stillray's own attribute, the matrices of the camera, or the convention of the depth.
void Importer::ImportFocalLength() {
  const std::vector<float> given = Numbers(image_.attributes, "focal_pixels");
  if (given.size() == 1 && given[0] > 0) {
    frame_.focal_pixels = given[0];
  } else if (const auto camera = CameraOf(image_)) {
    frame_.focal_pixels =
        static_cast<float>(CentredFocalPixels(*camera, frame_.width, frame_.height));
  } else {
    frame_.focal_pixels = layout_.depth.focal;
  }
}

void Importer::ImportNormal() {
  Guides& g = frame_.guides;
  const Image3 stored = Colour(Aov::kNormal);
  if (stored.empty()) {
    g.normal = FlatNormal(frame_.width, frame_.height);
    return;
  }
  const std::vector<float> m = Numbers(image_.other_attributes, "worldToCamera");
  std::array<float, 9> rotation{};
  if (m.size() == 16) {
    rotation = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
  }
  g.normal = ConvertNormal(stored, layout_.normal, m.size() == 16 ? &rotation : nullptr);
}

/// Adds 1 to ids: a surface of the file may have the id 0, which means "no surface" in Guides.
void Importer::ImportId() {
  const AovSource* source = layout_.Find(Aov::kId);
  const bool matte = source == nullptr && layout_.Find(Aov::kCryptomatte) != nullptr;
  if (source == nullptr && !matte) {
    return;
  }
  Plane<uint32_t>& id = frame_.guides.id;
  const Channel& channel =
      *image_.Find(matte ? layout_.Find(Aov::kCryptomatte)->channels[0] : source->channels[0]);
  if (channel.type == PixelType::kUint32) {
    id = channel.integers;
    return;
  }
  constexpr float kLargest = 4e9f;
  id = Plane<uint32_t>(frame_.width, frame_.height);
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    const float value = channel.values(x, y);
    if (!std::isfinite(frame_.guides.depth(x, y))) {
      id(x, y) = 0;
    } else if (matte) {
      id(x, y) = std::bit_cast<uint32_t>(value);
    } else {
      id(x, y) = value >= 0 && value < kLargest ? static_cast<uint32_t>(std::lround(value)) + 1 : 0;
    }
  });
}

void Importer::ImportGuides(std::array<float, 2> previous_jitter) {
  Guides& g = frame_.guides;
  if (const std::optional<Image1> depth = Plane1(Aov::kDepth)) {
    g.depth = ConvertDepth(*depth, layout_.depth);
  } else {
    g.depth = FlatDepth(frame_.width, frame_.height);
  }
  ImportNormal();
  if (const AovSource* motion = layout_.Find(Aov::kMotion)) {
    g.motion =
        ConvertMotion(Values(motion->channels[0]), Values(motion->channels[1]), layout_.motion,
                      {frame_.jitter_x, frame_.jitter_y, previous_jitter[0], previous_jitter[1]});
  } else if (layout_.motion_from_cameras) {
    g.motion = Image2(frame_.width, frame_.height);
  }
  ImportId();
  if (const Image3 previous = Colour(Aov::kPreviousNormal); !previous.empty()) {
    g.previous_normal = ConvertNormal(previous, layout_.normal, nullptr);
  }
  if (std::optional<Image1> roughness = Plane1(Aov::kRoughness)) {
    g.roughness = std::move(*roughness);
  }
  if (std::optional<Image1> samples = Plane1(Aov::kSamples)) {
    const AovSource& source = *layout_.Find(Aov::kSamples);
    if (HoldsFractions(source)) {
      ToCounts(CyclesSamples(image_, source), &*samples);
    }
    frame_.samples = std::move(*samples);
  } else if (layout_.samples > 1) {
    frame_.samples = Image1(frame_.width, frame_.height);
    frame_.samples.Fill(static_cast<float>(layout_.samples));
  }
  if (std::optional<Image1> confidence = Plane1(Aov::kConfidence)) {
    frame_.confidence = std::move(*confidence);
  }
}

void Importer::ImportAlbedo() {
  Guides& g = frame_.guides;
  const bool fallback = layout_.from_colour && layout_.Find(Aov::kFallbackAlbedo) != nullptr;
  g.albedo = Colour(fallback ? Aov::kFallbackAlbedo : Aov::kAlbedo);
  if (g.albedo.empty()) {
    g.albedo = WhiteAlbedo(frame_.width, frame_.height);
  } else if (fallback && layout_.Find(Aov::kFallbackNormal) && layout_.Find(Aov::kNormal)) {
    const Image3 normal = layout_.normal.encoded ? g.normal : Colour(Aov::kNormal);
    RejectRandomAlbedo(normal, Colour(Aov::kFallbackNormal), &g.albedo);
  } else if (layout_.from_colour && !fallback) {
    AddAlbedo(Colour(Aov::kSpecularAlbedo), layout_.specular_weight, &g.albedo);
    AddAlbedo(Colour(Aov::kTransmissionAlbedo), 1, &g.albedo);
  }
  g.specular_albedo = Colour(Aov::kSpecularAlbedo);
  if (g.specular_albedo.empty()) {
    g.specular_albedo = WhiteAlbedo(frame_.width, frame_.height);
  }
  g.transmission_albedo = Colour(Aov::kTransmissionAlbedo);
}

/// Numbers of surfaces, unchanged.
Plane<uint32_t> Importer::Ids(const Channel& channel) const {
  if (channel.type == PixelType::kUint32) {
    return channel.integers;
  }
  constexpr float kLargest = 4e9f;
  Plane<uint32_t> ids(frame_.width, frame_.height);
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    const float value = channel.values(x, y);
    ids(x, y) = value >= 0 && value < kLargest ? static_cast<uint32_t>(std::lround(value)) : 0;
  });
  return ids;
}

/// Layers of virtual guides; all empty without a depth.
VirtualGuides Importer::VirtualGuidesOf(Aov depth, Aov normal, Aov albedo, Aov motion, Aov id,
                                        const JitterPair& jitter) const {
  VirtualGuides guides;
  const std::optional<Image1> stored = Plane1(depth);
  if (!stored) {
    return guides;
  }
  guides.depth = ConvertDepth(*stored, layout_.depth);
  if (layout_.Find(normal) != nullptr) {
    guides.normal = ConvertNormal(Colour(normal), layout_.normal, nullptr);
  }
  guides.albedo = Colour(albedo);
  if (const AovSource* source = layout_.Find(motion)) {
    guides.motion = ConvertMotion(Values(source->channels[0]), Values(source->channels[1]),
                                  layout_.motion, jitter);
  } else {
    guides.motion = frame_.guides.motion;
  }
  if (const AovSource* source = layout_.Find(id)) {
    guides.id = Ids(*image_.Find(source->channels[0]));
  }
  return guides;
}

/// From the first source available: the user's value, the camera, a fit of depth to normals or to
/// path lengths.
std::optional<Lens> Importer::LensOfRays(CameraFits* fits) const {
  if (layout_.hit_distance.focal > 0) {
    return LensOfFocalLength(static_cast<double>(layout_.hit_distance.focal), frame_.width);
  }
  const std::optional<CameraMatrices> stored = CameraOf(image_);
  for (const CameraMatrices* camera : {camera_, stored ? &*stored : nullptr}) {
    const std::optional<Lens> lens =
        camera != nullptr ? LensOfCamera(*camera, frame_.width, frame_.height) : std::nullopt;
    if (lens) {
      return lens;
    }
  }
  if (frame_.focal_pixels > 0) {
    return LensOfFocalLength(static_cast<double>(frame_.focal_pixels), frame_.width);
  }
  if (const std::optional<View>& view = fits->FieldOfView()) {
    return LensOfFocalLength(0.5 * frame_.width / view->tangent, frame_.width);
  }
  const std::optional<Image1> seen = Plane1(Aov::kSeenDepth);
  std::optional<Lens> lens = seen ? FitLens(frame_.guides.depth, *seen) : std::nullopt;
  if (lens) {
    lens->start = 0;  // hit distances begin at the surface
  }
  return lens;
}

/// Virtual guides from hit distances, in place of those from the kSeen layers.
void Importer::ImportHits(CameraFits* fits, FrameImages* images) {
  const std::optional<Lens> lens = LensOfRays(fits);
  if (lens) {
    images->missing = NoSeenGuides::kNone;
    SetHitGuides({ConvertHitDistance(*Plane1(Aov::kHitDistance), layout_.hit_distance),
                  Plane1(Aov::kSeenDepth).value_or(Image1()), Colour(Aov::kSeenNormal),
                  Colour(Aov::kSeenAlbedo)},
                 *lens, &frame_, images);
  } else if (frame_.reflection.empty()) {
    images->missing = NoSeenGuides::kFocal;
  }
}

/// The motion of reflections as stored; unknown (outside the image) where it is not finite.
void Importer::ImportSpecularMotion(const JitterPair& jitter) {
  const AovSource& source = *layout_.Find(Aov::kSpecularMotion);
  const Image2 stored = ConvertMotion(Values(source.channels[0]), Values(source.channels[1]),
                                      layout_.specular_motion, jitter);
  const vec2 unknown = UnknownMotion(frame_.width, frame_.height);
  Image2& motion = frame_.reflection.motion;
  motion = Image2(frame_.width, frame_.height);
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    const bool is_known = std::isfinite(stored[0](x, y) + stored[1](x, y));
    motion[0](x, y) = is_known ? stored[0](x, y) : unknown.x;
    motion[1](x, y) = is_known ? stored[1](x, y) : unknown.y;
  });
}

/// Virtual guides from hit distances, from the kSeen layers, and from the shape of convex surfaces.
void Importer::ImportImages(const JitterPair& jitter) {
  CameraFits fits(frame_.guides);
  FrameImages images;
  images.has_reflection_motion = layout_.Find(Aov::kSpecularMotion) != nullptr;
  const std::optional<Image1> depth = Plane1(Aov::kSeenDepth);
  if (depth && frame_.reflection.empty() && frame_.refraction.empty()) {
    SetSeenGuides({*depth, Colour(Aov::kSeenNormal), Colour(Aov::kSeenAlbedo)}, &frame_, &images);
  }
  if (layout_.Find(Aov::kHitDistance) != nullptr) {
    ImportHits(&fits, &images);
  }
  // Missing motion may be estimated later, and with it the motion of virtual images.
  if (!moves_images_later_ && !frame_.guides.motion.empty()) {
    MoveSeenGuides(&fits, &frame_, &images);  // by motion as stored
  }
  if (layout_.soft_guides && !frame_.guides.motion.empty()) {
    ForgetMixedMotion(&frame_.guides.motion);
  }
  if (layout_.curved_images) {
    SetCurvedImages(&fits, moves_images_later_, &frame_, &images);
  }
  if (images.has_reflection_motion && !frame_.reflection.empty()) {
    ImportSpecularMotion(jitter);
  }
  if (images_ != nullptr) {
    *images_ = std::move(images);
  }
}

NoSeenGuides Importer::CheckHits(bool has_camera) {
  ImportFocalLength();
  ImportGuides({0, 0});
  CameraFits fits(frame_.guides);
  if (!has_camera && !LensOfRays(&fits)) {
    return NoSeenGuides::kFocal;
  }
  const bool is_moved = has_camera || layout_.Find(Aov::kSpecularMotion) != nullptr ||
                        layout_.Find(Aov::kMotion) == nullptr;
  return is_moved ? NoSeenGuides::kNone : WhyUnknown(&fits);
}

NoSeenGuides Importer::CheckSeen(bool has_camera) {
  ImportGuides({0, 0});
  return CheckSeenGuides({*Plane1(Aov::kSeenDepth), Colour(Aov::kSeenNormal), Image3()},
                         frame_.guides, has_camera);
}

bool Importer::ShowsCurvedImages() {
  ImportGuides({0, 0});
  return HasCurvedImages(frame_.guides);
}

/// Whether guides may be means or random samples over the pixel. In frames of stillray they belong
/// to the pixel's centre.
bool Importer::MayMixGuides() const {
  return layout_.renderer != "stillray" && !layout_.from_colour &&
         layout_.Find(Aov::kDepth) != nullptr && layout_.Find(Aov::kNormal) != nullptr;
}

/// Limits the history length where radiance changes without a change of motion or guides. Smoke
/// shortens mean normals too: only without smoke do short normals indicate hair.
void Importer::LimitHistories() {
  if (!frame_.confidence.empty() || frame_.samples.empty()) {
    return;  // with one sample per pixel, a long history is worth its lag
  }
  if (HasLight(volume_)) {
    frame_.confidence = VolumeConfidence(volume_, SumOfLight(frame_), frame_.samples);
  } else if (layout_.soft_guides && !layout_.normal.encoded) {
    loss_in_motion_ = MixedLoss(Colour(Aov::kNormal), frame_.samples);
    if (!frame_.guides.motion.empty()) {
      frame_.confidence = ConfidenceInMotion(loss_in_motion_, frame_.guides.motion);
    }
  }
}

/// Gives pixels with scattered radiance and without a surface the guides of their neighbours.
/// \param without_depth  as FindCoveredWithoutDepth returns it
void Importer::CompleteGuides(const Plane<uint8_t>& without_depth) {
  if (volume_.empty() && without_depth.empty()) {
    return;
  }
  Guides& g = frame_.guides;
  KeepStoredAlbedos();
  if (!volume_.empty() && !layout_.normal.encoded) {
    const Image3 stored_normal = Colour(Aov::kNormal);
    DivideByHits(volume_, stored_normal, &g.albedo);
    DivideByHits(volume_, stored_normal, &g.specular_albedo);
  }
  if (!without_depth.empty()) {
    FillDepth(without_depth, &g);
  }
}

Result<Frame> Importer::Import(std::array<float, 2> previous_jitter) {
  STILLRAY_RETURN_IF_ERROR(CheckChannels());
  ImportJitter();
  ImportFocalLength();
  ImportGuides(previous_jitter);
  ImportAlbedo();
  frame_.emission = Light(Aov::kEmission);
  frame_.background = Light(Aov::kBackground);
  Plane<uint8_t> without_depth;
  if (layout_.from_colour) {
    ImportColourAlone();
  } else {
    ImportPasses();
    if (MayMixGuides()) {
      const Image1 alpha = Plane1(Aov::kAlpha).value_or(Image1());
      without_depth = FindCoveredWithoutDepth(frame_, alpha);
      // With a transparent film the background is not in the image; its layer is copied unchanged.
      if (!without_depth.empty() && !volume_.empty() && !frame_.background.empty() &&
          !IsPartlyTransparent(alpha)) {
        FilterBackground(without_depth);
      }
    }
    AddRest();
  }
  const bool transmits = frame_.Find(SignalKind::kDirectTransmission) != nullptr ||
                         frame_.Find(SignalKind::kIndirectTransmission) != nullptr;
  if (!transmits) {
    frame_.guides.transmission_albedo = Image3();
  }
  const JitterPair jitter = {frame_.jitter_x, frame_.jitter_y, previous_jitter[0],
                             previous_jitter[1]};
  frame_.reflection =
      VirtualGuidesOf(Aov::kReflectionDepth, Aov::kReflectionNormal, Aov::kReflectionAlbedo,
                      Aov::kReflectionMotion, Aov::kReflectionId, jitter);
  frame_.refraction =
      VirtualGuidesOf(Aov::kRefractionDepth, Aov::kRefractionNormal, Aov::kRefractionAlbedo,
                      Aov::kRefractionMotion, Aov::kRefractionId, jitter);
  ImportImages(jitter);
  if (MayMixGuides()) {
    LimitHistories();
    CompleteGuides(without_depth);
  }
  if (transmits) {
    CompleteTransmissionAlbedo();
  }
  EstimateSecondMoments(&frame_);
  return std::move(frame_);
}

Image2 Importer::NextMotion(const JitterPair& jitter) const {
  const MotionDirection direction = layout_.motion.direction;
  const bool main_is_next =
      direction == MotionDirection::kToNext || direction == MotionDirection::kFromNext;
  const AovSource* source = layout_.Find(main_is_next ? Aov::kMotion : Aov::kNextMotion);
  if (source == nullptr) {
    return {};
  }
  for (const std::string& channel : source->channels) {
    if (image_.Find(channel) == nullptr) {
      return {};
    }
  }
  const Image1 x = Values(source->channels[0]);
  const Image1 y = Values(source->channels[1]);
  if (!AnyPixel(x, IsNotZero) && !AnyPixel(y, IsNotZero)) {
    return {};
  }
  Image2 motion =
      ConvertNextMotion(x, y, main_is_next ? layout_.motion : layout_.next_motion, jitter);
  if (layout_.soft_guides) {
    ForgetMixedMotion(&motion);
  }
  return motion;
}

NoSeenGuides CheckSeenLayers(const ExrImage& image, const AovLayout& layout, bool has_camera) {
  return Importer(image, layout, "").CheckSeen(has_camera);
}

NoSeenGuides CheckHitLayers(const ExrImage& image, const AovLayout& layout, bool has_camera) {
  return Importer(image, layout, "").CheckHits(has_camera);
}

Result<Frame> ImportFrameWith(const ExrImage& image, const AovLayout& layout,
                              std::array<float, 2> previous_jitter, const std::string& name,
                              const ImportExtras& extras) {
  Importer importer(image, layout, name, extras);
  Result<Frame> frame = importer.Import(previous_jitter);
  if (extras.loss_in_motion != nullptr) {
    *extras.loss_in_motion = importer.TakeLossInMotion();
  }
  return frame;
}

bool HasCurvedImages(const ExrImage& image, const AovLayout& layout) {
  return Importer(image, layout, "").ShowsCurvedImages();
}

}  // namespace stillray::io

namespace stillray {

Image2 ImportNextMotion(const ExrImage& image, const AovLayout& layout, const JitterPair& jitter) {
  return io::Importer(image, layout, "").NextMotion(jitter);
}

Result<Frame> ImportFrame(const ExrImage& image, const AovLayout& layout,
                          std::array<float, 2> previous_jitter, const std::string& name,
                          std::vector<LightPart>* parts) {
  return io::ImportFrameWith(image, layout, previous_jitter, name, {.parts = parts});
}

}  // namespace stillray
