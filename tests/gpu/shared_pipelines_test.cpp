// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Pipelines of one device are made once for all its users.
#include "gpu/shared_pipelines.h"

#include <array>
#include <barrier>
#include <thread>
#include <vector>

#include "gpu/vulkan_test.h"

namespace shaders {
extern const std::uint32_t kDoubleValues[];
extern const std::size_t kDoubleValuesWords;
}  // namespace shaders

namespace stillray::shared_pipelines_test {
namespace {

class SharedPipelines : public test::OwnVulkanTest {
 protected:
  gpu::SharedPipelines& shared() const { return *device_->context().pipelines; }
  /// The test's shader with this layout and this factor in place of 2.
  gpu::Pipeline Make(const gpu::SetShape& shape, uint32_t push_bytes, uint32_t factor) const {
    const gpu::DescriptorSets sets(&device_->context());  // ends before the pipeline
    const VkDescriptorSetLayout layout = *sets.Layout(shape);
    const Result<gpu::Pipeline> made = gpu::Pipeline::Create(
        &device_->context(), {"double_values",
                              {shaders::kDoubleValues, shaders::kDoubleValuesWords},
                              {&layout, 1},
                              push_bytes,
                              {&factor, 1}});
    EXPECT_TRUE(made.ok()) << made.status().message();
    return *made;
  }
};

TEST_F(SharedPipelines, AreTheSameIfNothingDiffers) {
  const gpu::SetShape shape = {1, 1, 0, 0};
  const gpu::Pipeline first = Make(shape, 4, 3);
  EXPECT_NE(first.handle(), VkPipeline{VK_NULL_HANDLE});
  EXPECT_NE(first.layout(), VkPipelineLayout{VK_NULL_HANDLE});
  EXPECT_EQ(shared().created(), 1u);
  const gpu::Pipeline again = Make(shape, 4, 3);
  EXPECT_EQ(again.handle(), first.handle());
  EXPECT_EQ(again.layout(), first.layout());
  EXPECT_EQ(shared().created(), 1u);
  EXPECT_NE(Make(shape, 4, 5).handle(), first.handle());         // another constant
  EXPECT_NE(Make(shape, 8, 3).handle(), first.handle());         // other push constants
  EXPECT_NE(Make({1, 1, 0, 1}, 4, 3).handle(), first.handle());  // another set
  EXPECT_EQ(shared().created(), 4u);
}

TEST_F(SharedPipelines, LayoutsOfSetsAreThoseOfTheDevice) {
  const gpu::DescriptorSets one(&device_->context());
  const gpu::DescriptorSets other(&device_->context());
  EXPECT_EQ(*one.Layout({1, 2, 0, 3}), *other.Layout({1, 2, 0, 3}));
  EXPECT_NE(*one.Layout({1, 2, 0, 3}), *one.Layout({1, 2, 1, 2}));
}

TEST_F(SharedPipelines, DevicesShareNothing) {
  const auto other = gpu::Device::Create(instance_, device_->info());
  ASSERT_TRUE(other.ok());
  Make({1, 1, 0, 0}, 4, 3);
  EXPECT_EQ(shared().created(), 1u);
  EXPECT_EQ((*other)->context().pipelines->created(), 0u);
}

TEST_F(SharedPipelines, ThreadsGetOnePipeline) {
  constexpr int kThreads = 6;
  constexpr uint32_t kFactors = 4;
  std::vector<std::array<gpu::Pipeline, kFactors>> made(kThreads);
  std::barrier begin(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      begin.arrive_and_wait();
      for (uint32_t k = 0; k < kFactors; ++k) {
        const uint32_t factor = (k + static_cast<uint32_t>(t)) % kFactors;  // in another order
        made[t][factor] = Make({1, 1, 0, 0}, 4, factor);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(shared().created(), kFactors);
  for (int t = 0; t < kThreads; ++t) {
    for (uint32_t k = 0; k < kFactors; ++k) {
      EXPECT_EQ(made[t][k].handle(), made[0][k].handle()) << t << " " << k;
    }
  }
}

}  // namespace
}  // namespace stillray::shared_pipelines_test
