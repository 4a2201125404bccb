// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_engine.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "view/small_session.h"

namespace stillray::view::view_engine_test {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(60);

/// Waits until `done` says so; false if it never does.
bool Until(const std::function<bool()>& done) {
  const Clock::time_point end = Clock::now() + kPatience;
  while (!done()) {
    if (Clock::now() > end) {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

bool FrameWith(ViewEngine* engine, const std::function<bool(const ViewFrame&)>& accept) {
  return Until([&] {
    const ViewFrame* frame = engine->TakeFrame();
    return frame != nullptr && accept(*frame);
  });
}

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "stillray-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

std::string OneMessage(ViewEngine* engine, bool* is_error) {
  std::vector<EngineMessage> messages;
  EXPECT_TRUE(Until([&] {
    messages = engine->TakeMessages();
    return !messages.empty();
  }));
  *is_error = !messages.empty() && messages[0].is_error;
  return messages.empty() ? "" : messages[0].text;
}

TEST(ViewEngine, ShowsFramesAndFollowsSettings) {
  std::atomic<int> wakes = 0;
  ViewEngine engine(SettingsOfSize(96, 64), [&] { ++wakes; });
  engine.Open({"builtin:cornell", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame& f) { return f.number >= 3; }));
  EXPECT_GT(wakes, 0);
  EXPECT_EQ(engine.scene_info().number, 1u);
  EXPECT_GT(engine.scene_info().triangles, 10u);
  EXPECT_FALSE(engine.load_state().loading);

  ViewSettings settings = SettingsOfSize(96, 64);
  settings.width = 60;
  settings.panes = {"normal", "depth"};
  engine.Post(settings);
  EXPECT_TRUE(FrameWith(&engine, [](const ViewFrame& f) {
    return f.width == 60 && f.panes == std::vector<std::string>{"normal", "depth"};
  }));
}

/// A picture of a quarter of the pixels is saved as large as the window shows it.
TEST(ViewEngine, SavesAtTheSizeOfTheWindow) {
  const Folder folder;
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.scale = 0.5f;
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame& f) { return f.width == 48; }));
  engine.Save(folder / "shown.png");
  bool is_error = true;
  OneMessage(&engine, &is_error);
  EXPECT_FALSE(is_error);
  const Rgb8Image saved = ReadPng8(folder / "shown.png").value();
  EXPECT_EQ(saved.width, 96);
  EXPECT_EQ(saved.height, 64);
}

TEST(ViewEngine, ABadFileIsAMessageAndTheOldSceneStays) {
  ViewEngine engine(SettingsOfSize(96, 64), [] {});
  engine.Open({"builtin:cornell", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));
  engine.Open({"no/such/file.glb", ""});
  bool is_error = false;
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("no/such/file.glb"));
  EXPECT_TRUE(is_error);
  EXPECT_EQ(engine.scene_info().number, 1u);
  EXPECT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));
}

TEST(ViewEngine, OfManyRequestsTheLastIsShown) {
  ViewEngine engine(SettingsOfSize(96, 64), [] {});
  for (const char* scene : {"builtin:cornell", "builtin:lights", "builtin:cornell",
                            "builtin:lights", "builtin:spheres"}) {
    engine.Open({scene, ""});
  }
  EXPECT_TRUE(Until([&] { return engine.scene_info().request.scene == "builtin:spheres"; }));
  EXPECT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));
}

TEST(ViewEngine, NoCallWaitsForWork) {
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.width = 640;
  settings.height = 480;
  settings.rate = {16, 1};  // frames that take long
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  double slowest_ms = 0;
  const auto timed = [&](const std::function<void()>& call) {
    const Clock::time_point start = Clock::now();
    call();
    slowest_ms = std::max(slowest_ms,
                          std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  };
  for (int i = 0; i < 60; ++i) {
    settings.width = 600 + i;
    timed([&] { engine.Post(settings); });
    timed([&] { engine.TakeFrame(); });
    timed([&] { engine.TakeMessages(); });
    timed([&] { engine.load_state(); });
    timed([&] { engine.scene_info(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_LT(slowest_ms, 100);
}

TEST(ViewEngine, RestsWhenNothingChangesAndWakesUpAgain) {
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.width = 16;
  settings.height = 16;
  settings.rate = {64, 1};
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  // 4096 samples are enough: 64 frames.
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame& f) { return f.samples >= 4096; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const ViewFrame* more = engine.TakeFrame();
  EXPECT_TRUE(more == nullptr || more->number <= 66) << more->number;
  settings.restart = 1;
  engine.Post(settings);
  EXPECT_TRUE(FrameWith(&engine, [](const ViewFrame& f) { return f.samples < 4096; }));
}

double MeanOf(const Plane<float>& plane) {
  double sum = 0;
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      sum += plane(x, y);
    }
  }
  return sum / (static_cast<double>(plane.width()) * plane.height());
}

TEST(ViewEngine, SavesWhatIsShown) {
  const Folder folder;
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.panes = {"noisy", "denoised", "motion"};
  ViewEngine engine(settings, [] {});
  bool is_error = false;
  engine.Save(folder / "early.png");
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("no picture"));
  engine.Open({"builtin:cornell", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));

  engine.Save(folder / "shown.png");
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("shown.png"));
  EXPECT_FALSE(is_error);
  EXPECT_EQ(ReadPng8(folder / "shown.png").value().width, 96);

  engine.Save(folder / "shown.exr");
  OneMessage(&engine, &is_error);
  EXPECT_FALSE(is_error);
  const ExrImage image = ReadExr(folder / "shown.exr").value();
  for (const char* channel : {"R", "G", "B", "denoised.R", "motion.X", "motion.Y"}) {
    EXPECT_NE(image.Find(channel), nullptr) << channel;
  }
  engine.Save(folder / "shown.hdr");
  OneMessage(&engine, &is_error);
  EXPECT_FALSE(is_error);
  bool linear = false;
  const Image3 radiance = ReadImage(folder / "shown.hdr", &linear).value();
  EXPECT_TRUE(linear);
  const Channel* red = image.Find("R");
  ASSERT_EQ(radiance.width(), red->values.width());
  // Of another frame of the same view: the engine goes on between the two.
  EXPECT_NEAR(MeanOf(radiance[0]) / MeanOf(red->values), 1.0, 0.15);
  engine.Save(folder / "shown.JPG");
  OneMessage(&engine, &is_error);
  EXPECT_FALSE(is_error);
  const Image3 displayed = ReadImage(folder / "shown.JPG", &linear).value();
  EXPECT_FALSE(linear);
  EXPECT_EQ(displayed.width(), 96);
  engine.Save(folder / "shown.gif");
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("expected .png, .jpg, .exr or .hdr"));
  EXPECT_TRUE(is_error);
  engine.Save(folder / "no/such/folder/a.png");
  OneMessage(&engine, &is_error);
  EXPECT_TRUE(is_error);
}

/// Pictures that stay on the device are rendered again for files.
TEST(ViewEngine, SavesWhatIsShared) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  const Folder folder;
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.width = 48;
  settings.height = 32;
  settings.render.bounces = 1;
  settings.panes = {"denoised", "noisy"};
  settings.shares_pictures = true;
  ViewEngine engine(
      settings, [] {}, *device);
  engine.Open({"builtin:cornell", ""});
  bool shared = false;
  ASSERT_TRUE(FrameWith(&engine, [&](const ViewFrame& frame) {
    shared = frame.shared[0] != nullptr;
    return true;
  }));
  if (!shared) {
    GTEST_SKIP() << "the device shares no memory";
  }
  bool is_error = false;
  engine.Save(folder / "shown.png");
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("shown.png"));
  EXPECT_FALSE(is_error);
  const Rgb8Image saved = ReadPng8(folder / "shown.png").value();
  EXPECT_EQ(saved.width, 48);
  EXPECT_GT(*std::max_element(saved.pixels.begin(), saved.pixels.end()), 60);
  engine.Save(folder / "shown.exr");
  OneMessage(&engine, &is_error);
  EXPECT_FALSE(is_error);
  EXPECT_NE(ReadExr(folder / "shown.exr").value().Find("R"), nullptr);
}

TEST(ViewEngine, RecordsAClip) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  const Folder folder;
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.playing = true;
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:lights", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));
  engine.StartClip(folder / "clip.mp4", 30);
  ASSERT_TRUE(Until([&] { return engine.recording(); }));
  uint64_t first = 0;
  ASSERT_TRUE(FrameWith(&engine, [&](const ViewFrame& f) {
    first = first == 0 ? f.number : first;
    return f.number >= first + 8;
  }));
  engine.StopClip();
  bool is_error = false;
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("clip.mp4"));
  EXPECT_FALSE(is_error);
  EXPECT_GT(std::filesystem::file_size(folder / "clip.mp4"), 500u);
}

TEST(ViewEngine, AClipEndsWithAMessageWhenTheSizeChanges) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  const Folder folder;
  ViewSettings settings = SettingsOfSize(96, 64);
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  ASSERT_TRUE(FrameWith(&engine, [](const ViewFrame&) { return true; }));
  engine.StartClip(folder / "clip.mp4", 30);
  ASSERT_TRUE(Until([&] { return engine.recording(); }));
  settings.width = 64;
  engine.Post(settings);
  bool is_error = false;
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("clip"));
  EXPECT_TRUE(Until([&] { return !engine.recording(); }));
}

TEST(ViewEngine, MeasuresAStillViewAgainstItsReference) {
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.reference = true;
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  LiveMeasures measures;
  ASSERT_TRUE(FrameWith(&engine, [&](const ViewFrame& f) {
    if (f.measures) {
      measures = *f.measures;
    }
    return f.measures.has_value();
  }));
  EXPECT_GE(measures.reference_spp, 16);
  EXPECT_GT(measures.denoised.psnr, measures.noisy.psnr);
  EXPECT_LT(measures.denoised.flip, measures.noisy.flip);
}

/// The first picture that includes a movement of the camera, in frames after the newest one at that
/// time.
TEST(ViewEngine, TheCameraIsAnsweredWithinTwoFrames) {
  ViewSettings settings = SettingsOfSize(96, 64);
  settings.width = 160;
  settings.height = 100;
  ViewEngine engine(settings, [] {});
  engine.Open({"builtin:cornell", ""});
  ViewPose pose;
  ASSERT_TRUE(FrameWith(&engine, [&](const ViewFrame& f) {
    pose = f.pose;
    return f.number >= 2;
  }));
  settings.free_camera = true;
  settings.pose_scene = 1;
  for (int i = 0; i < 16; ++i) {
    // At any moment of a frame.
    std::this_thread::sleep_for(std::chrono::milliseconds(3 * (i % 8)));
    pose = Orbit(pose, 0.02f, 0.01f);
    settings.pose = pose;
    const uint64_t made = engine.frames_made();
    const uint64_t posted = engine.Post(settings);
    ViewFrame answer;
    ASSERT_TRUE(FrameWith(&engine, [&](const ViewFrame& f) {
      answer = f;
      return f.pose == pose;
    }));
    EXPECT_GE(answer.posted, posted);
    EXPECT_LE(answer.number, made + 2) << "movement " << i;
  }
}

TEST(ViewEngine, TellsThePhasesOfLoading) {
  std::vector<LoadPhase> phases;
  const Result<LoadedScene> loaded =
      LoadForView({"builtin:cornell", ""}, SettingsOfSize(96, 64), [&](const LoadPhase& phase) {
        phases.push_back(phase);
        return true;
      });
  ASSERT_TRUE(loaded.ok());
  ASSERT_GE(phases.size(), 3u);
  for (const LoadPhase& phase : phases) {
    EXPECT_EQ(phase.steps, 3);
    EXPECT_LE(phase.fraction, 1);
  }
  EXPECT_EQ(phases.front().step, 0);
  EXPECT_EQ(phases.back().step, 2);
  EXPECT_THAT(phases.back().what,
              HasSubstr(std::to_string(loaded->scene->TriangleCount()) + " triangles"));
}

TEST(ViewEngine, LoadingCanBeGivenUpInEveryPhase) {
  for (int last = 1; last <= 3; ++last) {
    int told = 0;
    const Result<LoadedScene> loaded = LoadForView({"builtin:lights", ""}, SettingsOfSize(96, 64),
                                                   [&](const LoadPhase&) { return ++told < last; });
    EXPECT_EQ(loaded.status().code(), StatusCode::kCancelled);
    EXPECT_EQ(told, last);
  }
}

/// A large scene that is being read does not keep the window from closing.
TEST(ViewEngine, EndsAtOnceWhileALargeSceneLoads) {
  const char* data = std::getenv("STILLRAY_TEST_DATA");
  const std::string kitchen =
      std::string(data != nullptr ? data : STILLRAY_TEST_DATA_FOLDER) + "/scenes/kitchen.glb";
  if (!std::filesystem::exists(kitchen)) {
    GTEST_SKIP() << kitchen << " is not there";
  }
  for (const int delay_ms : {20, 150, 400}) {
    auto engine = std::make_unique<ViewEngine>(SettingsOfSize(96, 64), [] {});
    engine->Open({kitchen, ""});
    std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
    EXPECT_TRUE(engine->load_state().loading) << "at " << delay_ms << " ms";
    EXPECT_FALSE(engine->load_state().phase.what.empty());
    const Clock::time_point start = Clock::now();
    engine.reset();
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 0.1);
    EXPECT_LE(SceneLoader::abandoned(), 1);  // none if it has noticed already
    SceneLoader::WaitForAbandoned();
    EXPECT_EQ(SceneLoader::abandoned(), 0);
  }
}

TEST(ViewEngine, WritesFilesBetweenFrames) {
  const Folder folder;
  ViewEngine engine(SettingsOfSize(96, 64), [] {});
  engine.Open({"builtin:cornell", ""});
  bool is_error = true;
  engine.SaveFile("settings", [] { return Status::Ok(); });
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("saved settings"));
  EXPECT_FALSE(is_error);
  engine.SaveFile("settings", [] { return Status::Io("the disk is full"); });
  EXPECT_THAT(OneMessage(&engine, &is_error), HasSubstr("the disk is full"));
  EXPECT_TRUE(is_error);
}

TEST(ViewEngine, EndsAtOnceWhateverItDoes) {
  for (int delay_ms : {0, 1, 5, 30}) {
    ViewSettings settings = SettingsOfSize(96, 64);
    settings.width = 640;
    settings.height = 480;
    settings.rate = {64, 1};
    const Clock::time_point start = [&] {
      ViewEngine engine(settings, [] {});
      engine.Open({"builtin:spheres", ""});
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      return Clock::now();
    }();
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 0.5);
    SceneLoader::WaitForAbandoned();
  }
}

}  // namespace
}  // namespace stillray::view::view_engine_test
