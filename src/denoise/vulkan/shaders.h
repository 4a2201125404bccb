// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The compute shaders of the denoiser: their resources and their code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/pipeline.h"

namespace stillray::vulkan {

/// Storage format of radiance between stages.
enum class Storage : uint8_t {
  kHalf,   ///< 16 bits, with an exposure that adapts to the mean radiance
  kFloat,  ///< 32 bits: the precision of the CPU, twice the memory
};

/// Whether normals=auto keeps octahedral normals.
inline bool PacksNormalsByDefault(Storage storage) {
  return storage == Storage::kHalf;
}

enum class Shader : uint8_t {
  kMeasureLight,
  kUpdateExposure,
  kPrepareGuides,
  kDemodulate,
  kSuppressFireflies,
  kReproject,
  kUpdateCompression,
  kCompareHistory,
  kMeasureChange,
  kCorrectHistory,
  kLimitHistory,
  kAccumulate,
  kReprojectAccumulate,
  kMeasureHistory,
  kUpdateMean,
  kEstimateVariance,
  kSmoothVariance,
  kPrefilterVariance,
  kAtrous,
  kAtrousTile,  ///< kAtrous by tiles in shared memory, with equal results
  kClipOutliers,
  kMeasureEnergy,
  kRestoreEnergy,
  kMeasureMirrors,
  kMeasureSamples,
  kKeepSamples,
  kRemodulate,
  kFxaa,
  kFollowLight,
  kFollowChange,
  kSumAlbedo,
  kSplineCoefficients,
  kAntialias,
  kTonemap,
  kResampleGuides,
  kResampleHistory,
  kStoreSignal,
  // Of fill_guides; created only if guides may be incomplete:
  kFindKnown,
  kRejectGhosts,
  kDownsampleLevel,
  kFillTopLevels,
  kFillLevel,
  kGatherKnown,
  kGatherKnownColours,
  kFillHoles,
  kFillHoleColours,
  // Of sequences with later frames (merge_future); created on first use:
  kShortenHistory,
  kMergeFuture,
};

/// How a shader uses a buffer of the frame; atomic operations write.
enum class Use { kNone, kRead, kWritten, kBoth };
inline bool Reads(Use use) {
  return use == Use::kRead || use == Use::kBoth;
}
inline bool Writes(Use use) {
  return use == Use::kWritten || use == Use::kBoth;
}

/// The resources of a shader's second descriptor set, in the order of its bindings, and its use of
/// the shared buffers of the first set.
struct ShaderInfo {
  const char* stage;    ///< stage name in timings, as on the CPU
  uint32_t reads;       ///< sampled images
  uint32_t writes;      ///< storage images
  uint32_t buffers;     ///< storage buffers, read and written
  uint32_t push_bytes;  ///< size of its push constants
  Use state;            ///< FrameState
  Use partials;         ///< sums of workgroups, and the histogram
};

inline gpu::SetShape OwnSet(const ShaderInfo& info) {
  return {info.reads, info.writes, 0, info.buffers};
}

const ShaderInfo& InfoOf(Shader shader);
/// Number of values of Shader.
size_t ShaderCount();
/// The name of a shader: "Atrous".
const char* NameOf(Shader shader);
/// \param octahedral  whether surface normals are stored by PackNormal
std::span<const uint32_t> CodeOf(Shader shader, Storage storage, bool octahedral);

/// Set 0, common to all shaders: inputs of the frame, outputs, parameters, state, partial sums.
inline constexpr gpu::SetShape kFrameSet = {25, 3, 1, 2};

/// Descriptor set layouts and pipelines, created on first use.
class Pipelines {
 public:
  Pipelines(const gpu::DeviceContext* context, Storage storage, bool octahedral, int signals,
            gpu::DescriptorSets* sets)
      : context_(context),
        storage_(storage),
        octahedral_(octahedral),
        signals_(signals),
        sets_(sets) {}

  /// \param constants  specialisation constants of the shader, from 2 on; 0 and 1 belong to
  ///     common.glsl
  Result<const gpu::Pipeline*> Find(Shader shader, std::span<const uint32_t> constants = {});

 private:
  struct Entry {
    Shader shader;
    std::vector<uint32_t> constants;
    gpu::Pipeline pipeline;
  };
  const gpu::DeviceContext* context_;
  Storage storage_;
  bool octahedral_;
  int signals_;
  gpu::DescriptorSets* sets_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace stillray::vulkan
