// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What mirrors show in a sequence: the motion of known cameras, and frames whose layers do not
// determine that of the camera.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/mirror_file.h"
#include "io/mirror_room.h"
#include "io/test_files.h"
#include "sequence/frames.h"
#include "stillray/sequence.h"

namespace stillray::images_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

RoomCamera CameraOfFrame(int64_t frame) {
  RoomCamera camera;
  camera.position.x = 0.05 * static_cast<double>(frame);
  camera.pan = -0.1 + 0.01 * static_cast<double>(frame);
  return camera;
}

RoomPicture PictureOf(int64_t frame) {
  RoomOptions options;
  options.outliers = 0;
  return Trace(RoomWithMirror(), CameraOfFrame(frame), CameraOfFrame(frame - 1), options);
}

/// As if everything but the mirror moved.
void SpoilMotion(RoomPicture* picture) {
  for (int y = 0; y < picture->frame.height; ++y) {
    for (int x = 0; x < picture->frame.width; ++x) {
      if (!(picture->expected.depth(x, y) > 0)) {
        picture->frame.guides.motion[0](x, y) = static_cast<float>((x * 37 + y * 91) % 19);
      }
    }
  }
}

std::string Rows(const glm::dmat4& columns) {
  std::string text;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      text += fmt::format("{}{:.17g}", text.empty() ? "" : ", ", columns[column][row]);
    }
  }
  return text;
}

/// An entry of a file of cameras, which look along -z in OpenGL's clip space.
std::string CameraText(int64_t frame, int width, int height) {
  const RoomCamera camera = CameraOfFrame(frame);
  glm::dmat4 view(1.0);
  const glm::dvec3 origin = camera.InCamera(glm::dvec3(0.0));
  view[3] = {origin.x, origin.y, -origin.z, 1};
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 axis(0.0);
    axis[i] = 1;
    const glm::dvec3 v = camera.InCamera(axis) - origin;
    view[i] = {v.x, v.y, -v.z, 0};
  }
  glm::dmat4 projection(0.0);
  projection[0][0] = 1 / camera.tangent;
  projection[1][1] = static_cast<double>(width) / height / camera.tangent;
  projection[2] = {0, 0, -1.002, -1};
  projection[3] = {0, 0, -0.2002, 0};
  return fmt::format(
      "{{\"frame\": {}, \"type\": \"perspective\", \"world_to_camera\": [{}], "
      "\"projection\": [{}]}}",
      frame, Rows(view), Rows(projection));
}

class Images : public ::testing::Test {
 protected:
  static constexpr int64_t kFrames = 4;

  /// Frames of a room with a mirror. \param spoiled  those whose motion reveals no camera
  SequenceOptions Write(const std::vector<int64_t>& spoiled) {
    SequenceOptions options;
    fs::create_directories(folder_.Path("out"));
    for (int64_t frame = 1; frame <= kFrames; ++frame) {
      RoomPicture picture = PictureOf(frame);
      if (std::find(spoiled.begin(), spoiled.end(), frame) != spoiled.end()) {
        SpoilMotion(&picture);
      }
      const std::string name = fmt::format("f.{}.exr", frame);
      EXPECT_TRUE(WriteExr(folder_.Path(name), FileOf(picture)).ok());
      options.files.push_back({frame, folder_.Path(name), folder_.Path("out/" + name)});
    }
    options.aovs.renderer = "blender";
    options.settings = PresetSettings("default").value();
    return options;
  }

  void WriteCameras(SequenceOptions* options) {
    std::string frames;
    for (const SequenceFile& file : options->files) {
      frames += (frames.empty() ? "" : ", ") + CameraText(file.frame, 160, 120);
    }
    const std::string text = fmt::format(
        "{{\"version\": 1, \"width\": 160, \"height\": 120, \"frames\": [{}]}}", frames);
    options->cameras = folder_.Path("cameras.json");
    ASSERT_TRUE(WriteFileAtomically(options->cameras, text.data(), text.size()).ok());
  }

  struct Run {
    std::vector<std::string> notes;    ///< on images
    std::vector<std::string> missing;  ///< FrameReport::images_missing
  };
  Run Denoise(const SequenceOptions& options) {
    Run run;
    SequenceHooks hooks;
    hooks.note = [&](const std::string& text) {
      if (text.find("reflections") != std::string::npos) {
        run.notes.push_back(text);
      }
    };
    Result<SequenceDenoiser> sequence = SequenceDenoiser::Create(options, Device(), hooks);
    EXPECT_TRUE(sequence.ok()) << sequence.status().message();
    if (sequence.ok()) {
      EXPECT_TRUE(sequence->Run().status.ok());
      for (const std::string& note : sequence->layout().notes) {
        if (note.find("reflections") != std::string::npos) {
          run.notes.push_back(note);
        }
      }
      for (const FrameReport& report : sequence->reports()) {
        run.missing.push_back(report.images_missing);
      }
    }
    return run;
  }

  TempFolder folder_;
};

constexpr const char* kFollow = "reflections in mirrors and what is seen through glass follow";

TEST_F(Images, AFrameWhoseMotionRevealsNoCameraIsReportedOnce) {
  const Run run = Denoise(Write({2, 4}));
  EXPECT_THAT(run.notes,
              ElementsAre(AllOf(HasSubstr("frame 2: reflections and refractions do not follow "
                                          "V.Denoising Depth, and are blurred where they move"),
                                HasSubstr("V.Vector is not the motion of a camera"),
                                HasSubstr("--cameras FILE.json")),
                          HasSubstr(kFollow)));
  EXPECT_THAT(run.missing, ElementsAre(IsEmpty(), Not(IsEmpty()), IsEmpty(), Not(IsEmpty())));
}

TEST_F(Images, WhatTheNotesOnTheFirstFileSayIsNotRepeated) {
  const Run run = Denoise(Write({1, 2, 3}));
  EXPECT_THAT(run.notes, ElementsAre(HasSubstr("V.Vector is not the motion of a camera")));
  EXPECT_THAT(run.missing, ElementsAre(Not(IsEmpty()), Not(IsEmpty()), Not(IsEmpty()), IsEmpty()));
}

TEST_F(Images, KnownCamerasNeedNoFit) {
  SequenceOptions options = Write({1, 2, 3, 4});
  WriteCameras(&options);
  for (const Window window : {Window::kPast, Window::kBoth}) {
    options.window = window;
    const Run run = Denoise(options);
    EXPECT_THAT(run.notes, ElementsAre(HasSubstr(kFollow)));
    EXPECT_THAT(run.missing, Each(IsEmpty()));
  }
}

TEST_F(Images, KnownCamerasGiveTheExactMotion) {
  SequenceOptions options = Write({1, 2, 3, 4});
  WriteCameras(&options);
  const Result<LoadedFile> first = LoadFile(options.files[0].input, options, false);
  ASSERT_TRUE(first.ok());
  const Result<AovLayout> layout = UnderstandAovs(first->image, options.aovs, "first");
  ASSERT_TRUE(layout.ok());
  const Result<MotionPlan> plan = PlanMotion(options, *layout, first->image);
  ASSERT_TRUE(plan.ok()) << plan.status().message();
  const SequenceView view = {options, *layout, *plan};
  const Result<SequenceFrame> before = LoadFrame(options.files[1], view, false);
  Result<SequenceFrame> now = LoadFrame(options.files[2], view, false);
  ASSERT_TRUE(before.ok() && now.ok());
  LinkToPrevious(*before, view, &*now);
  const VirtualGuides expected = PictureOf(3).expected;
  const VirtualGuides& reflection = now->frame.reflection;
  int shown = 0;
  int right = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (expected.depth(x, y) > 0 && reflection.depth(x, y) > 0) {
        ++shown;
        right += std::hypot(reflection.motion[0](x, y) - expected.motion[0](x, y),
                            reflection.motion[1](x, y) - expected.motion[1](x, y)) < 0.02f;
      }
    }
  }
  EXPECT_GT(shown, 2000);
  EXPECT_GT(right, 0.985 * shown);
}

/// The images of a frame as its own file and those of another one give them.
struct Moved {
  int shown = 0;
  int right = 0;  ///< of the motion that is expected, up to 0.02 pixels
};

Moved CompareMotion(const VirtualGuides& found, const VirtualGuides& expected, vec2 offset) {
  Moved moved;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (expected.depth(x, y) > 0 && found.depth(x, y) > 0) {
        ++moved.shown;
        moved.right +=
            std::hypot(found.motion[0](x, y) - expected.motion[0](x, y) - offset.x,
                       found.motion[1](x, y) - expected.motion[1](x, y) - offset.y) < 0.02f;
      }
    }
  }
  return moved;
}

/// A file with hit distances and the motion of reflections, without Denoising Data, whose motion
/// reveals no camera.
ExrImage FileWithHits(int64_t frame) {
  RoomPicture picture = PictureOf(frame);
  SpoilMotion(&picture);
  Image1 hits(160, 120);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const float image = picture.expected.depth(x, y);
      const auto secant =
          static_cast<float>(glm::length(CameraOfFrame(frame).Ray(PointOfPixel(160, 120, x, y))));
      hits(x, y) = image > 0 ? (image - picture.frame.guides.depth(x, y)) * secant : 0.0f;
    }
  }
  ExrImage file = FileOf(picture, "Denoising");
  file.Add("V.Hit.Z", PixelType::kFloat, hits);
  file.Add("V.SpecVec.X", PixelType::kFloat, picture.expected.motion[0]);
  file.Add("V.SpecVec.Y", PixelType::kFloat, picture.expected.motion[1]);
  return file;
}

/// The reflection of frame 3, linked to frame 2.
VirtualGuides LinkedReflection(const SequenceOptions& options) {
  const Result<LoadedFile> first = LoadFile(options.files[0].input, options, false);
  EXPECT_TRUE(first.ok());
  const Result<AovLayout> layout = UnderstandAovs(first->image, options.aovs, "first");
  EXPECT_TRUE(layout.ok()) << layout.status().message();
  const Result<MotionPlan> plan = PlanMotion(options, *layout, first->image);
  EXPECT_TRUE(plan.ok()) << plan.status().message();
  const SequenceView view = {options, *layout, *plan};
  const Result<SequenceFrame> before = LoadFrame(options.files[1], view, false);
  Result<SequenceFrame> now = LoadFrame(options.files[2], view, false);
  EXPECT_TRUE(before.ok() && now.ok());
  LinkToPrevious(*before, view, &*now);
  return now->frame.reflection;
}

class HitImages : public Images {
 protected:
  /// \param jitter  of frames 2 and 3; of one that has none, empty
  SequenceOptions WriteHits(const std::vector<std::string>& mappings,
                            const std::string& jitter_before = "", const std::string& jitter = "") {
    SequenceOptions options = Write({1, 2, 3, 4});
    for (const SequenceFile& file : options.files) {
      ExrImage image = FileWithHits(file.frame);
      const std::string& text = file.frame == 2 ? jitter_before : file.frame == 3 ? jitter : "";
      if (!text.empty()) {
        image.attributes["jitter"] = text;
      }
      EXPECT_TRUE(WriteExr(file.input, image).ok());
    }
    options.aovs.mappings = mappings;
    return options;
  }
};

TEST_F(HitImages, FollowKnownCameras) {
  SequenceOptions options = WriteHits({"hit_distance=Hit"});
  const Run without = Denoise(options);
  EXPECT_THAT(without.notes, ElementsAre(HasSubstr("reflections do not follow V.Hit, and are "
                                                   "blurred where they move: V.Vector is not")));
  EXPECT_THAT(without.missing, Each(Not(IsEmpty())));
  WriteCameras(&options);
  const Run with = Denoise(options);
  EXPECT_THAT(with.notes, ElementsAre("reflections follow V.Hit"));
  EXPECT_THAT(with.missing, Each(IsEmpty()));
  const Moved moved = CompareMotion(LinkedReflection(options), PictureOf(3).expected, vec2(0.0f));
  EXPECT_GT(moved.shown, 2000);
  EXPECT_GT(moved.right, 0.985 * moved.shown);
}

TEST_F(HitImages, FollowTheMotionThatIsGiven) {
  SequenceOptions options =
      WriteHits({"hit_distance=Hit", "specular_motion=SpecVec,y_down"}, "0.25 0.1", "-0.2 0.3");
  const Moved moved = CompareMotion(LinkedReflection(options), PictureOf(3).expected, vec2(0.0f));
  EXPECT_GT(moved.shown, 2000);
  EXPECT_GT(moved.right, 0.985 * moved.shown);
  // With known cameras, too, what is given counts; and the jitter of both frames is taken off.
  WriteCameras(&options);
  options.aovs.mappings = {"hit_distance=Hit", "specular_motion=SpecVec,y_down,jittered"};
  const Moved jittered = CompareMotion(LinkedReflection(options), PictureOf(3).expected,
                                       vec2(0.25f + 0.2f, 0.1f - 0.3f));
  EXPECT_GT(jittered.right, 0.985 * jittered.shown);
}

}  // namespace
}  // namespace stillray::images_test
