// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The passes of FramePipeline from estimate_variance to keep_mirrors, and the pipelines of the
// wavelet.
#include <array>
#include <numeric>
#include <utility>

#include "denoise/level_names.h"
#include "denoise/stages/keep_samples.h"
#include "denoise/stages/limit_history.h"
#include "denoise/vulkan/frame_pipeline.h"

namespace stillray::vulkan {
namespace {

/// The name of a level's sums of weights, for the observer.
const char* WeightsName(int level) {
  static constexpr const char* kNames[kMaxLevels] = {"weights1", "weights2", "weights3",
                                                     "weights4", "weights5", "weights6",
                                                     "weights7", "weights8"};
  return kNames[level];
}

/// STILLRAY_ATROUS_... of the settings.
uint32_t EdgeKindsOf(const Settings& s) {
  return (s.curvature > 0 ? STILLRAY_ATROUS_CURVED : 0u) |
         (s.depth_weight == DepthWeight::kPlane ? STILLRAY_ATROUS_PLANES : 0u) |
         (s.depth_weight == DepthWeight::kPosition ? STILLRAY_ATROUS_POSITIONS : 0u) |
         (s.wavelet_id ? STILLRAY_ATROUS_IDS : 0u);
}

int TileResidues(int step) {
  return std::gcd(step, kMostTileResidues);
}

/// The shader variant, from the last constant: the step of tiles, or 0.
Shader AtrousShader(std::span<const uint32_t> constants) {
  return constants.back() != 0 ? Shader::kAtrousTile : Shader::kAtrous;
}

}  // namespace

std::array<uint32_t, 7> FramePipeline::AtrousConstants(const AtrousLevel& level, int pilot_signals,
                                                       bool compared, int output) const {
  return {static_cast<uint32_t>(level.weights),
          static_cast<uint32_t>(level.radius),
          static_cast<uint32_t>(pilot_signals),
          compared ? 1u : 0u,
          static_cast<uint32_t>(output),
          compared ? uint32_t{STILLRAY_ATROUS_PLANES} : edge_kinds_,
          static_cast<uint32_t>(uses_tiles_ ? level.step : 0)};
}

/// Creates the pipelines of all levels, which differ in their weights and in the tiles of their
/// steps.
Status FramePipeline::MakeAtrousPipelines(const Settings& settings) {
  edge_kinds_ = EdgeKindsOf(settings);
  std::array<AtrousLevel, kMaxLevels> levels;
  const int count = ListLevels(settings, &levels);
  // Signals of several kinds may have only smooth radiance in some frames.
  constexpr uint32_t kAllLights = (1u << kSignalKindCount) - 1;
  constexpr uint32_t kSmoothLight = 1u << static_cast<uint32_t>(SignalKind::kIndirectDiffuse);
  const std::array<int, kPilotLevels> pilots[] = {PilotSignals(settings, groups_, kAllLights),
                                                  PilotSignals(settings, groups_, kSmoothLight)};
  for (int level = 0; level < count; ++level) {
    const AtrousLevel& of_level = levels[static_cast<size_t>(level)];
    STILLRAY_RETURN_IF_ERROR(MakeAtrous(AtrousConstants(of_level)));
    if (level < kPilotLevels) {
      for (const std::array<int, kPilotLevels>& of_lights : pilots) {
        STILLRAY_RETURN_IF_ERROR(
            MakeAtrous(AtrousConstants(of_level, of_lights[static_cast<size_t>(level)])));
      }
      STILLRAY_RETURN_IF_ERROR(
          MakeAtrous(AtrousConstants(PilotLevel(level), 0, false, kAtrousPilot)));
    }
  }
  for (int level = 0; level < kCorrectHistoryLevels; ++level) {
    STILLRAY_RETURN_IF_ERROR(MakeAtrous(AtrousConstants(ComparedLevel(level), 0, true)));
  }
  if (settings.limit_history && settings.correct_history) {
    STILLRAY_RETURN_IF_ERROR(MakeAtrous(AtrousConstants(kWideLevel, 0, true)));
  }
  for (int level = 0; level < kKeepSamplesLevels; ++level) {
    STILLRAY_RETURN_IF_ERROR(MakeAtrous(AtrousConstants(GeometryLevel(level))));
  }
  return Status::Ok();
}

Status FramePipeline::MakeAtrous(std::span<const uint32_t> constants) {
  return pipelines_->Find(AtrousShader(constants), constants).status();
}

void FramePipeline::RunAtrous(int width, int height,
                              std::initializer_list<const gpu::Image*> images,
                              const LevelPush& push, std::span<const uint32_t> constants,
                              PassRecorder* recorder) {
  Groups groups = GroupsFor(width, height);
  const Shader shader = AtrousShader(constants);
  if (shader == Shader::kAtrousTile) {
    // Some neighbouring residue classes (modulo the step) share a workgroup.
    const int residues = TileResidues(push.step);
    groups = GroupsFor((width + push.step - 1) / push.step * residues,
                       (height + push.step - 1) / push.step);
    groups.x *= static_cast<uint32_t>(push.step / residues);
    groups.y *= static_cast<uint32_t>(push.step);
  }
  recorder->Run(shader, groups, images, push, constants);
}

void FramePipeline::BeginFilter(const FramePlan& plan, PassRecorder* recorder) {
  const FrameImages& i = images_;
  if (plan.runs.measure_luminance) {
    recorder->Run(Shader::kMeasureHistory, grid_, {known_.colour});
    recorder->Run(Shader::kUpdateMean, {1, 1}, {}, grid_.count());
  }
  recorder->Run(Shader::kEstimateVariance, grid_,
                {i.guides.surface, i.guides.detail, i.noisy, known_.colour, known_.behind,
                 known_.moments, i.turn2, i.wavelet[0]});
  Keep(recorder, "variance", i.wavelet[0]);
  light_ = i.wavelet[0];
}

/// Computes the pilot estimate (see cpu/wavelet.cpp) in the image of the fetched history, which is
/// no longer read.
const gpu::Image* FramePipeline::RunPilot(int level, int signals, PassRecorder* recorder) {
  const FrameImages& i = images_;
  const LevelPush push = {PilotLevel(level).step, 0, 1, signals};
  recorder->CountAs("pilot");
  RunAtrous(shape_.width, shape_.height,
            {i.guides.surface, i.guides.detail, light_, i.luminance_factor, known_.moments, i.turn2,
             i.fetched.colour},
            push, AtrousConstants(PilotLevel(level), 0, false, kAtrousPilot), recorder);
  return i.fetched.colour;
}

void FramePipeline::RunLevels(const FramePlan& plan, PassRecorder* recorder) {
  if (plan.restore_energy.energy_signals != 0) {
    BeginEnergy(recorder);
  }
  int target = 1;
  if (plan.runs.smooth_variance) {
    recorder->Run(Shader::kSmoothVariance, grid_, {light_, images_.wavelet[target]});
    light_ = images_.wavelet[target];
    target ^= 1;
  }
  for (int level = 0; level < plan.levels; ++level) {
    const int with_pilot =
        level < kPilotLevels ? plan.pilot_signals[static_cast<size_t>(level)] : 0;
    const gpu::Image* pilot =
        with_pilot != 0 ? RunPilot(level, with_pilot, recorder) : images_.nothing;
    if (plan.runs.estimate_variance) {
      recorder->Run(Shader::kPrefilterVariance, grid_,
                    {with_pilot != 0 ? pilot : light_, known_.moments, images_.luminance_factor});
    }
    const AtrousLevel& of_level = plan.level[static_cast<size_t>(level)];
    const LevelPush push = {of_level.step, level, 0};
    if (observer_ != nullptr && observer_->Wants(WeightsName(level))) {
      RunAtrous(shape_.width, shape_.height,
                {images_.guides.surface, images_.guides.detail, light_, images_.luminance_factor,
                 pilot, images_.turn2, images_.wavelet[target]},
                push, AtrousConstants(of_level, with_pilot, false, kAtrousSums), recorder);
      Keep(recorder, WeightsName(level), images_.wavelet[target]);
    }
    recorder->CountAs(LevelName(level));
    RunAtrous(shape_.width, shape_.height,
              {images_.guides.surface, images_.guides.detail, light_, images_.luminance_factor,
               pilot, images_.turn2, images_.wavelet[target]},
              push, AtrousConstants(of_level, with_pilot), recorder);
    light_ = images_.wavelet[target];
    if (plan.feedback_level == level + 1) {
      if (shape_.with_behind) {
        std::swap(images_.history.colour, images_.history.behind);
      }
      // The old history's image is now free for another level.
      std::swap(images_.history.colour, images_.wavelet[target]);
    }
    target ^= 1;
    KeepPicture(recorder, LevelName(level), light_);
  }
  if (plan.runs.clip_outliers) {
    recorder->Run(Shader::kClipOutliers, grid_, {light_, images_.wavelet[target]});
    light_ = images_.wavelet[target];
    target ^= 1;
  }
  Keep(recorder, "wavelet", light_);
  if (plan.restore_energy.energy_signals != 0) {
    RestoreEnergy(images_.wavelet[target], recorder);
  }
}

/// Computes the block means of the accumulated signals, before the wavelet, in the second image of
/// the coarse grid.
void FramePipeline::BeginEnergy(PassRecorder* recorder) {
  const FrameImages& i = images_;
  recorder->Run(Shader::kMeasureEnergy, CoarseGrid(),
                {i.guides.surface, i.guides.detail, known_.moments, light_, i.nothing,
                 i.coarse.surface, i.coarse.detail, i.compared[1]},
                int32_t{0});
}

/// See stages/restore_energy.h. \param out  an image that is no longer read; receives the filtered
/// signals
void FramePipeline::RestoreEnergy(const gpu::Image* out, PassRecorder* recorder) {
  const FrameImages& i = images_;
  recorder->Run(Shader::kMeasureEnergy, CoarseGrid(),
                {i.guides.surface, i.guides.detail, known_.moments, light_, i.compared[1],
                 i.coarse.surface, i.coarse.detail, i.compared[0]},
                int32_t{1});
  static_assert(kCorrectHistoryLevels % 2 == 1, "the result lies in the second image");
  RunComparedLevels("restore_energy", kCorrectHistoryLevels, recorder);
  recorder->Run(Shader::kRestoreEnergy, grid_,
                {i.guides.surface, i.guides.detail, i.coarse.surface, i.compared[1], light_, out});
  light_ = out;
}

/// See stages/keep_mirrors.h.
void FramePipeline::KeepMirrors(PassRecorder* recorder) {
  const FrameImages& i = images_;
  recorder->Run(Shader::kMeasureMirrors, grid_,
                {i.guides.surface, i.noisy, light_, SampleSquares()});
  BlendSamples("keep_mirrors", recorder);
}

/// See stages/keep_samples.h.
void FramePipeline::KeepSamples(PassRecorder* recorder) {
  const FrameImages& i = images_;
  recorder->Run(Shader::kMeasureSamples, grid_,
                {i.guides.surface, i.noisy, i.within, known_.moments, light_, SampleSquares()});
  BlendSamples("keep_samples", recorder);
}

/// The image of squares for BlendSamples: an image of the fetched history or of the wavelet that is
/// no longer read.
const gpu::Image* FramePipeline::SampleSquares() const {
  return light_ == images_.fetched.colour ? images_.wavelet[1] : images_.fetched.colour;
}

/// Runs the levels of keep_samples or keep_mirrors, and the blend.
void FramePipeline::BlendSamples(const char* stage, PassRecorder* recorder) {
  const FrameImages& i = images_;
  const gpu::Image* measured = SampleSquares();
  const gpu::Image* other = light_ == i.wavelet[0] ? i.wavelet[1] : i.wavelet[0];
  for (int level = 0; level < kKeepSamplesLevels; ++level) {
    const auto constants = AtrousConstants(GeometryLevel(level));
    const LevelPush push = {GeometryLevel(level).step, level, 0};
    recorder->CountAs(stage);
    RunAtrous(shape_.width, shape_.height,
              {i.guides.surface, i.guides.detail, measured, i.luminance_factor, i.nothing, i.turn2,
               other},
              push, constants, recorder);
    std::swap(measured, other);
  }
  recorder->CountAs(stage);
  recorder->Run(Shader::kKeepSamples, grid_, {i.noisy, light_, measured, other});
  light_ = other;
}

}  // namespace stillray::vulkan
