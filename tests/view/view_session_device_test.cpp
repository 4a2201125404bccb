// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sessions of the viewer whose frames are filtered and traced on a device.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "denoise/backend.h"
#include "stillray/quality.h"
#include "view/small_session.h"
#include "view/view_session.h"

namespace stillray::view::view_session_device_test {
namespace {

constexpr uint8_t kGrey = 77;

/// A device that works for some frames and is lost then; its pictures are plain green, as displayed
/// plain grey.
class MortalDevice : public DeviceBackend {
 public:
  explicit MortalDevice(int frames) : frames_(frames) {}
  /// The results requested for the last frame, and how often its colour was fetched later.
  const Results& results() const { return results_; }
  int reads() const { return reads_; }
  Result<std::unique_ptr<DenoiserBackend>> CreateDenoiser(const Settings&,
                                                          DevicePrecision) override {
    if (frames_ == 0) {
      return Status::Unsupported("the device was lost");
    }
    return std::unique_ptr<DenoiserBackend>(std::make_unique<Mortal>(this));
  }

 private:
  class Mortal : public DenoiserBackend {
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

/// MortalDevice counts pictures: layers of reflected light would be more than one in a frame.
ViewSettings OneLayer() {
  ViewSettings settings = SmallSettings();
  settings.render.virtual_guides = false;
  return settings;
}

TEST(ViewSessionOnDevice, GoesOnOnTheCpuWhenItsDeviceIsLost) {
  for (const int frames : {0, 2}) {
    const Device device = MakeDevice(std::make_shared<MortalDevice>(frames), "a device");
    ViewSession session = Open("builtin:cornell", device);
    ViewSession expected = Open("builtin:cornell");
    for (int i = 0; i < frames; ++i) {
      Next(OneLayer(), &expected);
      const ViewFrame frame = Next(OneLayer(), &session);
      EXPECT_EQ(frame.device, "a device");
      EXPECT_EQ(frame.note, "");
      EXPECT_EQ(frame.pictures[0].pixels[0], kGrey);
    }
    const ViewFrame lost = Next(OneLayer(), &session);
    EXPECT_EQ(lost.device, "cpu");
    EXPECT_EQ(lost.note, "filtering goes on on the CPU: the device was lost");
    EXPECT_LT(MeanDifference(lost.pictures[0], Next(OneLayer(), &expected).pictures[0]), 15);
    EXPECT_EQ(Next(OneLayer(), &session).note, "");
    EXPECT_TRUE(session.devices().filter.is_cpu());
  }
}

// The picture comes as bytes; in full precision, the larger copy, only where its numbers are
// needed.
TEST(ViewSessionOnDevice, CopiesOnlyWhatIsLookedAt) {
  const auto backend = std::make_shared<MortalDevice>(100);
  ViewSession session = Open("builtin:cornell", MakeDevice(backend, "a device"));
  const auto copied = [&](const ViewSettings& settings) {
    const ViewFrame frame = Next(settings, &session);
    EXPECT_TRUE(frame.panes[0] != "denoised" || frame.pictures[0].pixels[0] == kGrey);
    return std::make_pair(backend->results().colour, backend->results().display);
  };
  using Copied = std::pair<bool, bool>;
  ViewSettings settings = OneLayer();
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

/// A session whose frames are traced on the CPU and filtered on another device, by turns or at the
/// same time.
ViewSession OpenBeside(const Device& device, bool overlapped) {
  const auto quiet = [](const LoadPhase&) { return true; };
  LoadedScene loaded =
      std::move(LoadForView({"builtin:lights", ""}, SmallSettings(), quiet).value());
  return ViewSession(std::move(loaded),
                     overlapped ? RenderDevices(device, Device()) : RenderDevices(device));
}

ViewSettings SmallAndMoving() {
  ViewSettings settings = OneLayer();
  settings.width = 64;
  settings.height = 40;
  settings.render.bounces = 1;
  settings.playing = true;
  settings.panes = {"noisy", "denoised"};
  return settings;
}

// Frames that are traced while the last one is filtered are those that would be traced then,
// whatever changes between them.
TEST(ViewSessionOnDevice, FramesTracedAheadAreThoseOfTheirTurn) {
  const Device device = MakeDevice(std::make_shared<MortalDevice>(100), "a device");
  ViewSession ahead = OpenBeside(device, true);
  ViewSession in_turn = OpenBeside(device, false);
  ViewSettings settings = SmallAndMoving();
  int overlapped = 0;
  const auto compare = [&](const char* what, int frames) {
    for (int i = 0; i < frames; ++i) {
      const ViewFrame a = Next(settings, &ahead);
      const ViewFrame b = Next(settings, &in_turn);
      EXPECT_EQ(a.pictures[0].pixels, b.pictures[0].pixels) << what << ", frame " << i;
      EXPECT_EQ(a.seconds, b.seconds) << what;
      EXPECT_EQ(a.samples, b.samples) << what;
      EXPECT_EQ(a.rate, b.rate) << what;
      EXPECT_EQ(a.device, "a device") << what;
      EXPECT_EQ(a.tracer, "cpu") << what;
      EXPECT_FALSE(b.cost.overlapped) << what;
      overlapped += a.cost.overlapped ? 1 : 0;
      EXPECT_EQ(a.memory.scene, b.memory.scene) << what;
    }
  };
  compare("moving", 3);
  EXPECT_EQ(overlapped, 2) << "all but the first";
  settings.rate = {1, 4};
  compare("another rate", 2);
  settings.rate = {2, 1};
  compare("a higher rate", 2);
  settings.width = 52;
  compare("another size", 2);
  settings.free_camera = true;
  settings.pose = Orbit(Next(settings, &in_turn).pose, 0.1f, 0);
  Next(settings, &ahead);
  compare("a free camera", 2);
  settings.denoise.signals = SignalGrouping::kSingle;
  compare("another filter", 2);
  settings.restart = 1;
  compare("begun again", 2);
  settings.playing = false;
  settings.seek = 1;
  settings.seek_seconds = 0.5;
  compare("another moment", 7);  // it stands still and refines
  EXPECT_GT(overlapped, 12);
  settings.reference = true;
  settings.panes = {"noisy", "denoised", "reference"};
  compare("with a reference", 2);
  for (ViewSession* session : {&ahead, &in_turn}) {
    ASSERT_TRUE(session->RefineReference(kGoOn).ok());
  }
  compare("after a sample of the reference", 1);
}

TEST(ViewSessionOnDevice, ACameraThatMovesIsShownOneFrameLate) {
  const Device device = MakeDevice(std::make_shared<MortalDevice>(100), "a device");
  ViewSession session = OpenBeside(device, true);
  ViewSettings settings = SmallAndMoving();
  settings.pose = Next(settings, &session).pose;
  settings.free_camera = true;
  EXPECT_EQ(Next(settings, &session).pose, settings.pose) << "as asked for: all is new";
  const ViewPose first = settings.pose;
  settings.pose = Orbit(first, 0.1f, 0);
  ++settings.revision;
  EXPECT_EQ(Next(settings, &session).pose, first);
  EXPECT_EQ(Next(settings, &session).pose, settings.pose);
}

// In real time a frame ahead is traced for an estimate of its moment: what it misses the next ones
// make up for.
TEST(ViewSessionOnDevice, TimePassesAsFastAsTheClockWhenFramesAreTracedAhead) {
  const Device device = MakeDevice(std::make_shared<MortalDevice>(100), "a device");
  ViewSession session = OpenBeside(device, true);
  ViewSettings settings = SmallAndMoving();
  settings.wall_clock = true;
  settings.width = settings.height = 16;
  ViewFrame frame = Next(settings, &session);
  double passed = 0;
  for (const double elapsed : {0.02, 0.05, 0.01, 0.12, 0.03, 0.04, 0.04, 0.04}) {
    ASSERT_TRUE(session.RenderNext(settings, elapsed, kGoOn, &frame).ok());
    passed += elapsed;
  }
  EXPECT_NEAR(frame.seconds, passed, 1e-9);
}

TEST(ViewSessionOnDevice, AFrameAheadThatIsGivenUpIsTracedAgain) {
  const Device device = MakeDevice(std::make_shared<MortalDevice>(100), "a device");
  ViewSession ahead = OpenBeside(device, true);
  ViewSession in_turn = OpenBeside(device, false);
  const ViewSettings settings = SmallAndMoving();
  Next(settings, &ahead);
  ViewFrame frame;
  const Status status = ahead.RenderNext(
      settings, 0.04, [](double) { return false; }, &frame);
  // It may have been finished already.
  EXPECT_TRUE(status.ok() || status.code() == StatusCode::kCancelled) << status.message();
  for (int i = status.ok() ? 0 : 1; i < 2; ++i) {
    Next(settings, &in_turn);
  }
  for (int i = 0; i < 2; ++i) {
    const ViewFrame a = Next(settings, &ahead);
    EXPECT_EQ(a.pictures[0].pixels, Next(settings, &in_turn).pictures[0].pixels) << i;
  }
  // A session may be moved, and end, while it traces.
  const ViewSession moved = std::move(ahead);
}

TEST(ViewSessionOnDevice, TracingAheadEndsWithTheDeviceOfTheFilter) {
  const Device device = MakeDevice(std::make_shared<MortalDevice>(2), "a device");
  ViewSession ahead = OpenBeside(device, true);
  ViewSession on_cpu = OpenBeside(Device(), false);
  const ViewSettings settings = SmallAndMoving();
  for (int i = 0; i < 5; ++i) {
    const ViewFrame a = Next(settings, &ahead);
    const ViewFrame b = Next(settings, &on_cpu);
    EXPECT_EQ(a.pictures[0].pixels, b.pictures[0].pixels) << i;
    EXPECT_EQ(a.note.empty(), i != 2) << a.note;
    // The frame that was traced when the device was lost is used.
    EXPECT_EQ(a.cost.overlapped, i > 0 && i < 4) << i;
    EXPECT_EQ(a.device, i < 2 ? "a device" : "cpu") << i;
  }
}

/// The most that two pictures differ by, in steps of 255.
int MostDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  int most = a.size() == b.size() ? 0 : 255;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, std::abs(int{a[i]} - int{b[i]}));
  }
  return most;
}

TEST(ViewSessionOnDevice, ShowsTheColourAsDisplayed) {
  std::vector<std::pair<Device, int>> devices = {{Device(), 0}};  // and what may differ, in steps
  if (const Result<Device> device = Device::Open("vulkan"); device.ok()) {
    devices.emplace_back(*device, 1);
  }
  for (const auto& [device, tolerance] : devices) {
    ViewSession session = Open("builtin:cornell", device);
    ViewSettings settings = SmallSettings();
    settings.width = 64;
    settings.height = 40;
    settings.render.bounces = 1;
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

TEST(ViewSessionOnDevice, FramesStayOnTheDeviceUntilSomebodyLooks) {
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
  // The same for saving a view that was not shown.
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

// What mirrors show is filtered with its own guides, without the frame's planes on the host.
TEST(ViewSessionOnDevice, MirrorsAreFilteredAsOnTheCpu) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  const auto picture = [](const Device& on, bool virtual_guides) {
    ViewSession session = Open("builtin:mirrors", on);
    ViewSettings settings = SmallSettings();
    settings.panes = {"denoised"};
    settings.render.virtual_guides = virtual_guides;
    ViewFrame frame;
    for (int i = 0; i < 4; ++i) {
      frame = Next(settings, &session);
    }
    EXPECT_EQ(session.noisy().empty(), !on.is_cpu());
    return std::move(frame.pictures[0]);
  };
  const Rgb8Image expected = picture(Device(), true);
  const double with = MeanDifference(picture(*device, true), expected);
  const double without = MeanDifference(picture(*device, false), expected);
  EXPECT_LT(with, 0.3 * without) << with << " " << without;
}

TEST(ViewSessionOnDevice, SharesThePictureWhereTheDeviceDoes) {
  const auto opened = [](const Device& device) {
    ViewSettings settings = SmallSettings();
    settings.width = 64;
    settings.height = 40;
    settings.render.bounces = 1;
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

// Fewer samples than pixels, a smaller picture, another time of the animation, a moved camera: the
// device shows the same as the CPU.
TEST(ViewSessionOnDevice, ADeviceTracesWhatTheCpuTraces) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  ViewSession sessions[] = {Open("builtin:lights", *device), Open("builtin:lights")};
  ViewSettings settings = SmallSettings();
  settings.width = 64;
  settings.height = 40;
  settings.render.bounces = 1;
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
  settings.render.guides = GuideCoverage::kSparse;
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

// The filter's history too is as if all were done in turn.
TEST(ViewSessionOnDevice, TracingOnTheCpuBesideFilteringGivesTheSamePictures) {
  const Result<Device> device = Device::Open("vulkan");
  if (!device.ok()) {
    GTEST_SKIP() << device.status().message();
  }
  ViewSession ahead = OpenBeside(*device, true);
  ViewSession in_turn = OpenBeside(*device, false);
  ViewSettings settings = SmallAndMoving();
  for (int i = 0; i < 4; ++i) {
    if (i == 2) {
      settings.rate = {1, 2};
    }
    const ViewFrame a = Next(settings, &ahead);
    const ViewFrame b = Next(settings, &in_turn);
    EXPECT_EQ(a.pictures[0].pixels, b.pictures[0].pixels) << i;
    EXPECT_EQ(a.pictures[1].pixels, b.pictures[1].pixels) << i;
    EXPECT_EQ(a.cost.overlapped, i % 2 == 1) << i;
  }
}

}  // namespace
}  // namespace stillray::view::view_session_device_test
