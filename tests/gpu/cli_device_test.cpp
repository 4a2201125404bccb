// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// `--device` of the program, and what it says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "apps/program.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using ::testing::HasSubstr;
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
  run = Render(folder.path(), {"--device", "vulkan", "--resume"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--resume works on the CPU only: --device cpu"));
}

TEST(CliDevice, AutoSaysWhereItWorks) {
  const TemporaryFolder folder;
  const ProgramRun run = Render(folder.path(), {});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("denoising on "));
  EXPECT_EQ(Render(folder.path(), {"--device", "cpu"}).errors.find("denoising on "),
            std::string::npos);
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
  EXPECT_THAT(run.errors, StartsWith("denoising on "));
}

TEST(CliDevice, VulkanDenoisesAndTellsTimesAndMemory) {
  if (!HasDevice()) {
    GTEST_SKIP() << "there is no usable Vulkan device";
  }
  const TemporaryFolder folder;
  const ProgramRun run = Render(folder.path(), {"--device", "vulkan", "--timings"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("denoising on vulkan:"));
  EXPECT_THAT(run.output + run.errors, HasSubstr("atrous"));
  EXPECT_THAT(run.output + run.errors, HasSubstr("memory on the device: "));
  EXPECT_TRUE(std::filesystem::exists(folder / "denoised.0002.exr"));
}

}  // namespace
}  // namespace stillray
