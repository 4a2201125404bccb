// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/follow_light.h"

namespace stillray {

/// The state of a layer: of signals with common guides.
struct LayerHistory {
  std::vector<SignalHistory> signals;
  GuidePlanes guides;           ///< of the last frame; of the one in progress while there is one
  GuidePlanes previous_guides;  ///< of the frame before the one in progress
  /// Of every signal, see restore_detail: mean residual (colour) and its length; the planes are
  /// empty where it has not run.
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

/// The state of the denoiser on the CPU between frames: a sequence continues from it with the same
/// bits.
struct History {
  int width = 0;
  int height = 0;
  SequenceProgress progress;
  LayerList list;                    ///< the layers, in the order of their signals
  std::vector<LayerHistory> layers;  ///< the first is the surface's
  Image3 picture;                    ///< the last finished one
  Image3 albedo;                     ///< its antialiased albedo; empty unless it is kept
  Image1 followed;                   ///< light per block, of follow_light; empty unless it runs
  HeldGuides held;                   ///< of frames with incomplete guides; else empty

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
  /// Whether a frame of this size, with these layers, can continue from it.
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
