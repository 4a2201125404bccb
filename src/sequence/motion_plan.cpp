// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/motion_plan.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/cameras.h"
#include "core/guides.h"
#include "core/parallel.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "io/light_confidence.h"
#include "motion/estimate_motion.h"

namespace stillray {

const char* MotionSourceName(MotionSource source) {
  switch (source) {
    case MotionSource::kAuto:
      return "auto";
    case MotionSource::kFile:
      return "file";
    case MotionSource::kCamera:
      return "camera";
    case MotionSource::kEstimate:
      return "estimate";
  }
  return "";
}

std::optional<MotionSource> MotionSourceOf(std::string_view name) {
  for (const MotionSource source :
       {MotionSource::kAuto, MotionSource::kFile, MotionSource::kCamera, MotionSource::kEstimate}) {
    if (name == MotionSourceName(source)) {
      return source;
    }
  }
  return std::nullopt;
}

const char* MotionKindName(MotionKind kind) {
  switch (kind) {
    case MotionKind::kNone:
      return "";
    case MotionKind::kFile:
      return "file";
    case MotionKind::kCamera:
      return "camera";
    case MotionKind::kEstimate:
      return "estimate";
  }
  return "";
}

namespace {

constexpr const char* kNoCamera =
    "expected worldToCamera and worldToNDC in the files (Arnold and RenderMan write them), or "
    "--cameras FILE.json";

bool MotionIsDisabled(const SequenceOptions& options) {
  const std::vector<std::string>& mappings = options.aovs.mappings;
  return std::find(mappings.begin(), mappings.end(), "motion=none") != mappings.end();
}

/// Whether guides have enough structure to distinguish positions.
bool HasGuides(const AovLayout& layout) {
  const auto has = [&](Aov aov) { return layout.Find(aov) != nullptr; };
  return has(Aov::kAlbedo) || has(Aov::kFallbackAlbedo) || (has(Aov::kDepth) && has(Aov::kNormal));
}

/// Whether a zero motion layer means that nothing moves. Some renderers leave the layer zero, for
/// example with motion blur.
bool HasExactMotion(const AovLayout& layout) {
  return layout.renderer == "stillray";
}

Status ReadCameras(const SequenceOptions& options, const ExrImage& first, MotionPlan* plan) {
  Result<motion::CameraFile> file = motion::ReadCameraFile(options.cameras);
  STILLRAY_RETURN_IF_ERROR(file.status());
  if (file->width != first.width || file->height != first.height) {
    return Status::InvalidArgument(
        fmt::format("{} has cameras of {} x {} pixels, the frames have {} x {}: write it again "
                    "with the resolution of the frames",
                    options.cameras, file->width, file->height, first.width, first.height));
  }
  for (const SequenceFile& frame : options.files) {
    STILLRAY_RETURN_IF_ERROR(file->Camera(frame.frame).status());
  }
  plan->cameras = std::move(file.value());
  return Status::Ok();
}

std::string NoteOf(const MotionPlan& plan, const AovLayout& layout) {
  if (plan.from_file) {
    return "";
  }
  const std::string cameras =
      plan.cameras ? plan.cameras->name : std::string("worldToCamera, worldToNDC");
  if (plan.from_cameras && plan.estimates) {
    return fmt::format(
        "motion is derived from depth and the cameras ({}), and estimated from the guides for what "
        "moves by itself",
        cameras);
  }
  if (plan.from_cameras) {
    return fmt::format(
        "motion is derived from depth and the cameras ({}), without the motion of objects",
        cameras);
  }
  return plan.estimates ? fmt::format("motion is estimated from the guides{}",
                                      layout.Find(Aov::kDepth) == nullptr
                                          ? ""
                                          : "; the motion of the camera too, as no file has it")
                        : "";
}

Status CheckPlan(const SequenceOptions& options, const AovLayout& layout, bool has_camera) {
  const MotionSource source = options.motion;
  if (source == MotionSource::kFile && !options.cameras.empty()) {
    return Status::InvalidArgument(
        "--cameras is given with --motion file, which does not use it; expected --motion auto, "
        "camera or estimate");
  }
  if (source == MotionSource::kCamera && !has_camera) {
    return Status::InvalidArgument(fmt::format("--motion camera: {} has no camera, {}",
                                               options.files.front().input, kNoCamera));
  }
  if (source == MotionSource::kCamera && layout.Find(Aov::kDepth) == nullptr) {
    return Status::InvalidArgument(fmt::format(
        "--motion camera: {} has no depth, expected a layer of depth (--aov depth=LAYER)",
        options.files.front().input));
  }
  if (source == MotionSource::kEstimate && !HasGuides(layout)) {
    return Status::InvalidArgument(fmt::format(
        "--motion estimate: {} has neither albedo nor depth and normals, in which motion could be "
        "seen; map such layers with --aov",
        options.files.front().input));
  }
  return Status::Ok();
}

}  // namespace

Result<MotionPlan> PlanMotion(const SequenceOptions& options, const AovLayout& layout,
                              const ExrImage& first) {
  MotionPlan plan;
  if (!options.cameras.empty() && options.motion != MotionSource::kFile) {
    STILLRAY_RETURN_IF_ERROR(ReadCameras(options, first, &plan));
  }
  const bool has_camera = plan.cameras || CameraOf(first).has_value();
  STILLRAY_RETURN_IF_ERROR(CheckPlan(options, layout, has_camera));
  const bool has_layer = layout.Find(Aov::kMotion) != nullptr;
  const bool has_depth = layout.Find(Aov::kDepth) != nullptr;
  switch (options.motion) {
    case MotionSource::kFile:
      plan.from_file = has_layer;
      plan.from_cameras = layout.motion_from_cameras;
      break;
    case MotionSource::kCamera:
      plan.from_cameras = plan.needs_camera = true;
      break;
    case MotionSource::kEstimate:
      plan.from_cameras = has_camera && has_depth;
      plan.estimates = true;
      break;
    case MotionSource::kAuto:
      if (!MotionIsDisabled(options)) {
        plan.from_file = has_layer;
        const bool may_lack = !(has_layer && HasExactMotion(layout));
        plan.from_cameras = may_lack && has_camera && has_depth;
        plan.estimates = may_lack && HasGuides(layout);
      }
      break;
  }
  plan.note = NoteOf(plan, layout);
  return plan;
}

Result<std::optional<CameraMatrices>> CameraOfFrame(const MotionPlan& plan,
                                                    const SequenceFile& file,
                                                    const ExrImage& image) {
  if (!plan.from_cameras) {
    return std::optional<CameraMatrices>();
  }
  Result<std::optional<CameraMatrices>> camera =
      plan.cameras ? plan.cameras->Camera(file.frame) : CameraOf(image);
  STILLRAY_RETURN_IF_ERROR(camera.status());
  if (plan.needs_camera && !camera->has_value()) {
    return Status::BadData(
        plan.cameras ? fmt::format("--motion camera: the camera of frame {} in {} has no "
                                   "projection (its type is panoramic or another that no matrix "
                                   "describes); expected --motion estimate",
                                   file.frame, plan.cameras->name)
                     : fmt::format("--motion camera: {} has no camera, {}", file.input, kNoCamera));
  }
  return camera;
}

bool IsStill(const Image2& motion) {
  return !AnyPixel(motion, [](float v) { return v != 0; });
}

void AddNeighbourJitter(const MotionConvention& convention, const Frame& neighbour,
                        Image2* motion) {
  if (!convention.jittered || (neighbour.jitter_x == 0 && neighbour.jitter_y == 0)) {
    return;
  }
  for (int y = 0; y < motion->height(); ++y) {
    for (int x = 0; x < motion->width(); ++x) {
      (*motion)[0](x, y) += neighbour.jitter_x;
      (*motion)[1](x, y) += neighbour.jitter_y;
    }
  }
}

namespace {

/// The motion of known surfaces; NaN elsewhere.
Image2 KnownMotion(const Image2& motion) {
  Image2 known = motion;
  const auto width = static_cast<float>(motion.width());
  for (int y = 0; y < motion.height(); ++y) {
    for (int x = 0; x < motion.width(); ++x) {
      if (!(std::fabs(motion[0](x, y)) < width)) {
        known[0](x, y) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return known;
}

bool HasImage(const VirtualGuides& images) {
  return AnyPixel(images.depth, [](float depth) { return depth > 0; });
}

/// Virtual images of planar surfaces where the roughness is 0, of convex surfaces elsewhere.
Plane<uint8_t> KindsOf(const Guides& guides, const VirtualGuides& images) {
  Plane<uint8_t> kinds(images.depth.width(), images.depth.height());
  ForEachPixel(kinds.width(), kinds.height(), [&](int x, int y) {
    if (images.depth(x, y) > 0) {
      const bool planar = guides.roughness.empty() || guides.roughness(x, y) == 0;
      kinds(x, y) = static_cast<uint8_t>(planar ? io::ImageKind::kPlanar : io::ImageKind::kConvex);
    }
  });
  return kinds;
}

}  // namespace

void MoveImages(const AovLayout& layout, const std::optional<CameraMatrices>& before,
                const std::optional<CameraMatrices>& now, io::FrameImages* images, Frame* frame) {
  struct Part {
    VirtualGuides* guides;
    Aov motion;
    const Plane<uint8_t>& kinds;
  };
  const Part parts[] = {
      {&frame->reflection, Aov::kReflectionMotion, images->reflection},
      {&frame->refraction, Aov::kRefractionMotion, images->refraction},
  };
  const auto is_moved = [&](const Part& part) {
    const bool is_given =
        layout.Find(part.motion) != nullptr ||
        (part.motion == Aov::kReflectionMotion && layout.Find(Aov::kSpecularMotion) != nullptr);
    return !part.guides->empty() && !is_given && HasImage(*part.guides);
  };
  if (frame->guides.motion.empty() || std::none_of(std::begin(parts), std::end(parts), is_moved)) {
    return;
  }
  const std::optional<CameraMotion> exact =
      before && now ? MotionOfCamera(*now, *before, frame->width, frame->height) : std::nullopt;
  const Image2 known = exact ? Image2() : KnownMotion(frame->guides.motion);
  io::CameraFits fits(frame->guides.depth, frame->guides.normal, known);
  const std::optional<CameraMotion>& camera = exact ? exact : fits.Motion();
  if (!exact && images->missing == io::NoSeenGuides::kNone) {
    images->missing = io::WhyUnknown(&fits);
  }
  for (const Part& part : parts) {
    if (!is_moved(part)) {
      continue;
    }
    part.guides->motion = Image2(frame->width, frame->height);
    if (camera) {
      io::SetImageMotion(part.kinds.empty() ? KindsOf(frame->guides, *part.guides) : part.kinds,
                         images->lens, *camera, &fits, frame->guides, part.guides);
    } else {
      io::ForgetImageMotion(part.guides);
    }
  }
}

namespace {

/// The confidence in a history, from the certainty of its motion. Random guides, in hair and with
/// motion blur, make correct motion uncertain too: only almost unknown motion reduces the weight,
/// at most by half.
float TrustIn(float certainty) {
  constexpr float kCertain = 0.125f;
  constexpr float kLeast = 0.5f;
  return kLeast + (1 - kLeast) * std::min(certainty / kCertain, 1.0f);
}

/// Sets the confidence for the computed motion: the imported confidence is for the file's motion.
/// \param certainty  EstimatedMotion::confidence; empty: motion is not estimated
void LimitHistories(const Image1& loss_in_motion, const Image1& certainty, Frame* frame) {
  if (!loss_in_motion.empty()) {
    frame->confidence = io::ConfidenceInMotion(loss_in_motion, frame->guides.motion);
  }
  if (certainty.empty()) {
    return;
  }
  if (frame->confidence.empty()) {
    frame->confidence = Image1(frame->width, frame->height);
    frame->confidence.Fill(1);
  }
  ForEachPixel(frame->width, frame->height, [&](int x, int y) {
    float& confidence = frame->confidence(x, y);
    confidence = std::min(confidence, TrustIn(certainty(x, y)));
  });
}

/// \param trusted      the frame's motion is kept if no motion can be estimated from the guides
/// \param antialiased  AovLayout::soft_guides
/// \param certainty    [out] EstimatedMotion::confidence; stays empty if the frame's motion is kept
MotionOrigin Estimate(const FrameBefore& before, Image2 camera, bool trusted, bool antialiased,
                      Frame* now, Image1* certainty) {
  motion::EstimateInput input;
  input.now = &now->guides;
  input.before = &before.frame.guides;
  input.camera = std::move(camera);
  input.antialiased = antialiased;
  input.jitter = {now->jitter_x, now->jitter_y};
  input.jitter_before = {before.frame.jitter_x, before.frame.jitter_y};
  motion::EstimatedMotion estimated = motion::EstimateMotion(input);
  if (trusted && estimated.unknown == 1) {
    return {MotionKind::kFile, 0, 0};
  }
  now->guides.motion = std::move(estimated.motion);
  *certainty = std::move(estimated.confidence);
  return {MotionKind::kEstimate, estimated.estimated(), estimated.unknown};
}

}  // namespace

MotionOrigin CompleteMotion(const FrameBefore& before, const MotionPlan& plan,
                            const AovLayout& layout, const FrameNow& now) {
  Image2& motion = now.frame->guides.motion;
  if (plan.from_file && (!plan.derives() || !IsStill(motion))) {
    AddNeighbourJitter(layout.motion, before.frame, &motion);
    return {MotionKind::kFile, 0, 0};
  }
  Image2 of_camera;
  if (now.camera && before.camera) {
    of_camera = MotionFromCameras(now.frame->guides.depth, *now.camera, *before.camera);
  }
  MotionOrigin origin;
  Image1 certainty;
  if (plan.estimates) {
    origin = Estimate(before, std::move(of_camera), plan.from_file, layout.soft_guides, now.frame,
                      &certainty);
  } else if (!of_camera.empty()) {
    motion = std::move(of_camera);
    origin.kind = MotionKind::kCamera;
  } else if (plan.from_file) {
    return {MotionKind::kFile, 0, 0};
  } else {
    motion = Image2();
    return origin;
  }
  LimitHistories(now.loss_in_motion, certainty, now.frame);
  return origin;
}

}  // namespace stillray
