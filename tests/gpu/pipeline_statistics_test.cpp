// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What drivers report of compiled shaders.
#include "gpu/pipeline_statistics.h"

#include <gmock/gmock.h>

#include <cstdlib>

#include "gpu/shared_pipelines.h"
#include "gpu/vulkan_test.h"

namespace shaders {
extern const std::uint32_t kDoubleValues[];
extern const std::size_t kDoubleValuesWords;
}  // namespace shaders

namespace stillray::pipeline_statistics_test {
namespace {

using ::testing::HasSubstr;

class PipelineStatistics : public test::OwnVulkanTest {
 protected:
  void TearDown() override {
    unsetenv(gpu::kPipelineStatisticsVariable);
    test::OwnVulkanTest::TearDown();
  }

  /// What a device that is created with the variable prints when it makes a pipeline.
  std::string Printed(const char* variable) {
    setenv(gpu::kPipelineStatisticsVariable, variable, 1);
    const Result<std::shared_ptr<gpu::Device>> device =
        gpu::Device::Create(instance_, device_->info());
    EXPECT_TRUE(device.ok()) << device.status().message();
    const gpu::DeviceContext& context = (*device)->context();
    gpu::DescriptorSets sets(&context);
    const VkDescriptorSetLayout layout = *sets.Layout({1, 1, 0, 0});
    const std::span<const uint32_t> code = {shaders::kDoubleValues, shaders::kDoubleValuesWords};
    ::testing::internal::CaptureStderr();
    EXPECT_TRUE(
        gpu::Pipeline::Create(&context, {"double_values", code, {&layout, 1}, sizeof(float), {}})
            .ok());
    return ::testing::internal::GetCapturedStderr();
  }
};

// Drivers without the extension compile the same shader and print nothing.
TEST_F(PipelineStatistics, ArePrintedIfTheDriverHasThem) {
  setenv(gpu::kPipelineStatisticsVariable, "1", 1);
  const bool offered = gpu::WantsPipelineStatistics(instance_->functions(), device_->info().handle);
  const std::string printed = Printed("1");
  if (offered) {
    EXPECT_THAT(printed, HasSubstr("shader double_values (), "));
  } else {
    EXPECT_EQ(printed, "");
  }
  RecordProperty("statistics", offered ? "are offered" : "are not offered");
}

TEST_F(PipelineStatistics, AreOffUnlessAskedFor) {
  EXPECT_EQ(Printed("0"), "");
  EXPECT_EQ(Printed(""), "");
  EXPECT_FALSE(gpu::WantsPipelineStatistics(instance_->functions(), device_->info().handle));
}

}  // namespace
}  // namespace stillray::pipeline_statistics_test
