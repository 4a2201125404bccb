// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The history on a device: --resume of both programs, --window both and --passes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "apps/cli_denoise_shot.h"
#include "apps/program.h"
#include "stillray/denoise.hpp"

namespace stillray::cli_device_history_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class CliDeviceHistory : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string remark;
    const std::vector<DeviceDescription> devices = ListDevices(&remark);
    if (devices.empty() || !devices.front().usable.ok()) {
      GTEST_SKIP() << "there is no usable Vulkan device";
    }
  }
};

std::vector<std::string> RenderArguments(const std::string& folder) {
  return {"render", "builtin:cornell", "-o",  folder,     "--size", "40x22", "--frames",
          "1-20",   "--format",        "exr", "--device", "vulkan"};
}

ProgramRun Denoise(const std::string& in, const std::string& out,
                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"denoise",           in,         "-o",
                                        out + "/f.####.exr", "--device", "vulkan"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

void DenoiseWell(const std::string& in, const std::string& out,
                 const std::vector<std::string>& more) {
  const ProgramRun run = Denoise(in, out, more);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("denoising on vulkan:0"));
}

/// Frames of 1..last whose files differ in the two folders.
std::vector<int64_t> Differences(const std::string& a, const std::string& b,
                                 const std::string& pattern, int64_t last) {
  std::vector<int64_t> different;
  for (int64_t frame = 1; frame <= last; ++frame) {
    const std::string name = FrameFileName("/" + pattern, frame);
    EXPECT_TRUE(fs::exists(a + name)) << a + name;
    if (ReadText(a + name) != ReadText(b + name)) {
      different.push_back(frame);
    }
  }
  return different;
}

// Tracing on the CPU while the last frame is filtered on the device, as one thread does in turn;
// interrupted in between, too.
TEST_F(CliDeviceHistory, TracingBesideFilteringGivesTheSameBits) {
  const TemporaryFolder folder;
  const auto render = [&](const std::string& out, std::vector<std::string> more,
                          const char* device = "vulkan", const char* tracer = "cpu") {
    more.insert(more.begin(), {"render",
                               "builtin:lights",
                               "-o",
                               folder / out,
                               "--size",
                               "40x22",
                               "--frames",
                               "1-12",
                               "--bounces",
                               "1",
                               "--format",
                               "exr",
                               "--save-inputs",
                               "--reference",
                               "2",
                               "--reference-frames",
                               "3,12",
                               "--device",
                               device,
                               "--trace-device",
                               tracer});
    return more;
  };
  const ProgramRun beside = RunProgram(render("beside", {"--threads", "3", "--timings"}));
  ASSERT_EQ(beside.exit_code, 0) << beside.errors;
  EXPECT_THAT(beside.errors, HasSubstr("denoising on vulkan:0"));
  EXPECT_THAT(beside.errors, HasSubstr("\ntracing on the CPU, 3 threads\n"));
  EXPECT_THAT(beside.output, HasSubstr("memory, frames"));
  EXPECT_THAT(ReadText(folder / "beside/render.json"), HasSubstr("\"traces_ahead\": true"));
  EXPECT_THAT(ReadText(folder / "beside/render.json"), HasSubstr("\"tracer\": \"cpu\""));
  const ProgramRun in_turn = RunProgram(render("in_turn", {"--threads", "1"}));
  ASSERT_EQ(in_turn.exit_code, 0) << in_turn.errors;
  EXPECT_THAT(ReadText(folder / "in_turn/render.json"), HasSubstr("\"traces_ahead\": false"));
  const ProgramRun cpu = RunProgram(render("cpu", {}, "cpu"));
  ASSERT_EQ(cpu.exit_code, 0) << cpu.errors;
  EXPECT_THAT(cpu.errors, HasSubstr("rendering on the CPU"));

  const std::string part = folder / "part";
  const ProgramRun stopped =
      InterruptProgram(render("part", {"--threads", "3"}), part + "/denoised.0003.exr");
  ASSERT_EQ(stopped.exit_code, 130) << stopped.errors;
  EXPECT_FALSE(fs::exists(part + "/denoised.0012.exr")) << "it was not interrupted";
  const ProgramRun other = RunProgram(render("part", {"--resume"}, "vulkan", "vulkan"));
  EXPECT_EQ(other.exit_code, 2) << other.errors;
  EXPECT_THAT(other.errors, HasSubstr("cannot resume"));
  const ProgramRun rest = RunProgram(render("part", {"--threads", "3", "--resume"}));
  ASSERT_EQ(rest.exit_code, 0) << rest.errors;

  for (const char* files : {"denoised.####.exr", "noisy.####.exr"}) {
    EXPECT_THAT(Differences(folder / "beside", folder / "in_turn", files, 12), IsEmpty()) << files;
    EXPECT_THAT(Differences(folder / "beside", part, files, 12), IsEmpty()) << files;
  }
  EXPECT_THAT(Differences(folder / "beside", folder / "cpu", "noisy.####.exr", 12), IsEmpty());
  EXPECT_EQ(ReadText(folder / "beside/reference.0012.exr"),
            ReadText(folder / "in_turn/reference.0012.exr"));
}

TEST_F(CliDeviceHistory, TracingOnTheDeviceBesideFilteringOnTheCpuGivesTheSameBits) {
  const TemporaryFolder folder;
  for (const char* threads : {"3", "1"}) {
    const ProgramRun run =
        RunProgram({"render", "builtin:lights", "-o", folder / threads, "--size", "40x22",
                    "--frames", "1-4", "--bounces", "1", "--format", "exr", "--device", "cpu",
                    "--trace-device", "vulkan", "--threads", threads});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, HasSubstr("tracing on vulkan:0"));
  }
  EXPECT_THAT(ReadText(folder / "3/render.json"), HasSubstr("\"traces_ahead\": true"));
  EXPECT_THAT(Differences(folder / "3", folder / "1", "denoised.####.exr", 4), IsEmpty());
}

TEST_F(CliDeviceHistory, InterruptedAndResumedRenderingGivesTheSameBits) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunProgram(RenderArguments(folder / "whole")).exit_code, 0);
  const std::string part = folder / "part";
  const ProgramRun stopped = InterruptProgram(RenderArguments(part), part + "/denoised.0003.exr");
  ASSERT_EQ(stopped.exit_code, 130) << stopped.errors;
  EXPECT_FALSE(fs::exists(part + "/denoised.0020.exr")) << "it was not interrupted";
  std::vector<std::string> again = RenderArguments(part);
  again.push_back("--resume");
  std::vector<std::string> on_cpu = again;
  on_cpu.insert(on_cpu.end(), {"--device", "cpu"});
  const ProgramRun refused = RunProgram(on_cpu);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("made with 'device vulkan', this run has 'device cpu'"));
  const ProgramRun resumed = RunProgram(again);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame"));
  EXPECT_THAT(resumed.errors, HasSubstr("rendering on vulkan:0"));
  EXPECT_THAT(Differences(folder / "whole", part, "denoised.####.exr", 20), IsEmpty());
}

/// Stops before frame 5, whose file is in the way, and goes on.
void StopAndResume(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 8);
  DenoiseWell(in, folder / "whole", more);
  const std::string part = folder / "part";
  fs::create_directories(part + "/f.0005.exr/in_the_way");
  const ProgramRun stopped = Denoise(in, part, more);
  EXPECT_EQ(stopped.exit_code, 2);
  EXPECT_THAT(stopped.errors, HasSubstr("4 of 8 frames are finished"));
  fs::remove_all(part + "/f.0005.exr");
  std::vector<std::string> again = more;
  again.push_back("--resume");
  DenoiseWell(in, part, again);
  EXPECT_THAT(Differences(folder / "whole", part, "f.####.exr", 8), IsEmpty());
}

TEST_F(CliDeviceHistory, StoppedAndResumedDenoisingGivesTheSameBits) {
  StopAndResume({"--window", "past"});
}

TEST_F(CliDeviceHistory, StoppedAndResumedWindowBothGivesTheSameBits) {
  StopAndResume({"--window", "both"});
}

TEST_F(CliDeviceHistory, StoppedAndResumedPassesGiveTheSameBits) {
  StopAndResume({"--passes"});
}

TEST_F(CliDeviceHistory, FirstFramesAreAsCleanAsOnTheCpu) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, shot, 1, 10);
  DenoiseWell(in, folder / "past", {"--window", "past"});
  DenoiseWell(in, folder / "both", {"--window", "both"});
  ASSERT_EQ(RunProgram({"denoise", in, "-o", folder / "cpu/f.####.exr", "--window", "both",
                        "--device", "cpu"})
                .exit_code,
            0);
  const double past = ShotError(folder / "past/f.####.exr", shot, 1);
  const double both = ShotError(folder / "both/f.####.exr", shot, 1);
  EXPECT_GT(past, 2 * both);  // 3 dB
  EXPECT_NEAR(both, ShotError(folder / "cpu/f.####.exr", shot, 1), 0.05 * both);
}

TEST_F(CliDeviceHistory, PassesAreThoseOfTheCpu) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, shot, 1, 4);
  DenoiseWell(in, folder / "gpu", {"--passes"});
  ASSERT_EQ(
      RunProgram({"denoise", in, "-o", folder / "cpu/f.####.exr", "--passes", "--device", "cpu"})
          .exit_code,
      0);
  const Result<ExrImage> got = ReadExr(folder / "gpu/f.0004.exr");
  const Result<ExrImage> expected = ReadExr(folder / "cpu/f.0004.exr");
  ASSERT_TRUE(got.ok() && expected.ok());
  ASSERT_EQ(got->channels.size(), expected->channels.size());
  for (size_t i = 0; i < got->channels.size(); ++i) {
    const Image1& a = got->channels[i].values;
    const Image1& b = expected->channels[i].values;
    double error = 0;
    double square = 0;
    for (int y = 0; y < b.height(); ++y) {
      for (int x = 0; x < b.width(); ++x) {
        error += std::pow(static_cast<double>(a(x, y)) - static_cast<double>(b(x, y)), 2);
        square += std::pow(static_cast<double>(b(x, y)), 2);
      }
    }
    EXPECT_LE(std::sqrt(error), 0.03 * std::sqrt(square)) << expected->channels[i].name;
  }
}

}  // namespace
}  // namespace stillray::cli_device_history_test
