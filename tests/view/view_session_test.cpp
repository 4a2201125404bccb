// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_session.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/device_denoiser.h"
#include "stillray/quality.h"

namespace stillray::view {
namespace {

using ::testing::HasSubstr;

constexpr uint8_t kGrey = 77;
const RenderProgress kGoOn = [](double) { return true; };

ViewSettings SmallSettings() {
  ViewSettings settings;
  settings.width = 96;
  settings.height = 64;
  settings.scale = 1;
  settings.auto_scale = false;
  settings.rate = {1, 1};
  settings.auto_rate = false;
  settings.wall_clock = false;
  settings.panes = {"denoised", "noisy"};
  return settings;
}

ViewSession Open(const std::string& scene, const Device& device = Device()) {
  const auto quiet = [](const LoadPhase&) { return true; };
  return ViewSession(std::move(LoadForView({scene, ""}, SmallSettings(), quiet, device).value()),
                     device);
}

ViewFrame Next(const ViewSettings& settings, ViewSession* session) {
  ViewFrame frame;
  const Status status = session->RenderNext(settings, 0.04, kGoOn, &frame);
  EXPECT_TRUE(status.ok()) << status.message();
  return frame;
}

double MeanDifference(const Rgb8Image& a, const Rgb8Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    sum += std::abs(int{a.pixels[i]} - int{b.pixels[i]});
  }
  return sum / static_cast<double>(a.pixels.size());
}

TEST(ViewSession, AStillViewGetsBetter) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  EXPECT_EQ(first.number, 1u);
  EXPECT_EQ(first.pictures.size(), 2u);
  EXPECT_FALSE(first.still);
  const Image3 early = *session.Denoised().value();
  for (int i = 0; i < 30; ++i) {
    Next(settings, &session);
  }
  const Image3 late = *session.Denoised().value();
  settings.reference = true;
  Next(settings, &session);
  for (int i = 0; i < 128; ++i) {
    ASSERT_TRUE(session.RefineReference(kGoOn).ok());
  }
  EXPECT_EQ(session.reference().spp(), 128);
  const Image3& reference = *session.reference().picture();
  const double before = CompareImages(early, reference, false).value().flip;
  const double after = CompareImages(late, reference, false).value().flip;
  EXPECT_LT(after, 0.8 * before);
  EXPECT_LT(CompareImages(early, reference, false).value().flip,
            CompareImages(session.noisy(), reference, false).value().flip);
}

TEST(ViewSession, ReferencePassesAreIndependentOfEachOther) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.reference = true;
  Next(settings, &session);
  Next(settings, &session);
  std::vector<double> errors;
  Image3 few;
  for (int i = 0; i < 256; ++i) {
    ASSERT_TRUE(session.RefineReference(kGoOn).ok());
    if (i == 15) {
      few = *session.reference().picture();
    }
  }
  const Image3& many = *session.reference().picture();
  // 16 samples against 256: had every pass the same random numbers, both would be equal.
  EXPECT_GT(CompareImages(few, many, false).value().rel_mse, 1e-3);
}

TEST(ViewSession, TheSameCallsGiveTheSameBits) {
  std::vector<uint8_t> pixels[2];
  for (std::vector<uint8_t>& run : pixels) {
    ViewSession session = Open("builtin:lights");
    ViewSettings settings = SmallSettings();
    settings.playing = true;
    settings.rate = {1, 4};
    ViewFrame frame;
    for (int i = 0; i < 6; ++i) {
      frame = Next(settings, &session);
      settings.rate = i == 2 ? SampleRate{1, 2} : settings.rate;
    }
    run = frame.pictures[0].pixels;
  }
  EXPECT_EQ(pixels[0], pixels[1]);
}

TEST(ViewSession, FewerSamplesThanPixelsFillInOverACycle) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.rate = {1, 8};
  settings.panes = {"samples"};
  Image1 sum(96, 64);
  for (int n = 0; n < 8; ++n) {
    Next(settings, &session);
    const std::vector<Image1> samples = session.Values("samples").value();
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        sum(x, y) += samples[0](x, y);
      }
    }
  }
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      ASSERT_EQ(sum(x, y), 1) << x << " " << y;
    }
  }
}

TEST(ViewSession, AMovedCameraSeesSomethingElse) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame before = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = Orbit(before.pose, 0.4f, 0.1f);
  const ViewFrame after = Next(settings, &session);
  EXPECT_FALSE(after.still);
  EXPECT_EQ(after.pose, settings.pose);
  EXPECT_GT(MeanDifference(before.pictures[0], after.pictures[0]), 5);
  // Motion vectors tell of the way of the camera.
  const std::vector<Image1> motion = session.Values("motion").value();
  EXPECT_GT(std::abs(motion[0](48, 32)), 1);
}

TEST(ViewSession, TheFreeCameraAtTheFilesPlaceSeesTheSame) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame file = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = file.pose;
  const ViewFrame free = Next(settings, &session);
  EXPECT_TRUE(free.still);
}

TEST(ViewSession, TimePassesSeeksAndWraps) {
  ViewSession session = Open("builtin:lights");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  EXPECT_GT(first.length, 0);
  EXPECT_EQ(first.seconds, 0);
  settings.playing = true;
  settings.fps = 10;
  settings.speed = 2;
  EXPECT_NEAR(Next(settings, &session).seconds, 0.2, 1e-9);
  settings.seek = 1;
  settings.seek_seconds = first.length - 0.1;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
  EXPECT_NEAR(Next(settings, &session).seconds, 0.1, 1e-9);
  settings.speed = -2;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
  settings.playing = false;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
}

TEST(ViewSession, LightsMoveAtASpeedOfTheirOwn) {
  ViewSession session = Open("builtin:lights");
  EXPECT_TRUE(session.has_moving_lights());
  ViewSettings settings = SmallSettings();
  settings.width = 48;
  settings.height = 32;
  settings.playing = true;
  settings.fps = 10;
  settings.speed = 0;
  settings.light_speed = 2;
  const ViewFrame first = Next(settings, &session);
  const ViewFrame second = Next(settings, &session);
  EXPECT_EQ(second.seconds, 0);
  EXPECT_NEAR(second.light_seconds, 0.2, 1e-9);
  EXPECT_FALSE(second.still);
  EXPECT_EQ(second.pose, first.pose) << "the file's camera belongs to the rest";
  settings.speed = 1;
  settings.light_speed.reset();
  settings.seek = 1;
  settings.seek_seconds = 1;
  const ViewFrame both = Next(settings, &session);
  EXPECT_EQ(both.seconds, 1);
  EXPECT_EQ(both.light_seconds, 1);
}

/// What moves with which clock, seen from one place: surfaces by their depth, light by the picture.
TEST(ViewSession, EachClockMovesItsOwn) {
  struct Seen {
    Image1 depth;
    Image3 light;
  };
  const auto after_a_second = [](double speed, double light_speed) {
    ViewSession session = Open("builtin:lights");
    ViewSettings settings = SmallSettings();
    settings.denoise.temporal = false;
    settings.denoise.antialias = Antialias::kOff;
    settings.rate = {4, 1};
    settings.pose = Next(settings, &session).pose;
    settings.free_camera = true;
    settings.playing = true;
    settings.fps = 1;
    settings.speed = speed;
    settings.light_speed = light_speed;
    Next(settings, &session);
    return Seen{session.Values("depth").value()[0], session.noisy()};
  };
  const auto moved_pixels = [](const Image1& a, const Image1& b) {
    int count = 0;
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        count += std::abs(a(x, y) - b(x, y)) > 0.01f * b(x, y) ? 1 : 0;
      }
    }
    return count;
  };
  const auto unlike = [](const Image3& a, const Image3& b) {
    return CompareImages(a, b, false).value().rel_mse;
  };
  const Seen still = after_a_second(0, 0);
  const Seen lights = after_a_second(0, 1);
  const Seen objects = after_a_second(1, 0);
  const Seen both = after_a_second(1, 1);
  // The same random numbers: pictures differ by what has moved, and by that alone.
  EXPECT_GT(unlike(lights.light, still.light), 1e-3);
  EXPECT_GT(unlike(both.light, objects.light), 1e-3);
  EXPECT_GT(moved_pixels(objects.depth, still.depth), 60);
  EXPECT_LT(moved_pixels(lights.depth, still.depth), moved_pixels(objects.depth, still.depth) / 4);
  EXPECT_LT(moved_pixels(both.depth, objects.depth), moved_pixels(both.depth, still.depth) / 4);
}

TEST(ViewSession, FilledGuidesHaveNoHoles) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.rate = {1, 16};
  settings.sparse_guides = true;
  settings.panes = {"filled.depth", "filled.normal", "depth"};
  for (int n = 0; n < 20; ++n) {
    Next(settings, &session);
    const Image1 filled = session.Values("filled.depth").value()[0];
    const Image1 raw = session.Values("depth").value()[0];
    int holes = 0;
    for (int y = 0; y < raw.height(); ++y) {
      for (int x = 0; x < raw.width(); ++x) {
        holes += raw(x, y) == 0 ? 1 : 0;
        ASSERT_GT(filled(x, y), 0) << x << " " << y << " in frame " << n;
        ASSERT_TRUE(raw(x, y) == 0 || raw(x, y) == filled(x, y)) << "what is known stays";
      }
    }
    EXPECT_GT(holes, raw.width() * raw.height() * 3 / 4);
  }
  // With guides everywhere both are the same.
  settings.sparse_guides = false;
  Next(settings, &session);
  EXPECT_EQ(session.Values("filled.depth").value()[0](10, 10),
            session.Values("depth").value()[0](10, 10));
}

TEST(ViewSession, ChoosingWhatToOrbitAroundMovesNothing) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = OrbitAround(first.pose, 0.2f, 0.3f, 1.5f, 2.0f);
  EXPECT_TRUE(Next(settings, &session).still);
}

TEST(ViewSession, ResizingGoesOnAtTheNewSize) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  Next(settings, &session);
  settings.width = 50;
  settings.height = 31;
  const ViewFrame frame = Next(settings, &session);
  EXPECT_EQ(frame.width, 50);
  EXPECT_EQ(frame.height, 31);
  EXPECT_EQ(frame.pictures[1].pixels.size(), 50u * 31 * 3);
  settings.width = 1;
  settings.height = 1;
  EXPECT_EQ(Next(settings, &session).width, 16);
}

TEST(ViewSession, EveryPresetAndGroupingWorksInAnyOrder) {
  ViewSession session = Open("builtin:spheres");
  ViewSettings settings = SmallSettings();
  settings.inspect = true;
  for (const std::string_view preset : PresetNames()) {
    for (const char* signals : {"split", "single", "direct_indirect"}) {
      settings.denoise = PresetSettings(preset).value();
      ASSERT_TRUE(SetParameter(&settings.denoise, "signals", signals).ok());
      settings.panes = {"denoised", "variance.direct"};
      const ViewFrame frame = Next(settings, &session);
      EXPECT_GT(frame.inspected.size(), 10u) << preset << " " << signals;
    }
  }
}

TEST(ViewSession, ContradictingSettingsAreNamedAndChangeNothing) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  Next(settings, &session);
  settings.denoise.feedback = 7;
  ViewFrame frame;
  const Status status = session.RenderNext(settings, 0, kGoOn, &frame);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("feedback"));
  EXPECT_EQ(Next(SmallSettings(), &session).number, 2u);
}

TEST(ViewSession, AFrameGivenUpLeavesTheHistoryAlone) {
  ViewSession session = Open("builtin:cornell");
  const ViewSettings settings = SmallSettings();
  Next(settings, &session);
  ViewFrame frame;
  const Status status = session.RenderNext(
      settings, 0, [](double) { return false; }, &frame);
  EXPECT_EQ(status.code(), StatusCode::kCancelled);
  const ViewFrame next = Next(settings, &session);
  EXPECT_EQ(next.number, 2u);
  EXPECT_TRUE(next.still);
}

TEST(ViewSession, TellsTheDepthUnderAClick) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.focus = 3;
  settings.focus_x = 0.5f;
  settings.focus_y = 0.5f;
  const ViewFrame frame = Next(settings, &session);
  EXPECT_EQ(frame.focus, 3u);
  EXPECT_FLOAT_EQ(frame.focus_depth, session.Values("depth").value()[0](48, 32));
}

TEST(ViewSession, AdaptsItsRateToTheTarget) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.auto_rate = true;
  settings.rate = {1, 16};
  settings.target_ms = 4000;  // far more than these frames need
  ViewFrame frame;
  for (int i = 0; i < 12; ++i) {
    frame = Next(settings, &session);
  }
  EXPECT_GE(frame.rate.value(), 4.0 / 16);
}

/// A device that works for some frames and is lost then; its pictures are plain green, as displayed
/// plain grey.
class MortalDevice : public DeviceBackend {
 public:
  explicit MortalDevice(int frames) : frames_(frames) {}
  /// What the last frame was asked for, and how often its colour was fetched later.
  const Results& results() const { return results_; }
  int reads() const { return reads_; }
  Result<std::unique_ptr<DeviceDenoiser>> CreateDenoiser(const Settings&,
                                                         DevicePrecision) override {
    if (frames_ == 0) {
      return Status::Unsupported("the device was lost");
    }
    return std::unique_ptr<DeviceDenoiser>(std::make_unique<Mortal>(this));
  }

 private:
  class Mortal : public DeviceDenoiser {
   public:
    explicit Mortal(MortalDevice* device) : device_(device) {}
    Status Denoise(const Frame& frame, std::span<const SignalHistory>,
                   DenoisedFrame* out) override {
      if (device_->frames_-- == 0) {
        return Status::Unsupported("the device was lost");
      }
      colour_ = Image3(frame.width, frame.height);
      colour_[1].Fill(1);
      out->colour = device_->results_.colour ? colour_ : Image3();
      const size_t bytes = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height) * 3;
      out->display.assign(device_->results_.display ? bytes : 0, kGrey);
      return Status::Ok();
    }
    void SetResults(const Results& wanted) override { device_->results_ = wanted; }
    Status ReadColour(Image3* colour) override {
      ++device_->reads_;
      *colour = colour_;
      return Status::Ok();
    }
    Status SetSettings(const Settings&) override { return Status::Ok(); }
    void SetOutputs(std::vector<std::string>) override {}
    void Reset() override {}
    size_t memory_bytes() const override { return 0; }
    DeviceMemory device_memory() const override { return {}; }
    Status Accumulate(const Frame&, std::vector<SignalHistory>*) override {
      return Status::Unsupported("the device was lost");
    }
    Result<std::vector<uint8_t>> SaveHistory() override { return std::vector<uint8_t>(); }
    Status RestoreHistory(std::span<const uint8_t>) override { return Status::Ok(); }

   private:
    MortalDevice* device_;
    Image3 colour_;
  };
  int frames_;
  Results results_;
  int reads_ = 0;
};

TEST(ViewSession, GoesOnOnTheCpuWhenItsDeviceIsLost) {
  for (const int frames : {0, 2}) {
    const Device device = MakeDevice(std::make_shared<MortalDevice>(frames), "a device");
    ViewSession session = Open("builtin:cornell", device);
    ViewSession expected = Open("builtin:cornell");
    for (int i = 0; i < frames; ++i) {
      Next(SmallSettings(), &expected);
      const ViewFrame frame = Next(SmallSettings(), &session);
      EXPECT_EQ(frame.device, "a device");
      EXPECT_EQ(frame.note, "");
      EXPECT_EQ(frame.pictures[0].pixels[0], kGrey);
    }
    const ViewFrame lost = Next(SmallSettings(), &session);
    EXPECT_EQ(lost.device, "cpu");
    EXPECT_EQ(lost.note, "filtering goes on on the CPU: the device was lost");
    EXPECT_LT(MeanDifference(lost.pictures[0], Next(SmallSettings(), &expected).pictures[0]), 15);
    EXPECT_EQ(Next(SmallSettings(), &session).note, "");
    EXPECT_TRUE(session.device().is_cpu());
  }
}

// The picture comes as bytes; in full precision, the larger copy, only where its numbers are
// needed.
TEST(ViewSession, CopiesOnlyWhatIsLookedAt) {
  const auto backend = std::make_shared<MortalDevice>(100);
  ViewSession session = Open("builtin:cornell", MakeDevice(backend, "a device"));
  const auto copied = [&](const ViewSettings& settings) {
    const ViewFrame frame = Next(settings, &session);
    EXPECT_TRUE(frame.panes[0] != "denoised" || frame.pictures[0].pixels[0] == kGrey);
    return std::make_pair(backend->results().colour, backend->results().display);
  };
  using Copied = std::pair<bool, bool>;
  ViewSettings settings = SmallSettings();
  EXPECT_EQ(copied(settings), Copied(false, true));
  EXPECT_EQ(backend->reads(), 0);
  EXPECT_EQ(session.Values("denoised").value()[1](3, 3), 1) << "for files, whenever it is wanted";
  EXPECT_EQ(backend->reads(), 1);
  settings.panes = {"normal"};
  EXPECT_EQ(copied(settings), Copied(false, false));
  settings.panes = {"motion_arrows", "noisy"};
  EXPECT_EQ(copied(settings), Copied(false, true));
  settings.panes = {"no_such_view"};
  EXPECT_EQ(copied(settings), Copied(false, true)) << "the picture stands in for it";
  settings.panes = {"denoised"};
  settings.inspect = true;
  EXPECT_EQ(copied(settings), Copied(true, true));
  settings.inspect = false;
  settings.reference = true;
  EXPECT_EQ(copied(settings), Copied(true, true));
  EXPECT_EQ(backend->reads(), 1);
  settings.reference = false;
  EXPECT_EQ(copied(settings), Copied(false, true));
}

/// The most that two pictures differ by, in steps of 255.
int MostDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  int most = a.size() == b.size() ? 0 : 255;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, std::abs(int{a[i]} - int{b[i]}));
  }
  return most;
}

TEST(ViewSession, ShowsTheColourAsDisplayed) {
  std::vector<std::pair<Device, int>> devices = {{Device(), 0}};  // and what may differ, in steps
  if (const Result<Device> device = Device::Open("vulkan"); device.ok()) {
    devices.emplace_back(*device, 1);
  }
  for (const auto& [device, tolerance] : devices) {
    ViewSession session = Open("builtin:cornell", device);
    ViewSettings settings = SmallSettings();
    settings.width = 64;
    settings.height = 40;
    settings.bounces = 1;
    settings.panes = {"denoised"};
    settings.denoise.exposure = 0.7f;
    settings.denoise.tonemap = Tonemap::kFilmic;
    settings.denoise.dither = 1;
    for (int64_t i = 0; i < 3; ++i) {
      const ViewFrame frame = Next(settings, &session);
      EXPECT_EQ(frame.device, device.description());
      const Image3& colour = *session.Denoised().value();
      EXPECT_LE(
          MostDifference(frame.pictures[0].pixels, ToDisplay(colour, 0.7f, Tonemap::kFilmic, 1, i)),
          tolerance)
          << device.description() << ", frame " << i;
    }
  }
}

TEST(ViewSession, FramesStayOnTheDeviceUntilSomebodyLooks) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  ViewSession session = Open("builtin:cornell", *device);
  ViewSettings settings = SmallSettings();
  settings.panes = {"denoised"};
  ViewFrame frame = Next(settings, &session);
  EXPECT_TRUE(session.noisy().empty());
  EXPECT_GT(frame.memory.frame, 96u * 64 * 160);  // on the device
  // A click is answered, and the answer stays.
  settings.focus = 1;
  settings.focus_x = settings.focus_y = 0.5f;
  const float depth = Next(settings, &session).focus_depth;
  EXPECT_FALSE(session.noisy().empty());
  EXPECT_GT(depth, 0);
  EXPECT_EQ(depth, session.Values("depth").value()[0](48, 32));
  frame = Next(settings, &session);
  EXPECT_TRUE(session.noisy().empty());
  EXPECT_EQ(frame.focus_depth, depth);
  // So is who saves what was not shown.
  EXPECT_EQ(session.Values("normal").value().size(), 3u);
  for (const char* view : {"noisy", "depth", "emission", "direct_diffuse", "samples"}) {
    settings.panes = {"denoised", view};
    EXPECT_EQ(Next(settings, &session).pictures.size(), 2u);
    EXPECT_FALSE(session.noisy().empty()) << view;
  }
  settings.panes = {"denoised", "temporal"};
  Next(settings, &session);
  EXPECT_TRUE(session.noisy().empty());
  settings.inspect = true;
  frame = Next(settings, &session);
  EXPECT_TRUE(std::any_of(frame.inspected.begin(), frame.inspected.end(),
                          [](const InspectedValue& value) { return value.view == "depth"; }));
}

TEST(ViewSession, SharesThePictureWhereTheDeviceDoes) {
  const auto opened = [](const Device& device) {
    ViewSettings settings = SmallSettings();
    settings.width = 64;
    settings.height = 40;
    settings.bounces = 1;
    settings.shares_pictures = true;
    settings.panes = {"denoised", "normal"};
    return std::make_pair(Open("builtin:cornell", device), settings);
  };
  auto [cpu, settings] = opened(Device());
  const ViewFrame copied = Next(settings, &cpu);
  EXPECT_EQ(copied.shared[0], nullptr);
  EXPECT_EQ(cpu.FinishedPicture().value().pixels, copied.pictures[0].pixels);
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  ViewSession session = std::move(opened(*device).first);
  ViewFrame frame = Next(settings, &session);
  if (frame.shared[0] == nullptr) {
    GTEST_SKIP() << "the device shares no memory";
  }
  EXPECT_EQ(frame.shared[0]->width(), 64);
  EXPECT_EQ(frame.pictures[0].width, 64);
  EXPECT_TRUE(frame.pictures[0].pixels.empty());
  EXPECT_EQ(frame.shared[1], nullptr);
  EXPECT_FALSE(frame.pictures[1].pixels.empty());
  const Rgb8Image late = session.FinishedPicture().value();
  EXPECT_LT(MeanDifference(late, copied.pictures[0]), 2) << "for files, whenever it is wanted";
  settings.shares_pictures = false;
  frame = Next(settings, &session);
  EXPECT_EQ(frame.shared[0], nullptr);
  EXPECT_FALSE(frame.pictures[0].pixels.empty());
}

// Fewer samples than pixels, a smaller picture, another time of the animation, a camera that is
// moved: the device shows what the CPU shows.
TEST(ViewSession, ADeviceTracesWhatTheCpuTraces) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  ViewSession sessions[] = {Open("builtin:lights", *device), Open("builtin:lights")};
  ViewSettings settings = SmallSettings();
  settings.width = 64;
  settings.height = 40;
  settings.bounces = 1;
  settings.playing = true;
  settings.panes = {"noisy", "denoised", "motion"};
  ViewFrame frames[2];
  const auto compare = [&](const char* what) {
    for (size_t i = 0; i < 2; ++i) {
      frames[i] = Next(settings, &sessions[i]);
    }
    EXPECT_EQ(frames[0].tracer, device->description()) << what;
    EXPECT_EQ(frames[1].tracer, "cpu") << what;
    EXPECT_EQ(frames[0].note, "") << what;
    ASSERT_EQ(frames[0].width, frames[1].width) << what;
    for (size_t pane = 0; pane < 3; ++pane) {
      // Where a rounding decides a path takes another way: some pixels of the noisy picture.
      EXPECT_LT(MeanDifference(frames[0].pictures[pane], frames[1].pictures[pane]), 1.5)
          << what << ", " << settings.panes[pane];
    }
  };
  compare("moving");
  settings.rate = {1, 8};
  compare("1/8");
  settings.sparse_guides = true;
  compare("sparse");
  settings.width = 52;
  settings.height = 30;
  compare("smaller");
  settings.playing = false;
  settings.free_camera = true;
  settings.pose = Orbit(frames[0].pose, 0.1f, 0);
  compare("orbit");
  settings.reference = true;
  for (ViewSession& session : sessions) {
    Next(settings, &session);
    ASSERT_TRUE(session.RefineReference(kGoOn).ok());
    ASSERT_EQ(session.reference().spp(), 1);
  }
  const ImageMetrics metrics =
      CompareImages(*sessions[0].reference().picture(), *sessions[1].reference().picture(), false)
          .value();
  EXPECT_GT(metrics.psnr, 25);
}

TEST(LoadForView, NamesWhatIsWrong) {
  const auto quiet = [](const LoadPhase&) { return true; };
  EXPECT_EQ(LoadForView({"no/such.glb", ""}, SmallSettings(), quiet).status().code(),
            StatusCode::kNotFound);
  const Result<LoadedScene> bad =
      LoadForView({"builtin:cornell", "no/such.hdr"}, SmallSettings(), quiet);
  ASSERT_FALSE(bad.ok());
  EXPECT_THAT(bad.status().message(), HasSubstr("environment"));
  EXPECT_THAT(bad.status().message(), HasSubstr("no/such.hdr"));
}

}  // namespace
}  // namespace stillray::view
