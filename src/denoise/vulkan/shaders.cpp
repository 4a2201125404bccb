// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/shaders.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>

/// name, stage, images read and written, buffers, bytes of push constants, use of FrameState and of
/// the partial sums
#define STILLRAY_DENOISE_SHADERS(X)                                       \
  X(MeasureLight, "demodulate", 0, 0, 0, 0, kNone, kWritten)              \
  X(UpdateExposure, "demodulate", 0, 0, 1, 8, kBoth, kBoth)               \
  X(PrepareGuides, "prepare_guides", 1, 3, 1, 0, kWritten, kNone)         \
  X(Demodulate, "demodulate", 0, 2, 0, 0, kBoth, kBoth)                   \
  X(SuppressFireflies, "suppress_fireflies", 1, 1, 0, 0, kNone, kWritten) \
  X(Reproject, "reproject", 8, 4, 0, 0, kRead, kNone)                     \
  X(UpdateCompression, "limit_history", 0, 0, 0, 4, kBoth, kRead)         \
  X(CompareHistory, "limit_history", 5, 4, 0, 0, kRead, kNone)            \
  X(MeasureChange, "limit_history", 1, 1, 0, 0, kNone, kBoth)             \
  X(CorrectHistory, "limit_history", 3, 2, 0, 0, kNone, kRead)            \
  X(LimitHistory, "limit_history", 7, 1, 0, 0, kNone, kRead)              \
  X(Accumulate, "accumulate", 7, 4, 0, 4, kRead, kNone)                   \
  X(ReprojectAccumulate, "accumulate", 10, 3, 0, 0, kRead, kNone)         \
  X(MeasureHistory, "estimate_variance", 1, 0, 0, 0, kNone, kWritten)     \
  X(UpdateMean, "estimate_variance", 0, 0, 0, 4, kBoth, kRead)            \
  X(EstimateVariance, "estimate_variance", 7, 1, 0, 0, kRead, kNone)      \
  X(SmoothVariance, "prefilter_variance", 1, 1, 0, 0, kNone, kNone)       \
  X(PrefilterVariance, "prefilter_variance", 2, 1, 0, 0, kRead, kNone)    \
  X(Atrous, "atrous", 6, 1, 0, 16, kRead, kNone)                          \
  X(AtrousTile, "atrous", 6, 1, 0, 16, kRead, kNone)                      \
  X(ClipOutliers, "clip_outliers", 1, 1, 0, 0, kNone, kNone)              \
  X(MeasureEnergy, "restore_energy", 5, 3, 0, 4, kNone, kNone)            \
  X(RestoreEnergy, "restore_energy", 5, 1, 0, 0, kNone, kNone)            \
  X(MeasureMirrors, "keep_mirrors", 3, 1, 0, 0, kNone, kNone)             \
  X(MeasureSamples, "keep_samples", 5, 1, 0, 0, kNone, kNone)             \
  X(KeepSamples, "keep_samples", 3, 1, 0, 0, kNone, kNone)                \
  X(Remodulate, "remodulate", 1, 1, 0, 4, kBoth, kNone)                   \
  X(Fxaa, "fxaa", 2, 1, 0, 0, kNone, kNone)                               \
  X(FollowLight, "antialias", 4, 2, 0, 4, kRead, kNone)                   \
  X(FollowChange, "antialias", 3, 1, 0, 0, kNone, kNone)                  \
  X(SumAlbedo, "antialias", 0, 2, 0, 0, kNone, kNone)                     \
  X(SplineCoefficients, "antialias", 1, 1, 0, 0, kNone, kNone)            \
  X(Antialias, "antialias", 12, 2, 0, 4, kRead, kNone)                    \
  X(Tonemap, "tonemap", 1, 0, 0, 0, kRead, kNone)                         \
  X(ResampleGuides, "resample", 4, 4, 0, 8, kNone, kNone)                 \
  X(ResampleHistory, "resample", 5, 4, 0, 8, kNone, kNone)                \
  X(StoreSignal, "remodulate", 1, 2, 0, 4, kRead, kNone)                  \
  X(FindKnown, "fill_guides", 0, 0, 1, 0, kWritten, kNone)                \
  X(RejectGhosts, "fill_guides", 3, 0, 2, 0, kRead, kNone)                \
  X(DownsampleLevel, "fill_guides", 0, 0, 1, 16, kRead, kNone)            \
  X(FillTopLevels, "fill_guides", 0, 0, 1, 16, kRead, kNone)              \
  X(FillLevel, "fill_guides", 0, 0, 1, 16, kRead, kNone)                  \
  X(GatherKnown, "fill_guides", 3, 4, 2, 0, kRead, kNone)                 \
  X(GatherKnownColours, "fill_guides", 8, 5, 1, 0, kRead, kNone)          \
  X(FillHoles, "fill_guides", 1, 3, 1, 0, kNone, kNone)                   \
  X(FillHoleColours, "fill_guides", 1, 5, 1, 0, kNone, kNone)             \
  X(ShortenHistory, "shorten_history", 3, 2, 0, 4, kRead, kNone)          \
  X(MergeFuture, "merge_future", 4, 2, 0, 0, kRead, kNone)

/// Shaders that write surfaces; their code depends on the format of normals.
#define STILLRAY_SURFACE_WRITERS(X) \
  X(PrepareGuides)                  \
  X(ResampleGuides)                 \
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
  using enum Use;
#define STILLRAY_SHADER_INFO_(name, stage, reads, writes, buffers, push, state, partials) \
  {stage, reads, writes, buffers, push, state, partials},
  static constexpr ShaderInfo kInfo[] = {STILLRAY_DENOISE_SHADERS(STILLRAY_SHADER_INFO_)};
  return kInfo[static_cast<size_t>(shader)];
}

#define STILLRAY_SHADER_NAME_(name, ...) #name,
static constexpr const char* kNamesOfShaders[] = {STILLRAY_DENOISE_SHADERS(STILLRAY_SHADER_NAME_)};

size_t ShaderCount() {
  return std::size(kNamesOfShaders);
}

const char* NameOf(Shader shader) {
  return kNamesOfShaders[static_cast<size_t>(shader)];
}

namespace {

/// The code of a shader for the format of normals that is not the default of the storage; empty:
/// use the default code.
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
  // On software drivers, compiling loops of known length costs more time than these loops save.
  const bool known =
      !context_->is_software || shader == Shader::kAtrous || shader == Shader::kAtrousTile;
  std::vector<uint32_t> all = {octahedral_ ? 1u : 0u, known ? static_cast<uint32_t>(signals_) : 0u};
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
