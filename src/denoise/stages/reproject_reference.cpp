// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "denoise/stages/reproject.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray::reference {
namespace {

/// \param normal  expected normal of the pixel's history
bool TapMatches(const GuidePlanes& now, const GuidePlanes& before, int x, int y, vec3 normal,
                vec2 place, int tx, int ty, const ReprojectParameters& p) {
  if (tx < 0 || ty < 0 || tx >= before.id.width() || ty >= before.id.height()) {
    return false;
  }
  const vec2 g = {now.gradient[0](x, y), now.gradient[1](x, y)};
  const float expected = now.inverse_depth(x, y) + g.x * (static_cast<float>(tx) - place.x) +
                         g.y * (static_cast<float>(ty) - place.y);
  const float cosine = dot(normal, NormalAt(before, tx, ty));
  return IsSameSurface(expected, before.inverse_depth(tx, ty), g, cosine, now.id(x, y),
                       before.id(tx, ty), p.history_depth, p.history_normal_cosine,
                       p.history_id != 0);
}

}  // namespace

void FindTaps(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
              const ReprojectParameters& p, ReprojectionTaps* taps) {
  const int width = taps->x.width();
  const int height = taps->x.height();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const vec2 place = {static_cast<float>(x) + motion[0](x, y),
                          static_cast<float>(y) + motion[1](x, y)};
      // Also false for NaN. Farther than one pixel outside the image, no tap is inside.
      const bool near_picture = place.x > -2.0f && place.y > -2.0f &&
                                place.x < static_cast<float>(width) + 1.0f &&
                                place.y < static_cast<float>(height) + 1.0f;
      const bool surface = now.inverse_depth(x, y) > 0;
      for (int i = 0; i < 4; ++i) {
        taps->weight[i](x, y) = 0;
      }
      taps->search(x, y) = 0;
      taps->x(x, y) = 0;
      taps->y(x, y) = 0;
      if (!near_picture || !surface) {
        continue;
      }
      const vec3 normal = taps->NormalBefore(NormalAt(now, x, y), x, y);
      const bool nearest = p.history_taps_nearest != 0;
      const float fx = FirstTap(place.x, nearest);
      const float fy = FirstTap(place.y, nearest);
      const float tx = nearest ? 0.0f : place.x - fx;
      const float ty = nearest ? 0.0f : place.y - fy;
      const int bx = static_cast<int>(fx);
      const int by = static_cast<int>(fy);
      float weight[4] = {(1 - tx) * (1 - ty), tx * (1 - ty), (1 - tx) * ty, tx * ty};
      float sum = 0;
      for (int i = 0; i < 4; ++i) {
        if (!TapMatches(now, before, x, y, normal, place, bx + (i & 1), by + (i >> 1), p)) {
          weight[i] = 0;
        }
        sum += weight[i];
      }
      taps->x(x, y) = bx;
      taps->y(x, y) = by;
      // Taps with a tiny weight are unreliable: normalisation would scale the weight up by more
      // than a hundred.
      if (sum > 0.01f) {
        for (int i = 0; i < 4; ++i) {
          taps->weight[i](x, y) = weight[i] / sum;
        }
        continue;
      }
      if (p.history_search == 0) {
        continue;
      }
      const int cx = static_cast<int>(std::floor(place.x + 0.5f));
      const int cy = static_cast<int>(std::floor(place.y + 0.5f));
      taps->x(x, y) = cx - 1;
      taps->y(x, y) = cy - 1;
      uint32_t search = 0;
      for (int i = 0; i < 9; ++i) {
        if (TapMatches(now, before, x, y, normal, place, cx - 1 + i % 3, cy - 1 + i / 3, p)) {
          search |= 1u << i;
        }
      }
      taps->search(x, y) = search;
    }
  }
}

namespace {

/// Weighted mean of the taps; with `light_only` of those with samples.
float Fetch(const Image1& plane, const Image1& length, const ReprojectionTaps& taps,
            bool light_only, int x, int y) {
  const int bx = taps.x(x, y);
  const int by = taps.y(x, y);
  const uint32_t search = taps.search(x, y);
  float sum = 0;
  float weights = 0;
  bool some_without = false;
  const auto add = [&](int qx, int qy, float w) {
    if (light_only && !(length(qx, qy) > 0)) {
      some_without = true;
      return;
    }
    sum += w * plane(qx, qy);
    weights += w;
  };
  if (search != 0) {
    for (int i = 0; i < 9; ++i) {
      if ((search >> i & 1u) != 0) {
        add(bx + i % 3, by + i / 3, 1.0f);
      }
    }
    return weights > 0 ? sum / weights : 0.0f;
  }
  for (int i = 0; i < 4; ++i) {
    if (const float w = taps.weight[i](x, y); w > 0) {
      add(bx + (i & 1), by + (i >> 1), w);
    }
  }
  return some_without && weights > 0 ? sum / weights : sum;
}

/// Shortens the fetched history of a pixel.
void ApplyConfidence(const SignalHistory& before, float confidence, int planes,
                     Image1* const* fetched, int x, int y, SignalHistory* out) {
  // Without weights2, as in the mean of restore_detail, the length itself is shortened.
  const float weights2 = before.weights2.empty() ? 0.0f : out->weights2(x, y);
  out->length(x, y) = ConfidentLength(out->length(x, y), weights2, confidence);
  for (int i = 0; i < planes && confidence == 0; ++i) {
    (*fetched[i])(x, y) = 0;
  }
}

}  // namespace

void FetchHistory(const SignalHistory& before, const ReprojectionTaps& taps, SignalHistory* out) {
  const Image1* in[kMostHistoryPlanes];
  Image1* to[kMostHistoryPlanes];
  const int planes = ListHistoryPlanes(before, out, in, to);
  for (int i = 0; i < planes; ++i) {
    const bool light_only = in[i] != &before.length;
    for (int y = 0; y < taps.x.height(); ++y) {
      for (int x = 0; x < taps.x.width(); ++x) {
        (*to[i])(x, y) = Fetch(*in[i], before.length, taps, light_only, x, y);
      }
    }
  }
  for (int y = 0; taps.confidence != nullptr && y < taps.x.height(); ++y) {
    for (int x = 0; x < taps.x.width(); ++x) {
      ApplyConfidence(before, taps.ConfidenceAt(x, y), planes, to, x, y, out);
    }
  }
}

}  // namespace stillray::reference
