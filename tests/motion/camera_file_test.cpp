// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Cameras from JSON: the motion that follows from them against rays that are traced here without
// any matrix, and files that are wrong.
#include "motion/camera_file.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "stillray/vec.h"

namespace stillray::motion::camera_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr int kWidth = 160;
constexpr int kHeight = 90;
constexpr double kNear = 0.1;
constexpr double kFar = 100;

/// A camera as its position and axes.
struct TestCamera {
  bool perspective = true;
  glm::dvec3 eye{0.0};
  glm::dvec3 right{1, 0, 0};
  glm::dvec3 up{0, 1, 0};
  glm::dvec3 back{0, 0, 1};  ///< it looks along -back
  double half_width = 0.6;   ///< of the picture at distance 1; of all of it without perspective
  glm::dvec2 shift{0.0};     ///< of the lens, as part of half the picture

  double half_height() const { return half_width * kHeight / kWidth; }

  /// Turns about `up`, to the left.
  TestCamera Turned(double angle) const {
    TestCamera turned = *this;
    turned.right = std::cos(angle) * right - std::sin(angle) * back;
    turned.back = std::sin(angle) * right + std::cos(angle) * back;
    return turned;
  }

  TestCamera Tilted(double angle) const {
    TestCamera tilted = *this;
    tilted.up = std::cos(angle) * up + std::sin(angle) * back;
    tilted.back = std::cos(angle) * back - std::sin(angle) * up;
    return tilted;
  }

  /// The point at depth z that the pixel shows.
  glm::dvec3 Point(int x, int y, double z) const {
    const double u = 2 * (x + 0.5) / kWidth - 1 + shift.x;
    const double v = 1 - 2 * (y + 0.5) / kHeight + shift.y;
    const double scale = perspective ? z : 1.0;
    return eye + scale * (u * half_width * right + v * half_height() * up) - z * back;
  }

  /// Where the picture shows a point, in pixels.
  glm::dvec2 Pixel(const glm::dvec3& point) const {
    const glm::dvec3 offset = point - eye;
    const double scale = perspective ? -glm::dot(offset, back) : 1.0;
    const double u = glm::dot(offset, right) / (scale * half_width) - shift.x;
    const double v = glm::dot(offset, up) / (scale * half_height()) - shift.y;
    return {(u + 1) * 0.5 * kWidth, (1 - v) * 0.5 * kHeight};
  }

  Json ToJson(int64_t frame) const {
    std::vector<double> view;
    for (const glm::dvec3& axis : {right, up, back}) {
      view.insert(view.end(), {axis.x, axis.y, axis.z, -glm::dot(axis, eye)});
    }
    view.insert(view.end(), {0, 0, 0, 1});
    const double sx = 1 / half_width;
    const double sy = 1 / half_height();
    const double depth = kFar - kNear;
    const std::vector<double> projection =
        perspective
            ? std::vector<double>{sx,
                                  0,
                                  shift.x,
                                  0,
                                  0,
                                  sy,
                                  shift.y,
                                  0,
                                  0,
                                  0,
                                  -(kFar + kNear) / depth,
                                  -2 * kFar * kNear / depth,
                                  0,
                                  0,
                                  -1,
                                  0}
            : std::vector<double>{sx, 0,        0, -shift.x, 0,          sy,
                                  0,  -shift.y, 0, 0,        -2 / depth, -(kFar + kNear) / depth,
                                  0,  0,        0, 1};
    return {{"frame", frame},
            {"world_to_camera", view},
            {"projection", projection},
            {"type", perspective ? "perspective" : "orthographic"},
            {"shutter", {-0.25, 0.25}},
            {"near", kNear},
            {"far", kFar}};
  }
};

Json FileOf(const std::vector<TestCamera>& cameras) {
  Json frames = Json::array();
  for (size_t i = 0; i < cameras.size(); ++i) {
    frames.push_back(cameras[i].ToJson(static_cast<int64_t>(i) + 1));
  }
  return {{"version", 1}, {"width", kWidth}, {"height", kHeight}, {"frames", frames}};
}

/// A slanted wall, whose depth differs from pixel to pixel.
double DepthOf(int x, int y) {
  return 4 + 0.02 * x - 0.01 * y;
}

void ExpectExactMotion(const Json& json, const TestCamera& before, const TestCamera& now) {
  const Result<CameraFile> file = ParseCameraFile(json.dump(), "cameras.json");
  ASSERT_TRUE(file.ok()) << file.status().message();
  Image1 depth(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      depth(x, y) = static_cast<float>(DepthOf(x, y));
    }
  }
  const Image2 motion = MotionFromCameras(depth, **file->Camera(2), **file->Camera(1));
  for (int y = 0; y < kHeight; y += 7) {
    for (int x = 0; x < kWidth; x += 7) {
      const glm::dvec2 was = before.Pixel(now.Point(x, y, DepthOf(x, y)));
      EXPECT_NEAR(motion[0](x, y), was.x - (x + 0.5), 1e-3) << x << " " << y;
      EXPECT_NEAR(motion[1](x, y), was.y - (y + 0.5), 1e-3) << x << " " << y;
    }
  }
}

void ExpectExactMotion(const TestCamera& before, const TestCamera& now) {
  ExpectExactMotion(FileOf({before, now}), before, now);
}

TEST(CameraFiles, ATranslatingCameraIsExact) {
  TestCamera now;
  now.eye = {0.11, -0.07, -0.2};
  ExpectExactMotion(TestCamera(), now);
}

TEST(CameraFiles, ATurningCameraIsExact) {
  TestCamera now = TestCamera().Turned(0.05).Tilted(-0.03);
  now.eye = {0.02, 0.01, 0};
  ExpectExactMotion(TestCamera(), now);
}

TEST(CameraFiles, AZoomIsExact) {
  TestCamera now;
  now.half_width = 0.55;
  ExpectExactMotion(TestCamera(), now);
}

TEST(CameraFiles, AShiftedLensIsExact) {
  TestCamera before;
  before.shift = {0.3, -0.9};
  TestCamera now = before.Turned(0.02);
  now.shift = {0.35, -0.9};
  ExpectExactMotion(before, now);
}

// Without perspective a turn moves what is far by more, in the direction that depends on the sign
// of z.
TEST(CameraFiles, AnOrthographicCameraIsExact) {
  TestCamera before;
  before.perspective = false;
  before.half_width = 3;
  TestCamera now = before.Turned(0.04).Tilted(0.02);
  now.eye = {0.1, 0.05, 0.3};
  now.shift = {0.1, 0.02};
  ExpectExactMotion(before, now);
}

/// A camera that moves and turns steadily from frame to frame, but by another speed in each; `time`
/// is that of the frame's shutter.
TestCamera OnItsWay(int frame, double time) {
  const double way = frame == 1 ? time : 1 + 3 * time;
  TestCamera camera = TestCamera().Turned(0.03 * way);
  camera.eye = way * glm::dvec3(0.05, -0.02, -0.04);
  return camera;
}

/// A frame with a shutter, and the poses at its ends.
Json FrameWithShutter(int frame, double open, double close) {
  Json json = OnItsWay(frame, 0).ToJson(frame);
  json["shutter"] = {open, close};
  for (const double time : {close, open}) {
    if (time != 0) {
      json["motion"].push_back(
          {{"time", time},
           {"world_to_camera", OnItsWay(frame, time).ToJson(0)["world_to_camera"]}});
    }
  }
  return json;
}

void ExpectMotionOfMiddles(double open, double close) {
  const double middle = (open + close) / 2;
  Json json = FileOf({});
  json["frames"] = {FrameWithShutter(1, open, close), FrameWithShutter(2, open, close)};
  ExpectExactMotion(json, OnItsWay(1, middle), OnItsWay(2, middle));
}

TEST(CameraFiles, MotionIsThatBetweenTheMiddlesOfShutters) {
  ExpectMotionOfMiddles(0, 0.8);       // opens with the frame
  ExpectMotionOfMiddles(-0.8, 0);      // closes with it
  ExpectMotionOfMiddles(-0.25, 0.25);  // around it
  ExpectMotionOfMiddles(-0.1, 0.7);
}

TEST(CameraFiles, WithoutPosesAroundTheMiddleTheFramesPoseCounts) {
  Json json = FileOf({});
  json["frames"] = {FrameWithShutter(1, 0, 0.8), FrameWithShutter(2, 0, 0.8)};
  json["frames"][0].erase("motion");
  json["frames"][1]["motion"][0]["time"] = 0.3;  // ends before the middle
  ExpectExactMotion(json, OnItsWay(1, 0), OnItsWay(2, 0));
  json["frames"][1] = FrameWithShutter(2, 0, 0.8);
  for (int i = 0; i < 12; ++i) {  // scaled: between the poses is no steady way
    Json& entry = json["frames"][1]["motion"][0]["world_to_camera"][static_cast<size_t>(i)];
    entry = 2 * entry.get<double>();
  }
  ExpectExactMotion(json, OnItsWay(1, 0), OnItsWay(2, 0));
}

// Blender 5 has cameras of the type "custom".
TEST(CameraFiles, PanoramasAndOtherTypesHaveNoMatrix) {
  for (const char* type : {"panoramic", "custom"}) {
    for (const bool is_null : {true, false}) {
      Json json = FileOf({TestCamera(), TestCamera()});
      Json& second = json["frames"][1];
      second["type"] = type;
      if (is_null) {
        second["projection"] = nullptr;
      } else {
        second.erase("projection");
      }
      const Result<CameraFile> file = ParseCameraFile(json.dump(), "c.json");
      ASSERT_TRUE(file.ok()) << file.status().message();
      EXPECT_TRUE(file->Camera(1)->has_value());
      EXPECT_FALSE(file->Camera(2)->has_value()) << type;
    }
  }
}

TEST(CameraFiles, AMissingFrameIsNamed) {
  const Result<CameraFile> file = ParseCameraFile(FileOf({TestCamera()}).dump(), "c.json");
  ASSERT_TRUE(file.ok()) << file.status().message();
  const Status status = file->Camera(7).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(),
              HasSubstr("c.json has no camera of frame 7: it has 1 frames from 1 to 1"));
}

TEST(CameraFiles, AMissingFileIsNamed) {
  EXPECT_THAT(ReadCameraFile("/nonexistent/c.json").status().message(),
              HasSubstr("/nonexistent/c.json"));
}

/// A change that makes the file wrong, and what the message says.
struct Wrong {
  const char* name;
  void (*change)(Json* json);
  std::vector<const char*> says;
};

Json& Matrix(Json* json, const char* name) {
  return (*json)["frames"][0][name];
}

const Wrong kWrong[] = {
    {"version", [](Json* j) { (*j)["version"] = 2; }, {"c.json: version is 2, expected 1"}},
    {"no_version", [](Json* j) { j->erase("version"); }, {"version is missing, expected 1"}},
    {"list", [](Json* j) { *j = Json::array(); }, {"no JSON object"}},
    {"width", [](Json* j) { (*j)["width"] = 0; }, {"width is 0, expected a whole number from 1"}},
    {"height", [](Json* j) { (*j)["height"] = 90.5; }, {"height is 90.5"}},
    {"huge",
     [](Json* j) { (*j)["height"] = 18446744073709551615u; },
     {"height is 18446744073709551615"}},
    {"no_frames",
     [](Json* j) { (*j)["frames"] = Json::array(); },
     {"frames is [], expected a list of one or more cameras"}},
    {"frames_object", [](Json* j) { (*j)["frames"] = Json::object(); }, {"frames is {}"}},
    {"frame_number",
     [](Json* j) { (*j)["frames"][0] = 3; },
     {"frames[0] is 3, expected an object"}},
    {"no_number",
     [](Json* j) { (*j)["frames"][0].erase("frame"); },
     {"frames[0].frame is missing"}},
    {"text_number",
     [](Json* j) { (*j)["frames"][0]["frame"] = "1"; },
     {"frames[0].frame is \"1\""}},
    {"twice",
     [](Json* j) { (*j)["frames"].push_back((*j)["frames"][0]); },
     {"frames[1].frame is 1, expected a number that no frame before it has"}},
    {"type",
     [](Json* j) { (*j)["frames"][0]["type"] = "fisheye"; },
     {"frames[0].type is \"fisheye\"", "panoramic", "null as its projection"}},
    {"number_type",
     [](Json* j) { (*j)["frames"][0]["type"] = 3; },
     {"frames[0].type is 3", "\"perspective\""}},
    {"no_type", [](Json* j) { (*j)["frames"][0].erase("type"); }, {"frames[0].type is missing"}},
    {"short",
     [](Json* j) { Matrix(j, "projection").erase(15); },
     {"frames[0].projection is [", "expected 16 finite numbers"}},
    {"null",
     [](Json* j) { Matrix(j, "world_to_camera")[3] = nullptr; },
     {"frames[0].world_to_camera[3] is null, expected 16 finite numbers"}},
    {"large",
     [](Json* j) { Matrix(j, "world_to_camera")[3] = 1e300; },
     {"world_to_camera[3] is 1e+300"}},
    {"singular",
     [](Json* j) {
       for (int i = 0; i < 4; ++i) {
         Matrix(j, "world_to_camera")[static_cast<size_t>(i)] = 0;
       }
     },
     {"world_to_camera is [", "expected a matrix with an inverse"}},
    {"flat",
     [](Json* j) { Matrix(j, "projection")[0] = 0; },
     {"frames[0].projection is [", "expected a matrix with an inverse"}},
    {"columns",
     [](Json* j) {
       Matrix(j, "world_to_camera") = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1};
     },
     {"has the last row 2 3 4 1, expected 0 0 0 1", "fourth column is the translation"}},
    {"forward",
     [](Json* j) { Matrix(j, "projection")[14] = 1; },
     {"projection has the last row 0 0 1 0, expected 0 0 -1 0", "looks along -z"}},
    {"shutter",
     [](Json* j) {
       (*j)["frames"][0]["shutter"] = {0.5, 0};
     },
     {"frames[0].shutter is [0.5,0], expected that it opens before it closes"}},
    {"shutter_one",
     [](Json* j) { (*j)["frames"][0]["shutter"] = {0.5}; },
     {"expected 2 finite numbers"}},
    {"motion",
     [](Json* j) { (*j)["frames"][0]["motion"] = 5; },
     {"frames[0].motion is 5, expected a list of poses"}},
    {"pose",
     [](Json* j) {
       (*j)["frames"][0]["motion"] = {{{"time", 0.5}}, 7};
       (*j)["frames"][0]["motion"][0]["world_to_camera"] = Matrix(j, "world_to_camera");
     },
     {"frames[0].motion[1] is 7, expected an object"}},
    {"pose_time",
     [](Json* j) {
       (*j)["frames"][0]["motion"][0]["world_to_camera"] = Matrix(j, "world_to_camera");
     },
     {"frames[0].motion[0].time is missing, expected a finite number"}},
    {"pose_matrix",
     [](Json* j) {
       (*j)["frames"][0]["motion"][0] = {{"time", 0.5}, {"world_to_camera", {1, 2}}};
     },
     {"frames[0].motion[0].world_to_camera is [1,2], expected 16 finite numbers"}},
    {"near",
     [](Json* j) { (*j)["frames"][0]["near"] = 0; },
     {"frames[0].near is 0, expected a number above 0"}},
    {"far",
     [](Json* j) { (*j)["frames"][0]["far"] = 0.05; },
     {"frames[0].far is 0.05, expected a number above 0.1"}},
};

class WrongCameraFiles : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongCameraFiles, AreExplained) {
  Json json = FileOf({TestCamera()});
  GetParam().change(&json);
  const Result<CameraFile> file = ParseCameraFile(json.dump(), "c.json");
  EXPECT_EQ(file.status().code(), StatusCode::kBadData);
  for (const char* text : GetParam().says) {
    EXPECT_THAT(file.status().message(), AllOf(HasSubstr("c.json"), HasSubstr(text)));
  }
}

INSTANTIATE_TEST_SUITE_P(All, WrongCameraFiles, ::testing::ValuesIn(kWrong),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(CameraFiles, NumbersMustBeFinite) {
  std::string text = FileOf({TestCamera()}).dump();
  text.replace(text.find("0.1"), 3, "NaN");
  const Result<CameraFile> file = ParseCameraFile(text, "c.json");
  EXPECT_EQ(file.status().code(), StatusCode::kBadData);
  EXPECT_THAT(file.status().message(), HasSubstr("c.json is not JSON (numbers must be finite)"));
  EXPECT_EQ(ParseCameraFile("", "c.json").status().code(), StatusCode::kBadData);
}

}  // namespace
}  // namespace stillray::motion::camera_file_test
