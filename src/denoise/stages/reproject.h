// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// reproject: finds each pixel's history in the previous frame, and fetches it. Source: SVGF
/// section 4.1: 2x2 bilinear taps, each tested for the same surface (depth, normal, id) and for
/// lying inside the image, weights renormalised over the taps that pass (or the nearest tap alone);
/// if none passes, the 3x3 taps around the position are averaged; if none of these passes, there is
/// no history (disocclusion). Departs: depth is tested against the plane through the pixel, with a
/// tolerance for the distance travelled in one frame. All planes of the history are fetched with
/// the same taps and weights, except that taps without samples (below one sample per pixel) only
/// contribute to the length. The paper compares normals in object space; here the caller may give
/// the normal of the point in the previous frame instead (HistoryNormal). The caller may also give
/// the confidence in the last frame's radiance: the fetched length is ConfidentLength, and where
/// the confidence is 0 no radiance is fetched; taps and disocclusions do not depend on it. Border:
/// none. FindTaps reads 56, writes 28 bytes per pixel; FetchHistory reads 28 and 4 x 28, writes 28.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray {

inline constexpr int kMostHistoryPlanes = 11;

/// The planes of \p before to fetch, and their destinations. \return their number, up to
/// kMostHistoryPlanes
inline int ListHistoryPlanes(const SignalHistory& before, SignalHistory* out, const Image1** in,
                             Image1** to) {
  int count = 0;
  const auto add = [&](const Image1& from, Image1& into) {
    if (!from.empty()) {
      in[count] = &from;
      to[count++] = &into;
    }
  };
  for (int c = 0; c < 3; ++c) {
    add(before.colour[c], out->colour[c]);
    add(before.behind[c], out->behind[c]);
  }
  add(before.mean, out->mean);
  add(before.variance, out->variance);
  add(before.length, out->length);
  add(before.weights2, out->weights2);
  add(before.compressed, out->compressed);
  return count;
}

namespace reference {
void FindTaps(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
              const ReprojectParameters& parameters, ReprojectionTaps* taps);
void FetchHistory(const SignalHistory& before, const ReprojectionTaps& taps, SignalHistory* out);
}  // namespace reference
namespace cpu {
void FindTaps(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
              const ReprojectParameters& parameters, ReprojectionTaps* taps);
void FetchHistory(const SignalHistory& before, const ReprojectionTaps& taps, SignalHistory* out);
}  // namespace cpu

}  // namespace stillray
