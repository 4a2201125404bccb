// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/shaders.h"

#include <algorithm>
#include <array>
#include <memory>

/// name, stage, images read and written, buffers, bytes of push constants
#define STILLRAY_DENOISE_SHADERS(X)                      \
  X(MeasureLight, "demodulate", 0, 0, 0, 0)              \
  X(UpdateExposure, "demodulate", 0, 0, 0, 4)            \
  X(PrepareGuides, "prepare_guides", 0, 2, 0, 0)         \
  X(Demodulate, "demodulate", 0, 2, 0, 0)                \
  X(SuppressFireflies, "suppress_fireflies", 1, 1, 0, 0) \
  X(Reproject, "reproject", 8, 4, 0, 0)                  \
  X(UpdateCompression, "limit_history", 0, 0, 0, 4)      \
  X(CompareHistory, "limit_history", 5, 4, 0, 0)         \
  X(CorrectHistory, "limit_history", 2, 2, 0, 0)         \
  X(LimitHistory, "limit_history", 6, 1, 0, 0)           \
  X(Accumulate, "accumulate", 7, 4, 0, 4)                \
  X(MeasureHistory, "estimate_variance", 1, 0, 0, 0)     \
  X(UpdateMean, "estimate_variance", 0, 0, 0, 4)         \
  X(EstimateVariance, "estimate_variance", 6, 1, 0, 0)   \
  X(SmoothVariance, "prefilter_variance", 1, 1, 0, 0)    \
  X(PrefilterVariance, "prefilter_variance", 2, 1, 0, 0) \
  X(MixPilot, "pilot", 3, 1, 0, 4)                       \
  X(Atrous, "atrous", 5, 1, 0, 12)                       \
  X(AtrousTile, "atrous", 5, 1, 0, 12)                   \
  X(ClipOutliers, "clip_outliers", 1, 1, 0, 0)           \
  X(MeasureEnergy, "restore_energy", 5, 3, 0, 4)         \
  X(RestoreEnergy, "restore_energy", 5, 1, 0, 0)         \
  X(MeasureMirrors, "keep_mirrors", 3, 1, 0, 0)          \
  X(MeasureSamples, "keep_samples", 5, 1, 0, 0)          \
  X(KeepSamples, "keep_samples", 3, 1, 0, 0)             \
  X(Remodulate, "remodulate", 1, 1, 0, 4)                \
  X(Fxaa, "fxaa", 2, 1, 0, 0)                            \
  X(FollowLight, "antialias", 4, 2, 0, 4)                \
  X(FollowChange, "antialias", 3, 1, 0, 0)               \
  X(SplineCoefficients, "antialias", 1, 1, 0, 0)         \
  X(Antialias, "antialias", 7, 1, 0, 0)                  \
  X(Tonemap, "tonemap", 1, 0, 0, 0)                      \
  X(FindKnown, "fill_guides", 0, 0, 1, 0)                \
  X(RejectGhosts, "fill_guides", 3, 0, 2, 0)             \
  X(DownsampleLevel, "fill_guides", 0, 0, 1, 16)         \
  X(FillTopLevels, "fill_guides", 0, 0, 1, 16)           \
  X(FillLevel, "fill_guides", 0, 0, 1, 16)               \
  X(GatherKnown, "fill_guides", 3, 4, 2, 0)              \
  X(GatherKnownColours, "fill_guides", 8, 5, 1, 0)       \
  X(FillHoles, "fill_guides", 1, 3, 1, 0)                \
  X(FillHoleColours, "fill_guides", 1, 5, 1, 0)          \
  X(ShortenHistory, "shorten_history", 3, 2, 0, 4)       \
  X(MergeFuture, "merge_future", 4, 2, 0, 0)

/// Those that write surfaces: their code depends on the format of normals.
#define STILLRAY_SURFACE_WRITERS(X) \
  X(PrepareGuides)                  \
  X(CompareHistory)                 \
  X(MeasureEnergy)

namespace stillray::vulkan {

namespace shaders {
#define STILLRAY_DECLARE_SHADER_(name, ...)    \
  extern const std::uint32_t k##name##Half[];  \
  extern const std::size_t k##name##HalfWords; \
  extern const std::uint32_t k##name##Float[]; \
  extern const std::size_t k##name##FloatWords;
STILLRAY_DENOISE_SHADERS(STILLRAY_DECLARE_SHADER_)
#define STILLRAY_DECLARE_WRITER_(name)                   \
  extern const std::uint32_t k##name##HalfPlain[];       \
  extern const std::size_t k##name##HalfPlainWords;      \
  extern const std::uint32_t k##name##FloatOctahedral[]; \
  extern const std::size_t k##name##FloatOctahedralWords;
STILLRAY_SURFACE_WRITERS(STILLRAY_DECLARE_WRITER_)
}  // namespace shaders

const ShaderInfo& InfoOf(Shader shader) {
#define STILLRAY_SHADER_INFO_(name, stage, reads, writes, buffers, push) \
  {stage, reads, writes, buffers, push},
  static constexpr ShaderInfo kInfo[] = {STILLRAY_DENOISE_SHADERS(STILLRAY_SHADER_INFO_)};
  return kInfo[static_cast<size_t>(shader)];
}

namespace {

/// The code of a shader for normals that are unusual with the storage; empty: its usual code.
std::span<const uint32_t> CodeForOtherNormals(Shader shader, Storage storage) {
  using Code = std::span<const uint32_t>;
  switch (shader) {
#define STILLRAY_WRITER_CODE_(name)                                                  \
  case Shader::k##name:                                                              \
    return storage == Storage::kHalf                                                 \
               ? Code(shaders::k##name##HalfPlain, shaders::k##name##HalfPlainWords) \
               : Code(shaders::k##name##FloatOctahedral, shaders::k##name##FloatOctahedralWords);
    STILLRAY_SURFACE_WRITERS(STILLRAY_WRITER_CODE_)
    default:
      return {};
  }
}

}  // namespace

std::span<const uint32_t> CodeOf(Shader shader, Storage storage, bool octahedral) {
  using Code = std::span<const uint32_t>;
  if (octahedral != PacksNormalsByDefault(storage)) {
    const Code other = CodeForOtherNormals(shader, storage);
    if (!other.empty()) {
      return other;
    }
  }
#define STILLRAY_SHADER_CODE_(name, ...)                      \
  {Code(shaders::k##name##Half, shaders::k##name##HalfWords), \
   Code(shaders::k##name##Float, shaders::k##name##FloatWords)},
  const std::array<Code, 2> code[] = {STILLRAY_DENOISE_SHADERS(STILLRAY_SHADER_CODE_)};
  return code[static_cast<size_t>(shader)][storage == Storage::kHalf ? 0 : 1];
}

Result<const gpu::Pipeline*> Pipelines::Find(Shader shader, std::span<const uint32_t> constants) {
  for (const std::unique_ptr<Entry>& entry : entries_) {
    if (entry->shader == shader && std::ranges::equal(entry->constants, constants)) {
      return &entry->pipeline;
    }
  }
  const ShaderInfo& info = InfoOf(shader);
  const Result<VkDescriptorSetLayout> frame = sets_->Layout(kFrameSet);
  if (!frame.ok()) {
    return frame.status();
  }
  const Result<VkDescriptorSetLayout> own = sets_->Layout(OwnSet(info));
  if (!own.ok()) {
    return own.status();
  }
  const VkDescriptorSetLayout layouts[] = {*frame, *own};
  std::vector<uint32_t> all = {octahedral_ ? 1u : 0u};
  all.insert(all.end(), constants.begin(), constants.end());
  Result<gpu::Pipeline> made = gpu::Pipeline::Create(
      context_, {info.stage, CodeOf(shader, storage_, octahedral_), layouts, info.push_bytes, all});
  if (!made.ok()) {
    return made.status();
  }
  entries_.push_back(std::make_unique<Entry>(
      Entry{shader, {constants.begin(), constants.end()}, std::move(made.value())}));
  return &entries_.back()->pipeline;
}

}  // namespace stillray::vulkan
