// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Intermediate images of a denoiser on Vulkan, by their public names.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "denoise/vulkan/frame_pipeline.h"

namespace stillray::vulkan {

/// Downloads the source images of requested outputs, and converts them to those outputs.
class OutputReader : public FrameObserver {
 public:
  /// \param names  full names of outputs, see Denoiser::OutputNames
  static Result<std::unique_ptr<OutputReader>> Create(const gpu::DeviceContext* context,
                                                      const FramePipeline& pipeline,
                                                      std::vector<std::string> names);
  void BeginFrame();
  bool Wants(std::string_view name) const override;
  void Keep(VkCommandBuffer commands, std::string_view name, const gpu::Image& image) override;

  /// Copies remaining images at the end of a frame.
  void Finish(VkCommandBuffer commands, const FramePipeline& pipeline);
  /// Converts the outputs after the device has finished the frame.
  /// \param confidence  of the frame; nullptr: none
  Status Read(const FramePipeline& pipeline, const FrameState& state, const FramePlan& plan,
              const Image1* confidence, std::vector<NamedImage>* images) const;
  const std::vector<std::string>& names() const { return names_; }
  gpu::MemoryUse memory() const { return arena_.Need(); }

 private:
  /// Host copy of an image: width x height x layers, four values each.
  struct Kept {
    const gpu::Buffer* buffer = nullptr;
    bool copied = false;  ///< in this frame
  };
  explicit OutputReader(const gpu::DeviceContext* context) : context_(context), arena_(context) {}
  /// Channel of an image at a pixel.
  float Load(const std::string& name, int layer, int channel, int x, int y) const;
  void ReadPicture(const std::string& name, const FrameState& state, NamedImage* out) const;
  void ReadSignal(const std::string& kind, int signal, const FrameState& state,
                  const FramePlan& plan, const Image1* confidence, NamedImage* out) const;
  void ReadDisocclusion(bool had_history, NamedImage* out) const;

  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  Shape shape_;
  std::vector<std::string> names_;
  std::map<std::string, Kept, std::less<>> kept_;
};

}  // namespace stillray::vulkan
