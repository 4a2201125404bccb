// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/prepare_guides_shared.h"

namespace stillray::reference {
namespace {

bool IsFinite(const Image3& image, int x, int y) {
  return std::isfinite(image[0](x, y)) && std::isfinite(image[1](x, y)) &&
         std::isfinite(image[2](x, y));
}

/// Stores 1 / z and unit normal of valid surfaces, else zero. \return whether the guides are
/// invalid
bool ConvertPixel(const PrepareGuidesInput& in, int x, int y, GuidePlanes* out) {
  const float z = (*in.depth)(x, y);
  const bool finite_normal = IsFinite(*in.normal, x, y);
  const vec3 n = {(*in.normal)[0](x, y), (*in.normal)[1](x, y), (*in.normal)[2](x, y)};
  const float length2 = dot(n, n);
  const bool surface =
      z > 0 && std::isfinite(z) && finite_normal && length2 > 1e-12f && std::isfinite(length2);
  const float scale = surface ? 1.0f / sqrt(length2) : 0.0f;
  out->inverse_depth(x, y) = surface ? 1.0f / z : 0.0f;
  out->depth(x, y) = surface ? z : 0.0f;
  const vec3 unit = surface ? n * scale : vec3(0.0f);
  if (out->packs_normals()) {
    out->packed_normal(x, y) = PackNormal(unit);
  }
  for (int c = 0; c < 3 && !out->packs_normals(); ++c) {
    out->normal[c](x, y) = unit[c];
  }
  out->id(x, y) = surface && in.id != nullptr ? (*in.id)(x, y) : 0u;
  return !(z > 0) || !finite_normal;
}

bool SameSlope(const GuidePlanes& g, int x, int y, int x2, int y2) {
  const float cosine = dot(NormalAt(g, x, y), NormalAt(g, x2, y2));
  return cosine >= kGradientMinCosine && g.id(x, y) == g.id(x2, y2);
}

float TurnAt(const GuidePlanes& g, int x, int y) {
  const auto cosine = [&](int dx, int dy) {
    return dot(NormalAt(g, x, y), NormalAt(g, x + dx, y + dy));
  };
  return SquaredTurn(cosine(-1, 0), cosine(1, 0), cosine(0, -1), cosine(0, 1));
}

}  // namespace

int64_t PrepareGuides(const PrepareGuidesInput& in, GuidePlanes* out) {
  const int width = in.depth->width();
  const int height = in.depth->height();
  int64_t bad = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bad += ConvertPixel(in, x, y, out) ? 1 : 0;
    }
  }
  const Image1& i = out->inverse_depth;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto ok = [&](int dx, int dy) {
        return SameSlope(*out, x, y, x + dx, y + dy) ? 1.0f : 0.0f;
      };
      out->gradient[0](x, y) =
          OneSidedGradient(i(x - 1, y), i(x, y), i(x + 1, y), ok(-1, 0), ok(1, 0));
      out->gradient[1](x, y) =
          OneSidedGradient(i(x, y - 1), i(x, y), i(x, y + 1), ok(0, -1), ok(0, 1));
      if (!out->turn2.empty()) {
        out->turn2(x, y) = TurnAt(*out, x, y);
      }
    }
  }
  return bad;
}

}  // namespace stillray::reference
