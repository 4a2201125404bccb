// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/raster.h"

#include <array>
#include <string>

#include "gpu/pipeline.h"

namespace stillray::gpu {

Raster::~Raster() {
  const DeviceFunctions& vk = context_->vk;
  vk.DestroyPipeline(context_->device, pipeline_, nullptr);
  vk.DestroyPipelineLayout(context_->device, layout_, nullptr);
  vk.DestroyFramebuffer(context_->device, framebuffer_, nullptr);
  vk.DestroyRenderPass(context_->device, pass_, nullptr);
}

Status Raster::MakePass(VkFormat format) {
  std::array<VkAttachmentDescription, 2> attachments = {};
  attachments[0].format = format;
  attachments[0].finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  attachments[1].format = kDepthFormat;
  attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  for (VkAttachmentDescription& attachment : attachments) {
    attachment.samples = VK_SAMPLE_COUNT_1_BIT;
    attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachment.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  }
  const VkAttachmentReference colour = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass = {};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &colour;
  subpass.pDepthStencilAttachment = &depth;
  constexpr VkPipelineStageFlags kTests =
      VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  constexpr VkAccessFlags kWrites =
      VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  std::array<VkSubpassDependency, 2> order = {};
  // Waits for earlier reads of and draws to the attachments.
  order[0].srcSubpass = VK_SUBPASS_EXTERNAL;
  order[0].srcStageMask =
      VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kTests;
  order[0].srcAccessMask = kWrites;
  order[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kTests;
  order[0].dstAccessMask = kWrites | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
  order[1].dstSubpass = VK_SUBPASS_EXTERNAL;
  order[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  order[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  order[1].dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
  order[1].dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
  VkRenderPassCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
  info.attachmentCount = static_cast<uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = static_cast<uint32_t>(order.size());
  info.pDependencies = order.data();
  return ToStatus(context_->vk.CreateRenderPass(context_->device, &info, nullptr, &pass_),
                  "creating a render pass");
}

Status Raster::MakeFramebuffer(const Image& picture, const Image& depth) {
  const std::array<VkImageView, 2> views = {picture.view, depth.view};
  VkFramebufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
  info.renderPass = pass_;
  info.attachmentCount = static_cast<uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = static_cast<uint32_t>(picture.width);
  info.height = static_cast<uint32_t>(picture.height);
  info.layers = 1;
  return ToStatus(context_->vk.CreateFramebuffer(context_->device, &info, nullptr, &framebuffer_),
                  "creating a framebuffer");
}

Status Raster::MakePipeline(const RasterInfo& info) {
  const std::string action = std::string("compiling the shaders ") + info.name;
  std::array<VkPipelineShaderStageCreateInfo, 2> stages = {};
  for (VkPipelineShaderStageCreateInfo& stage : stages) {
    stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stage.pName = "main";
  }
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  VkPipelineVertexInputStateCreateInfo input = {};
  input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
  VkPipelineInputAssemblyStateCreateInfo assembly = {};
  assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo view = {};
  view.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
  view.viewportCount = 1;
  view.scissorCount = 1;
  const std::array<VkDynamicState, 2> later = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic = {};
  dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
  dynamic.dynamicStateCount = static_cast<uint32_t>(later.size());
  dynamic.pDynamicStates = later.data();
  VkPipelineRasterizationStateCreateInfo raster = {};
  raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = VK_CULL_MODE_NONE;
  raster.lineWidth = 1;
  VkPipelineMultisampleStateCreateInfo samples = {};
  samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth = {};
  depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = VK_TRUE;
  depth.depthCompareOp = VK_COMPARE_OP_GREATER;
  VkPipelineColorBlendAttachmentState write = {};
  write.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                         VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  VkPipelineColorBlendStateCreateInfo blend = {};
  blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
  blend.attachmentCount = 1;
  blend.pAttachments = &write;
  VkGraphicsPipelineCreateInfo create = {};
  create.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
  create.stageCount = static_cast<uint32_t>(stages.size());
  create.pStages = stages.data();
  create.pVertexInputState = &input;
  create.pInputAssemblyState = &assembly;
  create.pViewportState = &view;
  create.pRasterizationState = &raster;
  create.pMultisampleState = &samples;
  create.pDepthStencilState = &depth;
  create.pColorBlendState = &blend;
  create.pDynamicState = &dynamic;
  create.layout = layout_;
  create.renderPass = pass_;
  Status made = MakeShaderModule(*context_, info.vertex, action.c_str(), &stages[0].module);
  if (made.ok()) {
    made = MakeShaderModule(*context_, info.fragment, action.c_str(), &stages[1].module);
  }
  if (made.ok()) {
    made = ToStatus(context_->vk.CreateGraphicsPipelines(context_->device, context_->pipeline_cache,
                                                         1, &create, nullptr, &pipeline_),
                    action.c_str());
  }
  for (const VkPipelineShaderStageCreateInfo& stage : stages) {
    context_->vk.DestroyShaderModule(context_->device, stage.module, nullptr);
  }
  return made;
}

Status Raster::Create(const RasterInfo& info, const Image& picture, const Image& depth) {
  STILLRAY_RETURN_IF_ERROR(MakePass(picture.format));
  STILLRAY_RETURN_IF_ERROR(MakeFramebuffer(picture, depth));
  STILLRAY_RETURN_IF_ERROR(MakePipelineLayout(*context_, info.sets, VK_SHADER_STAGE_VERTEX_BIT,
                                              info.push_bytes, &layout_));
  return MakePipeline(info);
}

void Raster::RecordBegin(VkCommandBuffer commands, VkExtent2D size, VkClearColorValue clear) const {
  const VkRect2D area = {{0, 0}, size};
  const VkViewport viewport = {
      0, 0, static_cast<float>(size.width), static_cast<float>(size.height), 0, 1};
  std::array<VkClearValue, 2> clears = {};
  clears[0].color = clear;
  clears[1].depthStencil = {0, 0};
  VkRenderPassBeginInfo begin = {};
  begin.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
  begin.renderPass = pass_;
  begin.framebuffer = framebuffer_;
  begin.renderArea = area;
  begin.clearValueCount = static_cast<uint32_t>(clears.size());
  begin.pClearValues = clears.data();
  context_->vk.CmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  context_->vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
  context_->vk.CmdSetViewport(commands, 0, 1, &viewport);
  context_->vk.CmdSetScissor(commands, 0, 1, &area);
}

void Raster::RecordEnd(VkCommandBuffer commands) const {
  context_->vk.CmdEndRenderPass(commands);
}

}  // namespace stillray::gpu
