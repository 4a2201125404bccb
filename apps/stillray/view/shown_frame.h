// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The displayed frame: its planes, and derived planes required by the current views.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "stillray/denoise.hpp"
#include "view/hit_views.h"
#include "view/view_frame.h"
#include "view/view_settings.h"
#include "view/views.h"
#include "view/world_views.h"

namespace stillray::view {

/// Inputs of a frame's images in addition to the planes of ShownFrame.
struct FrameParts {
  const Frame& frame;
  const RenderMoment& moment;  ///< with current and previous camera poses
  const DenoisedFrame& denoised;
  const Image3* reference;   ///< nullptr: none yet
  const Settings& settings;  ///< settings of the filter that produced the frame
};

class ShownFrame {
 public:
  /// Updates the list of views that are available with these filter settings.
  void ListViewsOf(const Settings& settings) { views_ = ListViews(settings); }
  /// nullptr if there is no such view.
  const ViewInfo* Find(const std::string& name) const { return FindView(views_, name); }
  /// Results of the filter required by panes, reference and inspector.
  Results WantedResults(const ViewSettings& settings) const;
  /// Named outputs of the filter required by panes, reference and inspector.
  std::vector<std::string> WantedOutputs(const ViewSettings& settings) const;

  /// Takes a new frame, and downloads its planes from the device in the rare case that they are
  /// required.
  /// \return errors of the device
  Status Take(const Frame& frame, const ViewSettings& settings);
  /// Computes the planes of HitViews, if any of these views is shown. \return kOutOfMemory
  Status FindHits(const Scene& scene, const RenderMoment& moment, const Frame& frame,
                  const ViewSettings& settings);
  /// Derives the planes required by panes and inspector from the frame's planes.
  void Derive(const FrameParts& parts, const ViewSettings& settings);

  /// Creates the images of the panes, and the readouts.
  void Show(const FrameParts& parts, const ViewSettings& settings, ViewFrame* out) const;
  Rgb8Image FinishedPicture(const FrameParts& parts) const;
  /// The values of a view, for files; empty if the frame lacks them. \return errors of the device
  Result<std::vector<Image1>> Values(const ViewInfo& view, const FrameParts& parts,
                                     const ViewSettings& settings);

  /// Total radiance of the frame; empty if it remained in device memory.
  const Image3& noisy() const { return noisy_; }
  /// Bytes of the planes downloaded from a device.
  size_t bytes() const;

 private:
  struct FilledGuides {
    HeldGuides held;
    FillGuidesWork work;
  };
  const ViewInfo& PaneView(const std::string& name) const;
  bool ShowsAny(const ViewSettings& settings, bool (*kind)(const ViewInfo&)) const;
  bool NeedsHost(const ViewSettings& settings) const;
  Status TakePlanes(const Frame& frame, const ViewSettings& settings);
  /// The frame with host planes; without them if it is in device memory and they are not required.
  const Frame& Host(const Frame& frame) const { return brought_ ? from_device_ : frame; }
  void FillGuides(const Frame& frame, const ViewSettings& settings);
  WorldViews WorldOf(const FrameParts& parts) const;
  ViewSources Sources(const FrameParts& parts) const;
  void Inspect(const FrameParts& parts, const ViewSettings& settings, ViewFrame* out) const;

  std::vector<ViewInfo> views_;
  Frame from_device_;     ///< buffer for the planes of a frame in device memory
  bool brought_ = false;  ///< whether from_device_ is valid
  Image3 noisy_;
  std::unique_ptr<FilledGuides> filled_;   ///< only while a view shows them
  std::optional<WorldViews> world_;        ///< only while a view shows them
  std::optional<HitViews> hits_;           ///< only while a view shows them
  std::unique_ptr<HitFinder> hit_finder_;  ///< created when a view first shows hits
  uint64_t answered_focus_ = 0;
  float focus_depth_ = 0;
};

}  // namespace stillray::view
