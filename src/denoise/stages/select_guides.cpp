// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/select_guides.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/stages/image_motion.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/select_guides.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Vectors of all planes of an image at one position.
template <int N>
struct Vectors {
  VF v[N];
};

template <int N>
HWY_INLINE Vectors<N> LoadAt(const Planes<float, N>& planes, int x, int y) {
  Vectors<N> loaded;
  for (int c = 0; c < N; ++c) {
    loaded.v[c] = hn::LoadU(DF(), planes[c].Row(y) + x);
  }
  return loaded;
}

HWY_INLINE MF ShowsImageAt(const SelectGuidesInput& in, float limit, int x, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF surface = hn::LoadU(d, in.surface->depth.Row(y) + x);
  const VF image = hn::LoadU(d, in.image->depth.Row(y) + x);
  MF shows = hn::And(hn::And(hn::Gt(surface, zero), hn::Lt(surface, hn::Set(d, kImageOfSky))),
                     hn::Gt(image, zero));
  if (!in.roughness->empty()) {
    const VF roughness = hn::LoadU(d, in.roughness->Row(y) + x);
    shows = hn::And(shows, hn::And(hn::Ge(roughness, zero), hn::Le(roughness, hn::Set(d, limit))));
  }
  return shows;
}

HWY_INLINE MF HasNoLightAt(const SelectGuidesInput& in, int x, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  if (in.albedo->empty()) {
    return hn::FirstN(d, 0);
  }
  const Vectors<3> albedo = LoadAt(*in.albedo, x, y);
  return hn::And(hn::Le(albedo.v[0], zero),
                 hn::And(hn::Le(albedo.v[1], zero), hn::Le(albedo.v[2], zero)));
}

/// Sets the motion of rough surfaces at the pixels x, x + 1, ... to that of their reflections.
HWY_INLINE void MoveWithImages(const SelectGuidesInput& in, const SelectGuidesParameters& p, int x,
                               int y, Image2* motion) {
  const DF d;
  const VF roughness = hn::LoadU(d, in.roughness->Row(y) + x);
  const MF rough = hn::And(hn::Gt(roughness, hn::Set(d, p.virtual_roughness)),
                           hn::Le(roughness, hn::Set(d, p.virtual_motion_roughness)));
  if (hn::AllFalse(d, rough)) {
    return;
  }
  const int end = std::min(x + LaneCount(), motion->width());
  for (int u = x; u < end; ++u) {
    if (MayMoveWithImage(in.surface->depth(u, y), in.image->depth(u, y), (*in.roughness)(u, y),
                         p.virtual_roughness, p.virtual_motion_roughness)) {
      const vec2 offset = ImageMotionOnSurface(in, u, y);
      (*motion)[0](u, y) += offset.x;
      (*motion)[1](u, y) += offset.y;
    }
  }
}

HWY_INLINE MF IsNormal(const Vectors<3>& n) {
  const DF d;
  const VF length2 =
      hn::MulAdd(n.v[0], n.v[0], hn::MulAdd(n.v[1], n.v[1], hn::Mul(n.v[2], n.v[2])));
  return hn::And(hn::Gt(length2, hn::Set(d, 1e-12f)), hn::Lt(length2, hn::Set(d, 1e12f)));
}

/// Writes `image` where the mask is true, else `surface`.
template <int N>
HWY_INLINE void SelectAt(MF mask, const Vectors<N>& image, const Planes<float, N>& surface, int x,
                         int y, Planes<float, N>* out) {
  const DF d;
  for (int c = 0; c < N; ++c) {
    const VF own = hn::LoadU(d, surface[c].Row(y) + x);
    StoreInRow(d, hn::IfThenElse(mask, image.v[c], own), (*out)[c].Row(y), x, surface.width());
  }
}

HWY_INLINE void SelectAlbedoAt(const SelectGuidesInput& in, MF shows, int x, int y, Image3* out) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  for (int c = 0; c < 3; ++c) {
    VF albedo = in.albedo->empty() ? one : hn::LoadU(d, (*in.albedo)[c].Row(y) + x);
    if (!in.image->albedo.empty()) {
      const VF seen = hn::LoadU(d, in.image->albedo[c].Row(y) + x);
      const MF good = hn::And(hn::Ge(seen, hn::Zero(d)), hn::Lt(seen, hn::Set(d, 1e12f)));
      albedo = hn::Mul(albedo, hn::IfThenElse(hn::And(shows, good), seen, one));
    }
    StoreInRow(d, albedo, (*out)[c].Row(y), x, out->width());
  }
}

/// Writes the normal of the virtual image, if valid, times `factor` where the mask is true, else
/// the normal of the surface.
HWY_INLINE void SelectNormalAt(const SelectGuidesInput& in, MF shows, float factor, int x, int y,
                               Image3* out) {
  const DF d;
  const Image3& normal = in.image->normal.empty() ? in.surface->normal : in.image->normal;
  const Vectors<3> image = LoadAt(normal, x, y);
  const MF from_image = hn::And(shows, IsNormal(image));
  const VF scale = hn::IfThenElse(shows, hn::Set(d, factor), hn::Set(d, 1.0f));
  for (int c = 0; c < 3; ++c) {
    const VF own = hn::LoadU(d, in.surface->normal[c].Row(y) + x);
    StoreInRow(d, hn::Mul(scale, hn::IfThenElse(from_image, image.v[c], own)), (*out)[c].Row(y), x,
               out->width());
  }
}

void SelectRows(const SelectGuidesInput& in, const SelectGuidesParameters& p, int y0, int y1,
                Guides* out, Image3* albedo) {
  const DF d;
  const DU du;
  const int width = out->depth.width();
  const bool own_motion = in.image->motion.empty();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF shows = ShowsImageAt(in, p.virtual_roughness, x, y);
      const VF own = hn::LoadU(d, in.surface->depth.Row(y) + x);
      const VF image = hn::Min(hn::LoadU(d, in.image->depth.Row(y) + x), hn::Set(d, kImageOfSky));
      const VF depth = hn::IfThenElse(shows, image, own);
      StoreInRow(d, hn::IfThenElse(HasNoLightAt(in, x, y), hn::Set(d, kNoSurface), depth),
                 out->depth.Row(y), x, width);
      SelectNormalAt(in, shows, p.image_normal, x, y, &out->normal);
      if (!out->motion.empty()) {
        const Image2& motion = own_motion ? in.surface->motion : in.image->motion;
        SelectAt(shows, LoadAt(motion, x, y), in.surface->motion, x, y, &out->motion);
        if (!own_motion && !in.roughness->empty()) {
          MoveWithImages(in, p, x, y, &out->motion);
        }
      }
      if (!out->id.empty()) {
        const VU of_surface = hn::LoadU(du, in.surface->id.Row(y) + x);
        const VU of_image =
            in.image->id.empty() ? of_surface : hn::LoadU(du, in.image->id.Row(y) + x);
        StoreInRow(du, hn::IfThenElse(hn::RebindMask(du, shows), of_image, of_surface),
                   out->id.Row(y), x, width);
      }
      const VF roughness =
          in.roughness->empty() ? hn::Set(d, 1.0f) : hn::LoadU(d, in.roughness->Row(y) + x);
      StoreInRow(d, hn::IfThenElse(shows, hn::Set(d, kRoughnessOfImage), roughness),
                 out->roughness.Row(y), x, width);
      if (!out->previous_normal.empty()) {
        const Vectors<3> none = {{hn::Zero(d), hn::Zero(d), hn::Zero(d)}};
        SelectAt(shows, none, *in.previous_normal, x, y, &out->previous_normal);
      }
      if (!albedo->empty()) {
        SelectAlbedoAt(in, shows, x, y, albedo);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(SelectRows);

void SelectGuides(const SelectGuidesInput& in, const SelectGuidesParameters& p, Guides* out,
                  Image3* albedo) {
  MakeSelectedPlanes(in, out, albedo);
  ParallelRows(out->depth.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(SelectRows)(in, p, y0, y1, out, albedo);
  });
}

}  // namespace stillray::cpu
#endif
