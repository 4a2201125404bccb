// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a Denoiser is inside. denoiser.cpp has the order of the stages, signal_pipeline.cpp those
/// that run for each signal, wavelet_pipeline.cpp the levels.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "denoise/denoiser_state.h"
#include "denoise/signal_groups.h"
#include "denoise/stage_table.h"
#include "stillray/denoise.hpp"

namespace stillray {

void CopyImage(const Image3& from, Image3* to);

/// Whether history is kept twice, with and without the last feedback.
inline bool BlendsFeedback(const Settings& s) {
  return s.temporal && s.feedback > 0 && s.wavelet != Wavelet::kOff &&
         s.feedback_when == FeedbackWhen::kBlend;
}

/// Frames of one cycle add up to one sample per pixel but for rounding.
inline constexpr float kWholeSample = 1.0f - 1e-4f;

struct FutureLight::Impl {
  std::vector<SignalHistory> signals;
};

/// One signal on its way through the wavelet.
struct WaveletPlanes {
  FilterPlanes filter[2];
  Image1 stop;  ///< empty where nobody needs it; before the wavelet: what limit_history allows
  Image1 present;
  Image1 grown;                ///< `present` of the next level; empty until there is a sparse frame
  int target = 0;              ///< which of `filter` the next level writes to
  Image3* light = nullptr;     ///< what the next level reads, or the result
  Image1* variance = nullptr;  ///< of it
  const Image1* where = nullptr;  ///< positive where there is light on a surface
  bool complete = false;          ///< `present` is 1 on every surface
  bool has_variance = false;      ///< of this frame, but for the blocks that are `open`
  Plane<uint32_t> open;           ///< see VarianceOnTheWay
  float mean_luminance = 1;
  SignalHistory* history = nullptr;  ///< where the light came from

  WaveletPlanes() = default;
  WaveletPlanes(int width, int height, int border)
      : filter{{width, height, border}, {width, height, border}},
        present(width, height, border),
        open(BlocksOf(width), height) {}
  size_t bytes() const {
    return filter[0].bytes() + filter[1].bytes() + stop.bytes() + present.bytes() + grown.bytes() +
           open.bytes();
  }
};

struct Denoiser::Impl {
  Settings settings;
  const StageTable* stages = &kCpuStages;
  std::vector<std::string> outputs;
  Results results;
  DenoiserState state;
  bool has_result = false;      ///< state.picture is that of the last frame
  bool is_handed_over = false;  ///< the caller has the picture of the frame in progress

  // Work planes, kept between frames so that nothing is allocated in the steady state.
  ReprojectionTaps taps;
  std::vector<NewLight> light;  ///< of every signal
  SignalHistory fetched;        ///< looked up for this frame's pixels, or room for the next history
  StagedHistory staged;
  bool fetched_is_empty = false;       ///< no light in it anywhere
  std::vector<SignalHistory> merged;   ///< with the future; empty until there is one
  std::vector<WaveletPlanes> wavelet;  ///< of every signal
  Image3 scratch;
  Image1 firefly_work;       ///< empty unless fireflies are clamped
  FilterPlanes mirror_work;  ///< empty until there is a mirror
  Image3 picture;

  FillGuidesWork fill_guides_work;
  Frame from_device;  ///< a frame that lies on a device, on the host; empty until there is one
  Frame completed;    ///< a frame with all guides; empty until one comes without

  int border = 0;  ///< of what the wavelet reads; never shrinks, so that nothing is made anew

  // The frame in progress. Guides, emission and background are the frame's own or completed.
  const Guides* guides = nullptr;
  const Image3* emission = nullptr;
  const Image3* background = nullptr;
  float samples_per_pixel = 1;
  float negative_limit = 0;    ///< light that is less negative is zero
  float feedback_phase = 1;    ///< weight of history with the last feedback in what is filtered
  bool feeds_back = false;     ///< whether this frame's filtered light becomes history
  bool was_fed_back = true;    ///< whether the last frame's did, or may have
  bool merges_future = false;  ///< whether light of the future joins what is accumulated
  std::vector<SignalGroup> groups;  ///< of frames with or without transmission, as it says
  bool groups_have_transmission = false;
  SignalGrouping grouping = SignalGrouping::kSplit;
  std::vector<double> row_sums;
  std::array<SignalLight, kMostGroups> filtered;
  std::array<const Image3*, 2> unfiltered = {};
  PictureParts parts;  ///< of `filtered` and `unfiltered`
  const Frame* frame = nullptr;
  DenoisedFrame* out = nullptr;

  void Allocate(int width, int height, size_t groups);
  /// The frame with what stands for guides that it does not have; itself if it has all.
  const Frame& Complete(const Frame& given);
  /// Looks up the history of every pixel: everything that comes before the signals.
  Status Begin(const Frame& next_frame, DenoisedFrame* result);
  /// Brings the new light of all signals into their histories. \param then  is called for each
  template <typename Then>
  void GatherSignals(const Then& then);
  /// Leaves the new light of a signal in `light`.
  void GatherLight(size_t signal);
  /// What the histories may count for, in WaveletPlanes::stop.
  void RunLimitHistory();
  const Image1* LimitOf(size_t signal) const { return Limits() ? &wavelet[signal].stop : nullptr; }
  void RunAccumulate(size_t signal);
  void AccumulateRadiance(size_t signal, const AccumulateParameters& p);
  SignalHistory ShortenedHistory(size_t signal) const;
  SignalHistory* MergeFuture(size_t signal, const FutureLight& future);
  /// Leaves the accumulated light in `wavelet`, ...
  void BeginFilter(size_t signal, SignalHistory* history);
  /// ... and the variances of all signals.
  void RunEstimateVariance();
  EstimateVarianceParameters VarianceParameters() const;
  void FindPresent(WaveletPlanes* planes) const;
  SignalHistory EmptyHistory() const {
    return SignalHistory(state.width, state.height, settings.limit_history,
                         BlendsFeedback(settings), border);
  }
  /// Runs all levels.
  void FilterSignals();
  /// Gives back samples of mirrors that the filter made worse.
  void RunKeepMirrors();
  void KeepMirrors(size_t signal);
  Image3* FinishedLight(size_t signal);
  AtrousParameters GeometryLevel(int level) const;
  /// Whether mirrors are looked for, so that the new light is needed to the end.
  bool MayKeepMirrors() const {
    return settings.mirror_roughness > 0 && !frame->guides.roughness.empty();
  }
  /// What the picture is put together from: filtered and unfiltered light.
  void FindPictureParts();
  /// Whether nobody but antialiasing wants the picture, which then is kept nowhere.
  bool ComposesOnTheWay() const;
  void ComposePicture();
  /// The light that makes up a signal; makes room for what becomes of it.
  DemodulateInput RadianceOf(const SignalGroup& group, NewLight* to) const;
  void Count(const DemodulateCounts& counts);
  /// Whether little of the history lies at other pixels, so that it is changed where it is.
  bool ChangesInPlace() const;
  /// Whether nobody looks at the new light before it joins the history.
  bool JoinsOnTheWay() const;
  void UpdateCompressionScale(size_t signal);
  PrefilterVarianceParameters PrefilterOf() const;
  AtrousParameters LevelParameters(int level) const;
  AtrousSignal LevelSignal(size_t signal, int level);
  void RunLevel(int level);
  void FinishLevel(const AtrousSignal& signal, WaveletPlanes* planes);
  void KeepLevel(int level);
  void AdvanceFeedback();
  bool HasFxaa() const {
    return settings.fxaa == Fxaa::kOn || (settings.fxaa == Fxaa::kSparse && IsSparse());
  }
  void RunFxaa();
  void RunAntialias();
  void HandOver();
  /// Where the caller gets the finished picture; nullptr where he does not want it.
  Image3* Result();
  AlbedoSum Albedos(const SignalGroup& group) const;
  void AddSignal(const SignalGroup& group, const Image3& light_in, Image3* sum);

  /// Whether the frame in progress has less than one sample per pixel.
  bool IsSparse() const { return samples_per_pixel < kWholeSample; }
  bool HasHistory() const { return settings.temporal && state.has_history; }
  bool Limits() const { return settings.limit_history && HasHistory(); }
  bool Rec601() const { return settings.luminance == LuminanceWeights::kRec601; }
  bool Wants(const std::string& name) const {
    return std::find(outputs.begin(), outputs.end(), name) != outputs.end();
  }
  /// Mean over the picture of what `sum_of_row(y)` adds up, in double precision and one order.
  template <typename SumOfRow>
  double Mean(const SumOfRow& sum_of_row);
  float MeanLuminance(const Image3& light);
  /// The composite picture called `name` among the outputs, made on first use.
  Image3* Composite(const std::string& name);
  void KeepPlane(const char* kind, const SignalGroup& group, const Image1& plane);
  void KeepImage(const char* kind, const SignalGroup& group, const Image3& image);
  size_t WorkBytes() const;

  // Composites of several signals while a frame is in progress.
  std::vector<std::pair<std::string, Image3>> composites;
};

template <typename SumOfRow>
double Denoiser::Impl::Mean(const SumOfRow& sum_of_row) {
  row_sums.resize(static_cast<size_t>(state.height));
  ParallelRows(state.height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      row_sums[static_cast<size_t>(y)] = sum_of_row(y);
    }
  });
  double total = 0;
  for (const double sum : row_sums) {
    total += sum;
  }
  return total / (static_cast<double>(state.width) * state.height);
}

template <typename Then>
void Denoiser::Impl::GatherSignals(const Then& then) {
  const bool together = Limits();
  for (size_t i = 0; together && i < groups.size(); ++i) {
    GatherLight(i);
  }
  if (together) {
    RunLimitHistory();
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    if (!together && !JoinsOnTheWay()) {
      GatherLight(i);
    }
    then(i);
  }
}

}  // namespace stillray
