// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What loading a glTF file gives: the scene or an error that names the fault.
#pragma once

#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "stillray/scene.h"

namespace stillray::test {

inline Scene Loaded(const GltfBuilder& builder) {
  Result<Scene> scene = builder.Load();
  EXPECT_TRUE(scene.ok()) << scene.status().message();
  return scene.ok() ? std::move(scene).value() : Scene();
}

inline void ExpectError(const Result<Scene>& scene, StatusCode code, const std::string& part) {
  ASSERT_FALSE(scene.ok()) << "expected: " << part;
  EXPECT_EQ(scene.status().code(), code) << scene.status().message();
  EXPECT_THAT(scene.status().message(), ::testing::HasSubstr(part));
  EXPECT_THAT(scene.status().message(), ::testing::Not(::testing::HasSubstr("\n")));
}

inline void ExpectBad(const GltfBuilder& builder, const std::string& part) {
  ExpectError(builder.Load(), StatusCode::kBadData, part);
}

}  // namespace stillray::test
