// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A view of one scene, which converts settings to the next image. Independent of clock and window:
/// equal calls give bit-identical images (if the rate is fixed), on one device or on two.
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
  /// \param devices  `filter` denoises frames, with a fallback to the CPU (ViewFrame::note);
  ///     `tracer` is the device of the loaded renderer, which handles its own fallback. If they
  ///     differ, the next frame is traced on another thread while one is filtered. RenderNext uses
  ///     that frame if the settings are unchanged or, while the view moves, differ only in the
  ///     pose; otherwise it is discarded
  explicit ViewSession(LoadedScene loaded, const RenderDevices& devices = {});
  ~ViewSession();
  ViewSession(ViewSession&&) noexcept;

  /// Renders and denoises the next frame, and converts it to display images.
  /// \param elapsed     seconds since the last frame, for real-time animation
  /// \param keep_going  returns false to cancel the frame
  /// \return kCancelled (the state is as before the call); kInvalidArgument for contradictory
  ///     settings
  Status RenderNext(const ViewSettings& settings, double elapsed, const RenderProgress& keep_going,
                    ViewFrame* out);
  /// Adds a sample to the reference, if one is requested and the view is static.
  Status RefineReference(const RenderProgress& keep_going);
  /// Whether the current or last frame refines a static view and may take long: it may be cancelled
  /// on any input. May be called from RenderNext's `keep_going`.
  bool refines() const { return plan_.refines; }
  bool WantsReference() const {
    const bool as_chosen = !plan_.fast_filter && plan_.scale == settings_.scale;
    return settings_.reference && still_ && as_chosen;
  }
  bool has_moving_lights() const { return animation_.has_lights(); }

  /// The devices for filtering, and for tracing the next scene.
  const RenderDevices& devices() const { return devices_; }

  const Scene& scene() const { return *loaded_.scene; }
  const SceneRequest& request() const { return loaded_.request; }
  /// Total radiance of the last frame; empty before the first frame, and if the frame remained in
  /// device memory because neither reference nor views required it.
  const Image3& noisy() const { return shown_.noisy(); }
  /// The denoised image in full precision; downloaded on demand.
  /// \return kNotFound before the first frame; errors of the device
  Result<const Image3*> Denoised();
  const ReferenceAccumulator& reference() const { return reference_; }
  /// The display image of the last frame, if it was shared. Errors as Denoised.
  Result<Rgb8Image> FinishedPicture();
  /// The values of a view of the last frame, for files. \return kNotFound if there is no such view;
  /// errors of the device
  Result<std::vector<Image1>> Values(const std::string& view);

 private:
  struct Moment {
    RenderMoment render;  ///< arguments for the renderer: times of the retimed animation
    AnimationTime time;
    ViewPose pose;
    double orbit_degrees = 0;  ///< angle of `pose` on its orbit
  };
  /// The plan of a frame.
  struct NextFrame {
    Moment moment;
    FramePlan plan;
    ViewSettings settings;  ///< with the plan's replacements
    bool moved = false;     ///< whether the view differs from the last frame
    bool loses_history = false;
    uint64_t rate_changes = 0;
    double elapsed = 0;  ///< time step in seconds
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
  Tracing tracing_;   ///< timings of the last frame
  std::string note_;  ///< message for the next frame
  std::optional<Denoiser> denoiser_;
  ViewSettings settings_;  ///< settings of the last frame, including the filter in use
  Aabb bounds_;
  RateControl control_;
  FramePlan plan_;  ///< plan of the current or last frame
  Frame frame_;
  Frame next_frame_;           ///< buffer for the next frame
  std::optional<Frame> seed_;  ///< becomes the history of the next frame's filter
  DenoisedFrame denoised_;
  ShownFrame shown_;
  ReferenceAccumulator reference_;
  Moment moment_;  ///< times and pose of the last frame
  uint64_t frames_ = 0;
  double samples_ = 0;
  uint64_t rate_changes_ = 0;
  bool still_ = false;
  double length_ = 0;
  double owed_ = 0;  ///< elapsed seconds not yet applied, since frames traced ahead use an estimate
  std::unique_ptr<Ahead> ahead_;  ///< last member: its thread ends before its data is freed
};

}  // namespace stillray::view
