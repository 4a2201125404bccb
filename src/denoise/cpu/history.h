// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/follow_light.h"

namespace stillray {

/// The state of a layer, i.e. of signals with common guides.
struct LayerHistory {
  std::vector<SignalHistory> signals;
  GuidePlanes guides;           ///< of the last frame; during a frame, of that frame
  GuidePlanes previous_guides;  ///< during a frame, of the frame before
  /// State of restore_detail for every signal: mean residual (colour) and its length; planes are
  /// empty if the stage has not run.
  std::vector<SignalHistory> residuals;

  int width() const { return signals.front().length.width(); }
  int height() const { return signals.front().length.height(); }
  size_t bytes() const {
    size_t sum = guides.bytes() + previous_guides.bytes();
    for (const SignalHistory& signal : signals) {
      sum += signal.bytes();
    }
    for (const SignalHistory& residual : residuals) {
      sum += residual.bytes();
    }
    return sum;
  }
};

/// The state of a mean residual without any samples.
inline SignalHistory EmptyResidual(int width, int height) {
  SignalHistory empty;
  empty.colour = LumaImage3(width, height);
  empty.length = Image1(width, height);
  return empty;
}

/// The state of the denoiser on the CPU between frames. A sequence that continues from a copy has
/// bit-identical results.
struct History {
  int width = 0;
  int height = 0;
  SequenceProgress progress;
  LayerList list;                    ///< the layers, in the order of their signals
  std::vector<LayerHistory> layers;  ///< the first is the surface's
  Image3 picture;                    ///< the last output image
  Image3 albedo;    ///< antialiased albedo of `picture`; empty unless antialias keeps it
  Image1 followed;  ///< radiance per block, of follow_light; empty unless that runs
  HeldGuides held;  ///< guides of frames with incomplete guides; else empty

  History() = default;
  History(int w, int h, const LayerList& layer_list, const HistoryLayout& layout, int border)
      : width(w), height(h), list(layer_list), picture(w, h) {
    for (const PlannedLayer& layer : list) {
      layers.emplace_back().signals.assign(
          layer.count, SignalHistory(w, h, layout.with_compressed, layout.with_behind, border));
    }
  }

  HistoryLayout layout() const {
    const SignalHistory* any = layers.empty() ? nullptr : &layers.front().signals.front();
    return {.with_compressed = any != nullptr && !any->compressed.empty(),
            .with_behind = any != nullptr && !any->behind.empty()};
  }
  /// Whether a frame with this size and these layers can continue from this history.
  bool Fits(int w, int h, const LayerList& layer_list, const HistoryLayout& wanted) const {
    return width == w && height == h && list == layer_list && layout() == wanted;
  }
  size_t bytes() const {
    size_t sum = picture.bytes() + albedo.bytes() + followed.bytes() + held.bytes();
    for (const LayerHistory& layer : layers) {
      sum += layer.bytes();
    }
    return sum;
  }
};

}  // namespace stillray
