// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/fill_guides/fill_guides.h"

#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/fill_guides/held_guides.h"

namespace stillray::vulkan {
namespace {

/// First colour that is radiance (emission, background), which needs the range of floats.
constexpr int kFirstLight = 3;
/// Layers of the pyramid other than colours: see pyramid.glsl.
constexpr int kOtherLayers = 3;
constexpr VkDeviceSize kBytesPerCell = 16;
/// Largest number of cells that a single workgroup processes.
constexpr int kTopCells = 4096;

struct Level {
  int32_t width;
  int32_t height;
  int32_t start;

  int cells() const { return width * height; }
};

/// The levels above an image, at least one.
std::vector<Level> LevelsOf(int width, int height) {
  std::vector<Level> levels = {{CellsOf(width), CellsOf(height), 0}};
  while (levels.back().cells() > 1) {
    const Level& l = levels.back();
    levels.push_back({CellsOf(l.width), CellsOf(l.height), l.start + l.cells()});
  }
  return levels;
}

int CellsOfLevels(int width, int height) {
  const Level top = LevelsOf(width, height).back();
  return top.start + top.cells();
}

struct LevelPush {
  int32_t of_motion;
  Level level;
};

Groups GroupsOf(const Level& level) {
  return GroupsFor(level.width, level.height);
}

}  // namespace

uint32_t FillGuidesPass::ColoursOf(const FrameFacts& facts) {
  return facts.albedos | (facts.has_emission ? 8u : 0u) | (facts.has_background ? 16u : 0u);
}

bool FillGuidesPass::Fits(const FrameFacts& facts) const {
  return (ColoursOf(facts) & ~options_.colours) == 0 && (options_.has_id || !facts.has_id);
}

Status FillGuidesPass::AddAll(const Options& o) {
  options_ = o;
  Status status;
  const auto add = [&](VkFormat format, bool wanted) -> const gpu::Image* {
    const Result<const gpu::Image*> image =
        arena_.AddImage(format, wanted ? o.width : 1, wanted ? o.height : 1, 0);
    if (!image.ok()) {
      status = image.status();
      return nullptr;
    }
    return *image;
  };
  const VkFormat light =
      o.storage == Storage::kHalf ? VK_FORMAT_R16G16B16A16_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
  for (Held* held : {&progress_.now, &progress_.before}) {
    held->depth = add(VK_FORMAT_R32_SFLOAT, true);
    held->normal = add(light, true);
    held->id = add(VK_FORMAT_R32_UINT, o.has_id);
    for (int k = 0; k < kGuideColours; ++k) {
      held->colour[static_cast<size_t>(k)] =
          add(k < kFirstLight ? light : VK_FORMAT_R32G32B32A32_SFLOAT, (o.colours >> k & 1u) != 0);
    }
  }
  motion_ = add(VK_FORMAT_R32G32_SFLOAT, true);
  STILLRAY_RETURN_IF_ERROR(status);
  const auto layers = static_cast<VkDeviceSize>(kOtherLayers + std::popcount(o.colours));
  const Result<const gpu::Buffer*> cells = arena_.AddBuffer(
      layers * kBytesPerCell * static_cast<VkDeviceSize>(CellsOfLevels(o.width, o.height)),
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice);
  STILLRAY_RETURN_IF_ERROR(cells.status());
  cells_ = *cells;
  const Result<const gpu::Buffer*> rejected = arena_.AddBuffer(
      sizeof(uint32_t) * static_cast<VkDeviceSize>(o.width) * static_cast<VkDeviceSize>(o.height),
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice);
  STILLRAY_RETURN_IF_ERROR(rejected.status());
  rejected_ = *rejected;
  return Status::Ok();
}

Result<gpu::MemoryUse> FillGuidesPass::Need(const gpu::DeviceContext* context,
                                            const Options& options) {
  FillGuidesPass fill_guides(context);
  STILLRAY_RETURN_IF_ERROR(fill_guides.AddAll(options));
  return fill_guides.memory();
}

Result<std::unique_ptr<FillGuidesPass>> FillGuidesPass::Create(const gpu::DeviceContext* context,
                                                               Pipelines* pipelines,
                                                               const Options& options) {
  std::unique_ptr<FillGuidesPass> made(new FillGuidesPass(context));
  STILLRAY_RETURN_IF_ERROR(made->AddAll(options));
  STILLRAY_RETURN_IF_ERROR(made->arena_.Allocate());
  for (const Shader shader :
       {Shader::kFindKnown, Shader::kRejectGhosts, Shader::kDownsampleLevel, Shader::kFillTopLevels,
        Shader::kFillLevel, Shader::kGatherKnown, Shader::kGatherKnownColours, Shader::kFillHoles,
        Shader::kFillHoleColours}) {
    STILLRAY_RETURN_IF_ERROR(pipelines->Find(shader).status());
  }
  return made;
}

void FillGuidesPass::Resize(int width, int height) {
  if (width != options_.width || height != options_.height) {
    options_.width = width;
    options_.height = height;
    Reset();
  }
}

void FillGuidesPass::Begin(const FrameFacts& facts, FrameParameters* p) {
  const uint32_t colours = ColoursOf(facts);
  Kinds& kinds = progress_.kinds;
  if (colours != kinds.colours || facts.has_id != kinds.id) {
    Reset();
  }
  kinds.colours = colours;
  kinds.id = facts.has_id;
  const Shift shift(facts.index);
  p->has_held = kinds.any ? 1 : 0;
  p->guide_colours = static_cast<int>(colours);
  p->pyramid_cells = CellsOfLevels(options_.width, options_.height);
  p->ghost_stamp = ++progress_.stamp;
  p->shift_x = shift.x;
  p->shift_y = shift.y;
}

void FillGuidesPass::PrepareImages(VkCommandBuffer commands) {
  if (prepared_) {
    return;
  }
  prepared_ = true;
  arena_.RecordFirstUse(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                        VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  context_->vk.CmdFillBuffer(commands, rejected_->buffer, 0, VK_WHOLE_SIZE, 0);
}

/// Prepares the images, and clears the counts.
void FillGuidesPass::PrepareMemory(PassRecorder* recorder, const gpu::Buffer& state) {
  recorder->Barrier();
  gpu::CommandList* const commands = recorder->commands();
  commands->Call([this](VkCommandBuffer into) { PrepareImages(into); });
  static_assert(offsetof(FrameState, guides_move) ==
                offsetof(FrameState, known_pixels) + sizeof(uint32_t));
  commands->Fill(state.buffer, offsetof(FrameState, known_pixels), 2 * sizeof(uint32_t), 0);
}

/// Fills the pyramid from the first level up to the top and down again, with a single workgroup for
/// small levels.
void FillGuidesPass::FillPyramid(PassRecorder* recorder, bool of_motion) const {
  const std::vector<Level> levels = LevelsOf(options_.width, options_.height);
  const auto push = [&](size_t level) { return LevelPush{of_motion ? 1 : 0, levels[level]}; };
  size_t first_small = 0;
  while (levels[first_small].cells() > kTopCells) {
    recorder->Run(Shader::kDownsampleLevel, GroupsOf(levels[first_small + 1]), {},
                  push(first_small));
    ++first_small;
  }
  recorder->Run(Shader::kFillTopLevels, {1, 1}, {}, push(first_small));
  for (size_t level = first_small; level-- > 0;) {
    recorder->Run(Shader::kFillLevel, GroupsOf(levels[level]), {}, push(level));
  }
}

FrameInputs FillGuidesPass::Record(PassRecorder* recorder, const FrameInputs& inputs,
                                   const gpu::Buffer& state) {
  std::swap(progress_.now, progress_.before);
  const Held& now = progress_.now;
  const Held& before = progress_.before;
  const Kinds& kinds = progress_.kinds;
  PrepareMemory(recorder, state);
  recorder->UseBuffers({cells_, rejected_});
  const Groups pixels = GroupsFor(options_.width, options_.height);
  const Groups cells = GroupsOf(LevelsOf(options_.width, options_.height).front());
  recorder->Run(Shader::kFindKnown, cells, {});
  if (kinds.any) {
    FillPyramid(recorder, true);
    recorder->Run(Shader::kRejectGhosts, pixels, {before.depth, before.normal, before.id});
  }
  recorder->Run(Shader::kGatherKnown, cells,
                {before.depth, before.normal, before.id, now.depth, now.normal, now.id, motion_});
  const auto& b = before.colour;
  const auto& n = now.colour;
  if (kinds.colours != 0) {
    recorder->Run(Shader::kGatherKnownColours, cells,
                  {now.depth, now.normal, motion_, b[0], b[1], b[2], b[3], b[4], n[0], n[1], n[2],
                   n[3], n[4]});
  }
  FillPyramid(recorder, false);
  recorder->Run(Shader::kFillHoles, pixels, {now.normal, now.depth, now.normal, now.id});
  if (kinds.colours != 0) {
    recorder->Run(Shader::kFillHoleColours, pixels, {now.normal, n[0], n[1], n[2], n[3], n[4]});
  }
  progress_.kinds.any = true;

  FrameInputs completed = inputs;
  const auto show = [](const gpu::Image* image, ImageRef* input) {
    *input = {image->view, VK_IMAGE_LAYOUT_GENERAL};
  };
  show(now.depth, &completed.depth);
  show(now.normal, &completed.normal);
  show(motion_, &completed.motion);
  if (kinds.id) {
    show(now.id, &completed.id);
  }
  ImageRef* const colours[kGuideColours] = {&completed.albedos[0], &completed.albedos[1],
                                            &completed.albedos[2], &completed.emission,
                                            &completed.background};
  for (int k = 0; k < kGuideColours; ++k) {
    if ((kinds.colours >> k & 1u) != 0) {
      show(n[static_cast<size_t>(k)], colours[k]);
    }
  }
  return completed;
}

}  // namespace stillray::vulkan
