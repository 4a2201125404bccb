// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Sequences in memory, clean ones and ways to spoil them.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "stillray/doctor.h"
#include "stillray/render.h"

namespace stillray {

struct NumberedImage {
  int64_t number = 0;
  ExrImage image;
};
using Sequence = std::vector<NumberedImage>;

struct SceneOptions {
  std::string scene = "lights";
  int width = 160;
  int height = 90;
  int frames = 4;
  double start = 2;
  double step = 0.25;  ///< seconds between frames
  int spp = 1;
  bool jitter = true;
  bool fixed_seed = false;
  /// Four samples spread over the pixel: light, albedo and normals are their means; depth, motion
  /// and ids are those of the pixel's centre.
  bool averaged = false;
  bool virtual_guides = false;  ///< with the layers of what surfaces reflect and let through

  bool operator==(const SceneOptions&) const = default;
};
/// Frames 1, 2, ... of a built-in scene with the layers that `stillray render` writes.
Sequence RenderSequence(const SceneOptions& options);

/// Names of all findings, in alphabetical order.
std::set<std::string> FindingsOf(const Sequence& sequence, const AovOptions& options = {});
/// The whole report; fails the test if there is none.
DoctorReport ReportOf(const Sequence& sequence, const AovOptions& options = {});

Channel& ChannelOf(ExrImage& image, const std::string& name);
/// value = change(value, x, y) in one channel of all frames.
using Change = std::function<float(float value, int x, int y)>;
void ChangeChannel(Sequence* sequence, const std::string& name, const Change& change);
/// In every channel of a layer: names that begin with `prefix`.
void ChangeLayer(Sequence* sequence, const std::string& prefix, const Change& change);
void SwapChannels(Sequence* sequence, const std::string& a, const std::string& b);
void RemoveLayer(Sequence* sequence, const std::string& prefix);
/// Uniform in -1..1, of a place and a frame.
float NoiseAt(int x, int y, int64_t frame, int channel);

}  // namespace stillray
