// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// `--device` of the program, and its messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "apps/program.h"
#include "stillray/denoise.hpp"

namespace stillray::cli_device_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

ProgramRun Render(const std::string& folder, std::vector<std::string> more) {
  std::vector<std::string> arguments = {"render", "builtin:cornell", "-o",  folder,     "--size",
                                        "48x32",  "--frames",        "1-2", "--format", "exr"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

bool HasDevice() {
  std::string remark;
  const std::vector<DeviceDescription> devices = ListDevices(&remark);
  return !devices.empty() && devices.front().usable.ok();
}

TEST(CliDevice, WrongOnesAreNamed) {
  const TemporaryFolder folder;
  ProgramRun run = Render(folder.path(), {"--device", "gpu"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--device: device is 'gpu', expected auto, cpu, vulkan or "));
  run = Render(folder.path(), {"--device", "vulkan:77"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--device: "));
  run = Render(folder.path(), {"--trace-device", "gpu"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--trace-device: device is 'gpu', expected auto, cpu, "));
  run = Render(folder.path(), {"--trace-device", "cpu", "--ray-tracing", "hardware"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--ray-tracing is 'hardware', but the CPU traces"));
}

TEST(CliDevice, AutoSaysWhereItWorks) {
  const TemporaryFolder folder;
  const ProgramRun run = Render(folder.path(), {});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("rendering on "));
  EXPECT_THAT(Render(folder.path(), {"--device", "cpu"}).errors,
              StartsWith("rendering on the CPU, "));
}

TEST(CliDevice, TheProgramStartsWithoutALoader) {
  // A library path in which the loader's name stands for something else.
  const TemporaryFolder folder;
  std::ofstream(folder / "libvulkan.so.1") << "no library";
  setenv("LD_LIBRARY_PATH", folder.path().c_str(), 1);
  const ProgramRun list = RunProgram({"info", "--devices"});
  const ProgramRun run = Render(folder / "out", {});
  unsetenv("LD_LIBRARY_PATH");
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.output, HasSubstr("cpu\n"));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("rendering on "));
}

TEST(CliDevice, VulkanRendersAndTellsTimesAndMemory) {
  if (!HasDevice()) {
    GTEST_SKIP() << "there is no usable Vulkan device";
  }
  const TemporaryFolder folder;
  const ProgramRun run =
      Render(folder.path(), {"--device", "vulkan", "--timings", "--save-inputs"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("rendering on vulkan:"));
  EXPECT_THAT(run.output + run.errors, HasSubstr("atrous"));
  EXPECT_THAT(run.output + run.errors, HasSubstr("trace_shadow_rays"));
  EXPECT_TRUE(std::filesystem::exists(folder / "noisy.0002.exr"));
  EXPECT_THAT(run.output + run.errors, HasSubstr("memory on the device: "));
  EXPECT_TRUE(std::filesystem::exists(folder / "denoised.0002.exr"));
}

/// Runs the program with a loader that fails: see failing_loader.cpp.
class FailingProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!HasDevice()) {
      GTEST_SKIP() << "there is no usable Vulkan device";
    }
    void* library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library, nullptr);
    Dl_info real = {};
    ASSERT_NE(dladdr(dlsym(library, "vkGetInstanceProcAddr"), &real), 0);
    setenv("FAILING_REAL", real.dli_fname, 1);
    setenv("LD_LIBRARY_PATH", STILLRAY_FAILING_FOLDER, 1);
    // A software driver that claims to be a GPU may take any time on a busy machine.
    setenv("STILLRAY_GPU_TIMEOUT", "600", 1);
  }
  void TearDown() override {
    for (const char* name : {"FAILING_REAL", "LD_LIBRARY_PATH", "FAILING_CALL", "FAILING_DEVICE",
                             "STILLRAY_GPU_TIMEOUT"}) {
      unsetenv(name);
    }
  }
  static int CountLines(const std::string& text, const std::string& beginning) {
    int lines = 0;
    for (size_t at = text.find(beginning); at != std::string::npos;
         at = text.find(beginning, at + 1)) {
      lines += at == 0 || text[at - 1] == '\n' ? 1 : 0;
    }
    return lines;
  }
};

TEST_F(FailingProgram, RenderTellsWhatFailed) {
  for (const auto& [call, told] :
       {std::pair{"vkQueueSubmit:2:-4", "submitting work: the device was lost"},
        std::pair{"vkWaitForFences:1:-4", "waiting for the device: the device was lost"},
        std::pair{"vkAllocateMemory:1:-2", "allocating device memory: out of device memory"},
        std::pair{"vkCreateImage:1:-1", "creating an image: out of host memory"},
        std::pair{"vkCreateInstance:1:-9", "no Vulkan driver is installed"}}) {
    setenv("FAILING_CALL", call, 1);
    const TemporaryFolder folder;
    const ProgramRun run = Render(folder.path(), {"--device", "vulkan"});
    EXPECT_EQ(run.exit_code, 2) << call;
    EXPECT_THAT(run.errors, HasSubstr(told)) << call;
    EXPECT_EQ(CountLines(run.errors, "stillray: error: "), 1) << run.errors;
  }
}

TEST_F(FailingProgram, DevicesThatLackSomethingAreNamed) {
  for (const auto& [kind, told] :
       {std::pair{"old", "the driver offers Vulkan 1.0, expected 1.1 or newer"},
        std::pair{"poor", "the device lacks the feature shaderStorageImageExtendedFormats"}}) {
    setenv("FAILING_DEVICE", kind, 1);
    const TemporaryFolder folder;
    ProgramRun run = Render(folder.path(), {"--device", "vulkan"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr(told));
    run = Render(folder / "auto", {});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, StartsWith("rendering on the CPU, "));
    EXPECT_THAT(run.errors, HasSubstr("; no usable Vulkan device\n"));
    EXPECT_THAT(Render(folder / "verbose", {"--verbose"}).errors, HasSubstr(told));
    EXPECT_THAT(RunProgram({"info", "--devices"}).output, HasSubstr(told));
  }
}

TEST_F(FailingProgram, AutoFallsBackToTheCpu) {
  setenv("FAILING_DEVICE", "gpu", 1);
  const TemporaryFolder folder;
  ProgramRun run = Render(folder / "gpu", {});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("rendering on vulkan:0"));
  for (const char* call : {"vkCreateDevice:1:-3", "vkCreateCommandPool:1:-2", "vkCreateFence:1:-1",
                           "vkCreateInstance:1:-9", "vkEnumeratePhysicalDevices:1:-1"}) {
    setenv("FAILING_CALL", call, 1);
    run = Render(folder / call, {});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.errors, StartsWith("rendering on the CPU, ")) << call;
    EXPECT_THAT(run.errors, Not(HasSubstr("Vulkan: "))) << call;
    run = Render(folder / call, {"-v"});
    EXPECT_THAT(run.errors, HasSubstr("\nVulkan: ")) << call;
  }
  // Later failures fall back to the CPU, too: of the tracer alone, or of the denoiser.
  for (const auto& [call, told] :
       {std::pair{"vkAllocateMemory:1:-2", "tracing on the CPU: Vulkan: "},
        std::pair{"vkCreateComputePipelines:2:-1", "tracing on the CPU: Vulkan: "},
        std::pair{"vkQueueSubmit:2:-4", "tracing on the CPU: Vulkan: "},
        std::pair{"vkCreateImage:1:-2", "denoising on the CPU after all: Vulkan: "}}) {
    setenv("FAILING_CALL", call, 1);
    run = Render(folder / call, {});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(CountLines(run.errors, told), 1) << run.errors;
    EXPECT_TRUE(std::filesystem::exists(folder / call + "/denoised.0002.exr"));
  }
  // Where there is no memory for frames on the device, they go through the host.
  EXPECT_EQ(CountLines(run.errors, "tracing on the CPU: "), 0) << run.errors;
}

TEST_F(FailingProgram, AutoRunsOnTheCpuWhatOnlyTheCpuHas) {
  setenv("FAILING_DEVICE", "gpu", 1);
  const TemporaryFolder folder;
  ProgramRun run = Render(folder / "auto", {"--preset", "best"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("restore_detail"));
  EXPECT_TRUE(std::filesystem::exists(folder / "auto/denoised.0002.exr"));
  run = Render(folder / "named", {"--preset", "best", "--device", "vulkan"});
  EXPECT_EQ(run.exit_code, 2) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("restore_detail, which preset best turns on, runs on the CPU"));
}

// The filter's device may be lost while the CPU traces the next frame.
TEST_F(FailingProgram, TracingOnTheCpuGoesOnWithoutTheFiltersDevice) {
  const TemporaryFolder folder;
  const std::vector<std::string> beside = {"--device", "vulkan",    "--trace-device",
                                           "cpu",      "--threads", "2"};
  setenv("FAILING_CALL", "vkQueueSubmit:1:-4", 1);
  ProgramRun run = Render(folder / "named", beside);
  EXPECT_EQ(run.exit_code, 2) << run.errors;
  EXPECT_EQ(CountLines(run.errors, "stillray: error: "), 1) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("the device was lost"));
  setenv("FAILING_DEVICE", "gpu", 1);
  run = Render(folder / "auto", {"--trace-device", "cpu", "--threads", "2"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("denoising on vulkan:0"));
  EXPECT_EQ(CountLines(run.errors, "denoising on the CPU after all: "), 1) << run.errors;
  EXPECT_TRUE(std::filesystem::exists(folder / "auto/denoised.0002.exr"));
}

// Frames that stay on the device are lost with it.
TEST_F(FailingProgram, FramesLostWithTheDeviceAreTracedAgain) {
  setenv("FAILING_DEVICE", "gpu", 1);
  const TemporaryFolder folder;
  int lost = 0;
  for (int call = 9; call <= 15; ++call) {  // the last of the scene, then frames
    setenv("FAILING_CALL", ("vkQueueSubmit:" + std::to_string(call) + ":-4").c_str(), 1);
    const std::string out = folder / std::to_string(call);
    const ProgramRun run = Render(out, {});
    if (run.exit_code != 0) {  // one was finished: the next must not look different
      EXPECT_THAT(run.errors, HasSubstr("the device was lost")) << call;
      continue;
    }
    EXPECT_TRUE(std::filesystem::exists(out + "/denoised.0002.exr")) << call;
    lost += CountLines(run.errors, "denoising on the CPU after all: ") == 1 &&
            CountLines(run.errors, "tracing on the CPU: ") == 1;
  }
  EXPECT_GE(lost, 1);
}

TEST_F(FailingProgram, BenchAndViewerSayIt) {
  setenv("FAILING_CALL", "vkQueueSubmit:2:-4", 1);
  ProgramRun run = RunProgram({"bench", "--device", "vulkan", "--size", "32x32", "--preset", "svgf",
                               "--kernel", "3x3", "--repeats", "1"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("the device was lost"));
  run = RunProgram({"view", "builtin:cornell", "--device", "vulkan", "--size", "32x32",
                    "--headless-frames", "4"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(CountLines(run.errors, "note: tracing goes on on the CPU: "), 1) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("; filtering goes on on the CPU: "));
}

}  // namespace
}  // namespace stillray::cli_device_test
