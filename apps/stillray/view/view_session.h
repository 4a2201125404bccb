// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A view of one scene: settings in, the next picture out. No clock, no window: the same calls give
/// the same bits (as long as the rate is fixed), on one device or on two.
#pragma once

#include <memory>
#include <optional>

#include "common/render_devices.h"
#include "stillray/denoise.hpp"
#include "view/loaded_scene.h"
#include "view/rate_control.h"
#include "view/reference.h"
#include "view/retimed_animation.h"
#include "view/shown_frame.h"
#include "view/tracing.h"
#include "view/view_frame.h"
#include "view/view_settings.h"

namespace stillray::view {

class ViewSession {
 public:
  /// \param devices  the first one filters frames; if it fails, the CPU continues
  ///     (ViewFrame::note). The loaded renderer traces, on the second one, and falls back by
  ///     itself. If they differ, the next frame is traced while one is filtered, on another thread:
  ///     with the same settings, or with others in the pose alone while the view moves, RenderNext
  ///     then waits for it; else it is discarded
  explicit ViewSession(LoadedScene loaded, const RenderDevices& devices = {});
  ~ViewSession();
  ViewSession(ViewSession&&) noexcept;

  /// Renders, denoises and converts the next frame to pictures.
  /// \param elapsed     seconds since the last frame, for animations in real time
  /// \param keep_going  returns false to cancel the frame
  /// \return kCancelled (the next frame continues as if this one had not been started);
  ///     kInvalidArgument for settings that contradict each other
  Status RenderNext(const ViewSettings& settings, double elapsed, const RenderProgress& keep_going,
                    ViewFrame* out);
  /// Adds a sample to the reference, if one is requested and the view is static.
  Status RefineReference(const RenderProgress& keep_going);
  /// Whether the frame in progress, or the last one, may take long since nothing moves: it may be
  /// cancelled on any input. May be called from RenderNext's `keep_going`.
  bool refines() const { return plan_.refines; }
  bool WantsReference() const {
    const bool as_chosen = !plan_.fast_filter && plan_.scale == settings_.scale;
    return settings_.reference && still_ && as_chosen;
  }
  bool has_moving_lights() const { return animation_.has_lights(); }

  /// The devices that filter frames, and trace the next scene.
  const RenderDevices& devices() const { return devices_; }

  const Scene& scene() const { return *loaded_.scene; }
  const SceneRequest& request() const { return loaded_.request; }
  /// Of the last frame; empty before the first, and if the frame stayed on the device since neither
  /// a reference nor a view needed it.
  const Image3& noisy() const { return shown_.noisy(); }
  /// The picture in full precision, downloaded if no frame has needed it so far.
  /// \return kNotFound before the first frame; errors of the device
  Result<const Image3*> Denoised();
  const ReferenceAccumulator& reference() const { return reference_; }
  /// The display picture of the last frame, if it was shared. Errors as Denoised.
  Result<Rgb8Image> FinishedPicture();
  /// The values of a view of the last frame, for files. \return kNotFound if there is no such view;
  /// errors of the device
  Result<std::vector<Image1>> Values(const std::string& view);

 private:
  struct Moment {
    RenderMoment render;  ///< arguments for the renderer: times of the retimed animation
    AnimationTime time;
    ViewPose pose;
    double orbit_degrees = 0;  ///< of `pose` on its orbit
  };
  /// A frame that is planned.
  struct NextFrame {
    Moment moment;
    FramePlan plan;
    ViewSettings settings;  ///< with the plan's replacements
    bool moved = false;     ///< against the last frame
    bool loses_history = false;
    uint64_t rate_changes = 0;
    double elapsed = 0;  ///< seconds by which time passes
  };
  struct Ahead;
  bool MayReplaceSettings(const ViewSettings& settings) const;
  bool AllowsFastFilter(const ViewSettings& settings) const;
  FramePlan PlanFrame(const ViewSettings& settings, bool moves, RateControl* control) const;
  ViewSettings Planned(ViewSettings settings, const FramePlan& plan) const;
  NextFrame PlanNext(const ViewSettings& settings, double elapsed, RateControl* control);
  bool LosesHistory(const NextFrame& next) const;
  bool CanSeed(const NextFrame& next) const;
  Result<Frame> GuidesOfLastView(const NextFrame& next, const RenderProgress& keep_going);
  Status MakeSeed(const NextFrame& next, const RenderProgress& keep_going);
  RenderSettings RendererSettings(const NextFrame& next) const;
  Status TraceNow(const ViewSettings& settings, double elapsed, const RenderProgress& keep_going,
                  NextFrame* next);
  bool UsesAhead(const ViewSettings& settings);
  Status TakeAhead(double elapsed, const RenderProgress& keep_going, NextFrame* next);
  void StartAhead(const ViewSettings& settings, double elapsed);
  Status PrepareHistory(const ViewSettings& settings);
  Status PrepareDenoiser(const ViewSettings& settings);
  Status MakeDenoiser(const Settings& settings);
  Status AskForOutputs(const ViewSettings& settings);
  bool FallsBack(const Status& status);
  void Note(const std::string& what);
  Status Filter(const ViewSettings& settings, const RenderMoment& moment,
                const RenderProgress& keep_going);
  Moment NextMoment(const ViewSettings& settings, double elapsed);
  AnimationTime NextTime(const ViewSettings& settings, double elapsed) const;
  double NextOrbit(const ViewSettings& settings, double elapsed) const;
  void Account(double denoise_ms, bool overlapped, ViewFrame* out) const;
  FrameParts Parts() const;

  LoadedScene loaded_;
  RetimedAnimation animation_;
  RenderDevices devices_;
  Tracing tracing_;   ///< of the last frame
  std::string note_;  ///< message for the next frame
  std::optional<Denoiser> denoiser_;
  ViewSettings settings_;  ///< of the last frame, with the filter that made it
  Aabb bounds_;
  RateControl control_;
  FramePlan plan_;  ///< of the frame in progress, or the last one
  Frame frame_;
  Frame next_frame_;           ///< buffer for the next frame
  std::optional<Frame> seed_;  ///< becomes the history of the next frame's filter
  DenoisedFrame denoised_;
  ShownFrame shown_;
  ReferenceAccumulator reference_;
  Moment moment_;  ///< of the last frame
  uint64_t frames_ = 0;
  double samples_ = 0;
  uint64_t rate_changes_ = 0;
  bool still_ = false;
  double length_ = 0;
  double owed_ = 0;  ///< seconds that passed but are not shown: a frame ahead used an estimate
  std::unique_ptr<Ahead> ahead_;  ///< last, so that it ends before its data is freed
};

}  // namespace stillray::view
