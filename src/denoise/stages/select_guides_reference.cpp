// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/image_motion.h"
#include "denoise/stages/select_guides.h"

namespace stillray::reference {
namespace {

bool ShowsImageAt(const SelectGuidesInput& in, float limit, int x, int y) {
  const float roughness = in.roughness->empty() ? 0.0f : (*in.roughness)(x, y);
  return ShowsImage(in.surface->depth(x, y), in.image->depth(x, y), roughness, limit);
}

bool HasNoLightAt(const SelectGuidesInput& in, int x, int y) {
  const Image3& a = *in.albedo;
  return !a.empty() && HasNoLight({a[0](x, y), a[1](x, y), a[2](x, y)});
}

void SelectNormal(const SelectGuidesInput& in, bool image, float factor, int x, int y,
                  Image3* out) {
  const Image3* from = &in.surface->normal;
  if (image && !in.image->normal.empty()) {
    const Image3& n = in.image->normal;
    const float length2 =
        n[0](x, y) * n[0](x, y) + n[1](x, y) * n[1](x, y) + n[2](x, y) * n[2](x, y);
    from = IsNormalLength2(length2) ? &n : from;
  }
  for (int c = 0; c < 3; ++c) {
    (*out)[c](x, y) = (image ? factor : 1.0f) * (*from)[c](x, y);
  }
}

void SelectMotion(const SelectGuidesInput& in, const SelectGuidesParameters& p, bool image, int x,
                  int y, Image2* out) {
  const Image2& from = image && !in.image->motion.empty() ? in.image->motion : in.surface->motion;
  vec2 offset(0.0f);
  if (!in.roughness->empty() && !in.image->motion.empty() &&
      MayMoveWithImage(in.surface->depth(x, y), in.image->depth(x, y), (*in.roughness)(x, y),
                       p.virtual_roughness, p.virtual_motion_roughness)) {
    offset = ImageMotionOnSurface(in, x, y);
  }
  (*out)[0](x, y) = from[0](x, y) + offset.x;
  (*out)[1](x, y) = from[1](x, y) + offset.y;
}

void SelectAlbedo(const SelectGuidesInput& in, bool image, int x, int y, Image3* out) {
  for (int c = 0; c < 3; ++c) {
    const float own = in.albedo->empty() ? 1.0f : (*in.albedo)[c](x, y);
    const float seen =
        image && !in.image->albedo.empty() ? SeenAlbedo(in.image->albedo[c](x, y)) : 1.0f;
    (*out)[c](x, y) = own * seen;
  }
}

}  // namespace

void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& p, Guides* out,
                  Image3* albedo) {
  MakeSelectedPlanes(in, out, albedo);
  const Image1& depth = in.surface->depth;
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const bool image = ShowsImageAt(in, p.virtual_roughness, x, y);
      out->depth(x, y) = HasNoLightAt(in, x, y) ? kNoSurface
                         : image                ? ImageDepth(in.image->depth(x, y))
                                                : depth(x, y);
      SelectNormal(in, image, p.image_normal, x, y, &out->normal);
      if (!out->motion.empty()) {
        SelectMotion(in, p, image, x, y, &out->motion);
      }
      if (!out->id.empty()) {
        out->id(x, y) = image && !in.image->id.empty() ? in.image->id(x, y) : in.surface->id(x, y);
      }
      const float roughness = in.roughness->empty() ? 1.0f : (*in.roughness)(x, y);
      out->roughness(x, y) = image ? kRoughnessOfImage : roughness;
      for (int c = 0; !out->previous_normal.empty() && c < 3; ++c) {
        out->previous_normal[c](x, y) = image ? 0.0f : (*in.previous_normal)[c](x, y);
      }
      if (!albedo->empty()) {
        SelectAlbedo(in, image, x, y, albedo);
      }
    }
  }
}

}  // namespace stillray::reference
