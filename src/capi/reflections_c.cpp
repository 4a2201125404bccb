// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include "capi/calls.h"
#include "capi/camera_access.h"
#include "capi/image_access.h"
#include "stillray/reflections.h"
#include "stillray/stillray.h"

namespace stillray::capi {
namespace {

Status IsMissing(const char* name) {
  return Status::InvalidArgument(fmt::format("image '{}' is not given", name));
}

/// The description with all strides set; sizes are compared with `depth`, if given.
Status Understand(const stillray_image* given, const char* name, int channels, bool id,
                  const stillray_image* depth, stillray_image* image) {
  *image = *given;
  STILLRAY_RETURN_IF_ERROR(CheckImage(name, channels, id, image));
  if (depth != nullptr && (image->width != depth->width || image->height != depth->height)) {
    return Status::InvalidArgument(fmt::format("image '{}' is {}x{}, expected {}x{} as 'depth'",
                                               name, image->width, image->height, depth->width,
                                               depth->height));
  }
  return Status::Ok();
}

/// \param plane  stays empty if the image is not given
Status ReadPlane(const stillray_image* given, const char* name, const stillray_image* depth,
                 Image1* plane) {
  if (given == nullptr) {
    return Status::Ok();
  }
  stillray_image image;
  STILLRAY_RETURN_IF_ERROR(Understand(given, name, 1, false, depth, &image));
  *plane = Image1(image.width, image.height);
  ReadChannel(image, 0, plane);
  return Status::Ok();
}

Status ReadGuides(const stillray_hits& hits, Guides* guides) {
  STILLRAY_RETURN_IF_ERROR(ReadPlane(hits.depth, "depth", nullptr, &guides->depth));
  STILLRAY_RETURN_IF_ERROR(ReadPlane(hits.roughness, "roughness", hits.depth, &guides->roughness));
  stillray_image image;
  if (hits.normal != nullptr) {
    STILLRAY_RETURN_IF_ERROR(Understand(hits.normal, "normal", 3, false, hits.depth, &image));
    guides->normal = Image3(image.width, image.height);
    for (int c = 0; c < 3; ++c) {
      ReadChannel(image, c, &guides->normal[c]);
    }
  }
  if (hits.id != nullptr) {
    STILLRAY_RETURN_IF_ERROR(Understand(hits.id, "id", 1, true, hits.depth, &image));
    guides->id = Plane<uint32_t>(image.width, image.height);
    ReadIds(image, &guides->id);
  }
  return Status::Ok();
}

Status CheckAllGiven(const stillray_hits& hits) {
  const struct {
    const void* given;
    const char* name;
  } needed[] = {{hits.depth, "depth"},
                {hits.hit_distance, "hit_distance"},
                {hits.reflection_depth, "reflection_depth"},
                {hits.reflection_motion, "reflection_motion"}};
  for (const auto& [given, name] : needed) {
    if (given == nullptr) {
      return IsMissing(name);
    }
  }
  if (hits.camera == nullptr) {
    return IsNull("hits->camera");
  }
  return hits.previous_camera == nullptr ? IsNull("hits->previous_camera") : Status::Ok();
}

Status MakeReflections(const stillray_hits& hits) {
  STILLRAY_RETURN_IF_ERROR(CheckAllGiven(hits));
  Guides guides;
  Image1 distance;
  stillray_image depth;
  stillray_image motion;
  STILLRAY_RETURN_IF_ERROR(ReadGuides(hits, &guides));
  STILLRAY_RETURN_IF_ERROR(ReadPlane(hits.hit_distance, "hit_distance", hits.depth, &distance));
  STILLRAY_RETURN_IF_ERROR(
      Understand(hits.reflection_depth, "reflection_depth", 1, false, hits.depth, &depth));
  STILLRAY_RETURN_IF_ERROR(
      Understand(hits.reflection_motion, "reflection_motion", 2, false, hits.depth, &motion));
  const Result<VirtualGuides> images = ReflectionsFromHits(
      guides, distance, ReadCamera(*hits.camera), ReadCamera(*hits.previous_camera));
  STILLRAY_RETURN_IF_ERROR(images.status());
  WriteChannel(images->depth, 0, depth);
  WriteChannel(images->motion[0], 0, motion);
  WriteChannel(images->motion[1], 1, motion);
  return Status::Ok();
}

}  // namespace
}  // namespace stillray::capi

using namespace stillray;        // NOLINT: the function below stands at global scope
using namespace stillray::capi;  // NOLINT

extern "C" {

stillray_error stillray_reflections_from_hits(const stillray_hits* hits) {
  return Guard(&ThreadMessage(), [&]() -> Status {
    stillray_hits values;
    STILLRAY_RETURN_IF_ERROR(ReadStruct(hits, "hits", "stillray_hits", &values));
    return MakeReflections(values);
  });
}

}  // extern "C"
