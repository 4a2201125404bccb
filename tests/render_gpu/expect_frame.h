// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that must have the same bits.
#pragma once

#include <gtest/gtest.h>

#include "stillray/core.h"
#include "stillray/frame.h"

namespace stillray::render {

template <typename T>
void ExpectPlane(const Plane<T>& found, const Plane<T>& expected) {
  ASSERT_EQ(found.width(), expected.width());
  ASSERT_EQ(found.height(), expected.height());
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      ASSERT_EQ(found(x, y), expected(x, y)) << x << " " << y;
    }
  }
}
template <typename T, int N>
void ExpectPlanes(const Planes<T, N>& found, const Planes<T, N>& expected) {
  for (int c = 0; c < N; ++c) {
    ASSERT_NO_FATAL_FAILURE(ExpectPlane(found[c], expected[c])) << "channel " << c;
  }
}

inline void ExpectLight(const Frame& found, const Frame& expected) {
  ASSERT_EQ(found.signals.size(), expected.signals.size());
  for (size_t k = 0; k < expected.signals.size(); ++k) {
    SCOPED_TRACE(SignalName(expected.signals[k].kind));
    EXPECT_EQ(found.signals[k].kind, expected.signals[k].kind);
    ExpectPlanes(found.signals[k].radiance, expected.signals[k].radiance);
    ExpectPlane(found.signals[k].second_moment, expected.signals[k].second_moment);
  }
  ExpectPlane(found.samples, expected.samples);
  ExpectPlanes(found.emission, expected.emission);
  ExpectPlanes(found.background, expected.background);
}

inline void ExpectGuides(const Guides& found, const Guides& expected) {
  ExpectPlane(found.depth, expected.depth);
  ExpectPlanes(found.normal, expected.normal);
  ExpectPlanes(found.albedo, expected.albedo);
  ExpectPlanes(found.specular_albedo, expected.specular_albedo);
  ExpectPlanes(found.transmission_albedo, expected.transmission_albedo);
  ExpectPlanes(found.motion, expected.motion);
  ExpectPlane(found.id, expected.id);
  ExpectPlane(found.roughness, expected.roughness);
  // Those of host frames are computed on the host.
  ASSERT_EQ(found.previous_normal.width(), expected.previous_normal.width());
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < expected.previous_normal.height(); ++y) {
      for (int x = 0; x < expected.previous_normal.width(); ++x) {
        ASSERT_NEAR(found.previous_normal[c](x, y), expected.previous_normal[c](x, y), 1e-5f);
      }
    }
  }
}

inline void ExpectVirtualGuides(const VirtualGuides& found, const VirtualGuides& expected) {
  ExpectPlane(found.depth, expected.depth);
  ExpectPlanes(found.normal, expected.normal);
  ExpectPlanes(found.albedo, expected.albedo);
  ExpectPlanes(found.motion, expected.motion);
  ExpectPlane(found.id, expected.id);
}

inline void ExpectFrame(const Frame& found, const Frame& expected) {
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.index, expected.index);
  EXPECT_EQ(found.jitter_x, expected.jitter_x);
  EXPECT_EQ(found.jitter_y, expected.jitter_y);
  EXPECT_EQ(found.focal_pixels, expected.focal_pixels);
  ExpectLight(found, expected);
  ExpectGuides(found.guides, expected.guides);
  ExpectVirtualGuides(found.reflection, expected.reflection);
  ExpectVirtualGuides(found.refraction, expected.refraction);
  ExpectPlanes(found.guides.transmission_albedo, expected.guides.transmission_albedo);
}

}  // namespace stillray::render
