// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The displayed frame: its planes, and the planes derived from them that the current views need.
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

/// The inputs of a frame's pictures other than the planes of ShownFrame.
struct FrameParts {
  const Frame& frame;
  const RenderMoment& moment;  ///< with both poses
  const DenoisedFrame& denoised;
  const Image3* reference;   ///< nullptr: none yet
  const Settings& settings;  ///< of the filter that made it
};

class ShownFrame {
 public:
  /// Lists the views that exist with these settings of the filter.
  void ListViewsOf(const Settings& settings) { views_ = ListViews(settings); }
  /// nullptr if there is no such view.
  const ViewInfo* Find(const std::string& name) const { return FindView(views_, name); }
  /// The results of the filter that the panes, the reference and the inspector need.
  Results WantedResults(const ViewSettings& settings) const;
  /// Likewise the named outputs of the filter.
  std::vector<std::string> WantedOutputs(const ViewSettings& settings) const;

  /// Takes a new frame, and downloads its planes from a device if they are needed, which is rare.
  /// \return errors of the device
  Status Take(const Frame& frame, const ViewSettings& settings);
  /// Finds the planes of views of hits, if one is shown. \return kOutOfMemory
  Status FindHits(const Scene& scene, const RenderMoment& moment, const Frame& frame,
                  const ViewSettings& settings);
  /// Derives the planes that the panes and the inspector need, from those taken.
  void Derive(const FrameParts& parts, const ViewSettings& settings);

  /// Makes the pictures of the panes, and the readouts.
  void Show(const FrameParts& parts, const ViewSettings& settings, ViewFrame* out) const;
  Rgb8Image FinishedPicture(const FrameParts& parts) const;
  /// The values of a view, for files; none if the frame lacks them. \return errors of the device
  Result<std::vector<Image1>> Values(const ViewInfo& view, const FrameParts& parts,
                                     const ViewSettings& settings);

  /// All light of the frame; empty if it stayed on the device.
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
  /// The frame with its planes; without, if it is on a device and they are not needed.
  const Frame& Host(const Frame& frame) const { return brought_ ? from_device_ : frame; }
  void FillGuides(const Frame& frame, const ViewSettings& settings);
  WorldViews WorldOf(const FrameParts& parts) const;
  ViewSources Sources(const FrameParts& parts) const;
  void Inspect(const FrameParts& parts, const ViewSettings& settings, ViewFrame* out) const;

  std::vector<ViewInfo> views_;
  Frame from_device_;     ///< buffer for the frame's planes, if it is on a device
  bool brought_ = false;  ///< they are valid
  Image3 noisy_;
  std::unique_ptr<FilledGuides> filled_;   ///< while a view shows them
  std::optional<WorldViews> world_;        ///< likewise
  std::optional<HitViews> hits_;           ///< likewise
  std::unique_ptr<HitFinder> hit_finder_;  ///< made when a view first shows hits
  uint64_t answered_focus_ = 0;
  float focus_depth_ = 0;
};

}  // namespace stillray::view
