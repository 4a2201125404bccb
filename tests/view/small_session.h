// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small sessions of the viewer for tests.
#pragma once

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "view/view_session.h"

namespace stillray::view {

inline const RenderProgress kGoOn = [](double) { return true; };

/// A picture of one size, with one sample in every pixel of every frame.
inline ViewSettings SettingsOfSize(int width, int height) {
  ViewSettings settings;
  settings.width = width;
  settings.height = height;
  settings.scale = 1;
  settings.auto_scale = false;
  settings.rate = {1, 1};
  settings.auto_rate = false;
  return settings;
}

inline ViewSettings SmallSettings() {
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.wall_clock = false;
  settings.panes = {"denoised", "noisy"};
  return settings;
}

inline ViewSession Open(const std::string& scene, const Device& device = Device()) {
  const auto quiet = [](const LoadPhase&) { return true; };
  return ViewSession(std::move(LoadForView({scene, ""}, SmallSettings(), quiet, device).value()),
                     device);
}

inline ViewFrame Next(const ViewSettings& settings, ViewSession* session) {
  ViewFrame frame;
  const Status status = session->RenderNext(settings, 0.04, kGoOn, &frame);
  EXPECT_TRUE(status.ok()) << status.message();
  return frame;
}

inline double MeanDifference(const Rgb8Image& a, const Rgb8Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    sum += std::abs(int{a.pixels[i]} - int{b.pixels[i]});
  }
  return sum / static_cast<double>(a.pixels.size());
}

}  // namespace stillray::view
