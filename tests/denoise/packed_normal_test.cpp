// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Packed normals against the octahedral map in double precision.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include <gtest/gtest.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/packed_normal_test.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/packed_normal-inl.h"

#ifndef STILLRAY_PACKED_NORMAL_TEST_ONCE
#define STILLRAY_PACKED_NORMAL_TEST_ONCE
namespace stillray::test {

struct Direction {
  double x, y, z;
};

inline vec3 ToFloats(const Direction& n) {
  return {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
}

/// Calls check(direction) for directions spread evenly over the sphere, for those of the axes and
/// corners, and for some just beside the equator, where the map folds.
inline void ForDirections(const std::function<void(const Direction&)>& check) {
  constexpr int kCount = 60000;
  const double golden = M_PI * (3 - std::sqrt(5.0));
  for (int i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCount;
    const double r = std::sqrt(1 - z * z);
    check({r * std::cos(golden * i), r * std::sin(golden * i), z});
  }
  for (int i = 0; i < 1000; ++i) {
    const double angle = 2 * M_PI * i / 1000;
    for (const double z : {-1e-3, -1e-6, 0.0, 1e-6, 1e-3}) {
      const double r = std::sqrt(1 - z * z);
      check({r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  for (int i = 0; i < 27; ++i) {
    const Direction n = {i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
    const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    if (length > 0) {
      check({n.x / length, n.y / length, n.z / length});
    }
  }
}

/// The radians between a direction and a unit vector.
inline double AngleBetween(const Direction& a, vec3 b) {
  const double x = a.y * b.z - a.z * b.y;
  const double y = a.z * b.x - a.x * b.z;
  const double z = a.x * b.y - a.y * b.x;
  return std::atan2(std::sqrt(x * x + y * y + z * z), a.x * b.x + a.y * b.y + a.z * b.z);
}

/// Half a step of 1 / 32767 in both coordinates is sqrt(1/2) of one; the map stretches it threefold
/// at most, at the centres of the octahedron's faces. Floats add some 1e-7.
inline constexpr double kMostAngle = 3 * 0.70710678 / 32767 + 3e-7;

}  // namespace stillray::test
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void CheckVectors() {
  const DF d;
  double worst = 0;
  int other = 0;
  int count = 0;
  test::ForDirections([&](const test::Direction& n) HWY_ATTR {
    const vec3 in = test::ToFloats(n);
    const VF vectors[3] = {hn::Set(d, in.x), hn::Set(d, in.y), hn::Set(d, in.z)};
    const VU packed = PackNormal(vectors);
    VF back[3];
    UnpackNormal(packed, back);
    const vec3 out = {hn::GetLane(back[0]), hn::GetLane(back[1]), hn::GetLane(back[2])};
    worst = std::max(worst, test::AngleBetween(n, out));
    const vec3 expected = stillray::UnpackNormal(hn::GetLane(packed));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(out[c], expected[c], 5e-7f);  // a few roundings
    }
    other += hn::GetLane(packed) != stillray::PackNormal(in) ? 1 : 0;
    ++count;
  });
  EXPECT_LT(worst, test::kMostAngle) << hwy::TargetName(HWY_TARGET);
  EXPECT_LT(other, count / 500) << "codes that the scalar version rounds otherwise";
  const VF none[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  VF back[3];
  UnpackNormal(PackNormal(none), back);
  EXPECT_EQ(hn::GetLane(PackNormal(none)), 0u);
  for (const VF& component : back) {
    EXPECT_EQ(hn::GetLane(component), 0.0f);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "denoise/every_target.h"

namespace stillray {
namespace {

HWY_EXPORT(CheckVectors);

TEST(PackedNormal, VectorsAreThoseOfTheScalarVersion) {
  test::OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckVectors)(); });
}

TEST(Octahedral, CornersAndFolds) {
  const auto expect = [](vec3 n, float x, float y) {
    const vec2 e = OctahedralEncode(n);
    EXPECT_FLOAT_EQ(e.x, x);
    EXPECT_FLOAT_EQ(e.y, y);
  };
  expect({0, 0, 1}, 0, 0);
  expect({1, 0, 0}, 1, 0);
  expect({0, -1, 0}, 0, -1);
  expect({0, 0, -1}, 1, 1);  // the lower pole is where the corners meet
  // (1, 2, -2) / 3 lies on the octahedron at (0.2, 0.4, -0.4): folded to (1 - 0.4, 1 - 0.2).
  expect({1.0f / 3, 2.0f / 3, -2.0f / 3}, 0.6f, 0.8f);
}

/// The point of the octahedron |x| + |y| + |z| = 1 at a code, in double precision and by cases.
test::Direction PointAt(uint32_t packed) {
  const double u = ((packed & 0xffffu) - 32768.0) / 32767.0;
  const double v = ((packed >> 16) - 32768.0) / 32767.0;
  const double z = 1 - std::abs(u) - std::abs(v);
  const auto folded = [](double sign_of, double other) {
    return (sign_of < 0 ? -1 : 1) * (1 - std::abs(other));
  };
  const test::Direction p =
      z >= 0 ? test::Direction{u, v, z} : test::Direction{folded(u, v), folded(v, u), z};
  const double length = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  return {p.x / length, p.y / length, p.z / length};
}

TEST(PackedNormal, EveryDirectionIsWithinTheBound) {
  double worst = 0;
  double sum = 0;
  int count = 0;
  test::ForDirections([&](const test::Direction& n) {
    const uint32_t packed = PackNormal(test::ToFloats(n));
    ASSERT_NE(packed, 0u);
    const vec3 back = UnpackNormal(packed);
    ASSERT_NEAR(dot(back, back), 1, 5e-7);
    const test::Direction exact = PointAt(packed);
    ASSERT_NEAR(back.x, exact.x, 2e-7);
    ASSERT_NEAR(back.y, exact.y, 2e-7);
    ASSERT_NEAR(back.z, exact.z, 2e-7);
    const double angle = test::AngleBetween(n, back);
    worst = std::max(worst, angle);
    sum += angle;
    ++count;
  });
  EXPECT_LT(worst, test::kMostAngle);
  EXPECT_GT(worst, 0.9 * test::kMostAngle);  // the bound is tight
  EXPECT_NEAR(sum / count, 2.3e-5, 4e-6);
}

// No neighbouring code is nearer by more than the rounding: along each coordinate the nearest of
// the codes is taken. Diagonally stretched cells make a neighbour slightly nearer for some.
TEST(PackedNormal, RoundsTheOctahedralCoordinatesToNearest) {
  test::ForDirections([](const test::Direction& n) {
    const double scale = 1 / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    double u = n.x * scale;
    double v = n.y * scale;
    if (n.z < 0) {
      const double was = u;
      u = (u < 0 ? -1 : 1) * (1 - std::abs(v));
      v = (v < 0 ? -1 : 1) * (1 - std::abs(was));
    }
    const uint32_t packed = PackNormal(test::ToFloats(n));
    // Where the map folds, a rounding of the sign leads to another code of the same direction.
    if (std::min({std::abs(n.x), std::abs(n.y), std::abs(n.z)}) > 1e-5) {
      EXPECT_NEAR((packed & 0xffffu) - 32768.0, u * 32767, 0.51);
      EXPECT_NEAR((packed >> 16) - 32768.0, v * 32767, 0.51);
    }
  });
}

TEST(PackedNormal, RoundingAgainChangesNothing) {
  test::ForDirections([](const test::Direction& n) {
    const vec3 once = UnpackNormal(PackNormal(test::ToFloats(n)));
    const vec3 twice = UnpackNormal(PackNormal(once));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(twice[c], once[c], 2e-7f);
    }
  });
}

TEST(PackedNormal, NoneStaysNone) {
  EXPECT_EQ(PackNormal(vec3(0.0f)), 0u);
  EXPECT_EQ(UnpackNormal(0), vec3(0.0f));
  // Codes that PackNormal never makes, as a damaged file may have them, are directions too.
  for (const uint32_t code : {1u, 0xffffu, 0x10000u, 0x80000000u, 0xffff0000u}) {
    const vec3 n = UnpackNormal(code);
    EXPECT_NEAR(dot(n, n), 1, 1e-6) << code;
  }
}

}  // namespace
}  // namespace stillray
#endif
