// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/shown_frame.h"

#include <algorithm>
#include <cmath>

#include "core/clock.h"
#include "denoise/stage_table.h"

namespace stillray::view {
namespace {

constexpr int kFocusReach = 24;  // radius in pixels around a click that is searched for a surface

int PixelAt(float fraction, int size) {
  return std::clamp(static_cast<int>(fraction * static_cast<float>(size)), 0, size - 1);
}

bool IsSurface(float depth) {
  return std::isfinite(depth) && depth > 0;
}

/// The depth at the closest pixel with a surface; 0 if there is none.
float DepthNear(const Image1& depth, int x, int y) {
  float best = 0;
  int best_distance = kFocusReach * kFocusReach + 1;
  for (int dy = -kFocusReach; dy <= kFocusReach; ++dy) {
    for (int dx = -kFocusReach; dx <= kFocusReach; ++dx) {
      const int distance = dx * dx + dy * dy;
      const bool inside =
          x + dx >= 0 && x + dx < depth.width() && y + dy >= 0 && y + dy < depth.height();
      if (inside && distance < best_distance && IsSurface(depth(x + dx, y + dy))) {
        best = depth(x + dx, y + dy);
        best_distance = distance;
      }
    }
  }
  return best;
}

/// Whether the inspector shows a view's values, which must then be outputs of the filter.
bool IsInspected(const ViewInfo& view) {
  return view.group == "history" || view.name == "temporal" || view.group == "moments and variance";
}

}  // namespace

/// The view of a pane. Signal names depend on the grouping: a missing view is replaced by the
/// finished image.
const ViewInfo& ShownFrame::PaneView(const std::string& name) const {
  const ViewInfo* view = Find(name);
  return view != nullptr ? *view : views_[0];
}

/// Whether a pane has a view of this kind.
bool ShownFrame::ShowsAny(const ViewSettings& s, bool (*kind)(const ViewInfo&)) const {
  return std::any_of(s.panes.begin(), s.panes.end(), [&](const std::string& name) {
    const ViewInfo* view = Find(name);
    return view != nullptr && kind(*view);
  });
}

// The full-precision image is a larger copy: it is requested only if its values are measured or
// shown.
Results ShownFrame::WantedResults(const ViewSettings& s) const {
  Results wanted;
  wanted.colour = s.reference || s.inspect;
  wanted.display = wanted.shared = false;
  for (const std::string& name : s.panes) {
    const ViewInfo& view = PaneView(name);
    const bool shares = s.shares_pictures && view.name == "denoised";
    wanted.shared |= shares;
    wanted.display |= !shares && ShowsFinishedPicture(view);
  }
  return wanted;
}

std::vector<std::string> ShownFrame::WantedOutputs(const ViewSettings& s) const {
  std::vector<std::string> wanted;
  for (const ViewInfo& view : views_) {
    const bool shown = std::find(s.panes.begin(), s.panes.end(), view.name) != s.panes.end();
    if (!shown && !(s.inspect && IsInspected(view))) {
      continue;
    }
    for (const std::string& output : view.outputs) {
      if (std::find(wanted.begin(), wanted.end(), output) == wanted.end()) {
        wanted.push_back(output);
      }
    }
  }
  return wanted;
}

bool ShownFrame::NeedsHost(const ViewSettings& s) const {
  return ShowsAny(s, ShowsFrame) || s.inspect || s.reference || s.focus != answered_focus_;
}

Status ShownFrame::Take(const Frame& frame, const ViewSettings& s) {
  brought_ = false;
  noisy_ = Image3();
  return frame.on_device == nullptr || NeedsHost(s) ? TakePlanes(frame, s) : Status::Ok();
}

/// Downloads the frame's planes, and updates data derived from them.
Status ShownFrame::TakePlanes(const Frame& frame, const ViewSettings& s) {
  if (frame.on_device != nullptr) {
    STILLRAY_RETURN_IF_ERROR(OnHost(frame, &from_device_).status());
    brought_ = true;
  }
  const Frame& host = Host(frame);
  noisy_ = SumOfLight(host);
  focus_depth_ = DepthNear(host.guides.depth, PixelAt(s.focus_x, frame.width),
                           PixelAt(s.focus_y, frame.height));
  answered_focus_ = s.focus;
  return Status::Ok();
}

Status ShownFrame::FindHits(const Scene& scene, const RenderMoment& moment, const Frame& frame,
                            const ViewSettings& s) {
  hits_.reset();
  if (!ShowsAny(s, ShowsHits)) {
    return Status::Ok();
  }
  if (hit_finder_ == nullptr) {
    Result<std::unique_ptr<HitFinder>> made = HitFinder::Create(scene);
    STILLRAY_RETURN_IF_ERROR(made.status());
    hit_finder_ = std::move(*made);
  }
  Result<HitViews> found = hit_finder_->Find(moment, frame);
  STILLRAY_RETURN_IF_ERROR(found.status());
  hits_ = std::move(*found);
  return Status::Ok();
}

void ShownFrame::Derive(const FrameParts& parts, const ViewSettings& s) {
  FillGuides(parts.frame, s);
  world_.reset();
  if (ShowsAny(s, ShowsWorld) || s.inspect) {
    world_ = WorldOf(parts);
  }
}

/// Fills the guides as the denoiser does, if a view shows them.
void ShownFrame::FillGuides(const Frame& frame, const ViewSettings& s) {
  if (!ShowsAny(s, ShowsFilledGuides) || !HasIncompleteGuides(Host(frame))) {
    filled_.reset();
    return;
  }
  if (filled_ == nullptr || filled_->held.known.width() != frame.width ||
      filled_->held.known.height() != frame.height) {
    filled_ = std::make_unique<FilledGuides>();
  }
  stillray::FillGuides(Host(frame), kCpuStages, &filled_->held, &filled_->work);
}

WorldViews ShownFrame::WorldOf(const FrameParts& parts) const {
  return MakeWorldViews(Host(parts.frame), *parts.moment.pose, *parts.moment.previous_pose);
}

ViewSources ShownFrame::Sources(const FrameParts& parts) const {
  const bool filled = filled_ != nullptr && !filled_->held.empty();
  return {&Host(parts.frame),
          &parts.denoised,
          &noisy_,
          parts.reference,
          &parts.settings,
          filled ? &filled_->held.guides : nullptr,
          world_ ? &*world_ : nullptr,
          hits_ ? &*hits_ : nullptr};
}

void ShownFrame::Show(const FrameParts& parts, const ViewSettings& s, ViewFrame* out) const {
  const Clock::time_point start = Clock::now();
  out->width = parts.frame.width;
  out->height = parts.frame.height;
  out->panes.clear();
  out->pictures.clear();
  out->shared.clear();
  out->ranges.assign(s.panes.size(), {});
  size_t pane = 0;
  for (const std::string& name : s.panes) {
    const ViewInfo& view = PaneView(name);
    const bool shares = view.name == "denoised" && parts.denoised.shared != nullptr;
    out->panes.push_back(view.name);
    out->shared.push_back(shares ? parts.denoised.shared : nullptr);
    out->pictures.push_back(shares ? Rgb8Image{out->width, out->height, {}}
                                   : ViewPicture(view, Sources(parts), &out->ranges[pane]));
    ++pane;
  }
  Inspect(parts, s, out);
  out->show_ms = MillisecondsSince(start);
}

void ShownFrame::Inspect(const FrameParts& parts, const ViewSettings& s, ViewFrame* out) const {
  out->inspected.clear();
  out->inspect_x = PixelAt(s.inspect_x, parts.frame.width);
  out->inspect_y = PixelAt(s.inspect_y, parts.frame.height);
  if (s.inspect) {
    for (const ViewInfo& view : views_) {
      std::vector<float> values =
          ViewValuesAt(view, Sources(parts), out->inspect_x, out->inspect_y);
      if (!values.empty()) {
        out->inspected.push_back({view.name, std::move(values)});
      }
    }
  }
  out->focus = s.focus;
  out->focus_depth = focus_depth_;
}

Rgb8Image ShownFrame::FinishedPicture(const FrameParts& parts) const {
  ViewRange none;
  return ViewPicture(views_[0], Sources(parts), &none);
}

Result<std::vector<Image1>> ShownFrame::Values(const ViewInfo& view, const FrameParts& parts,
                                               const ViewSettings& s) {
  if (ShowsFrame(view) && noisy_.empty()) {
    STILLRAY_RETURN_IF_ERROR(TakePlanes(parts.frame, s));
  }
  if (ShowsWorld(view) && !world_) {
    world_ = WorldOf(parts);
  }
  return ViewValues(view, Sources(parts));
}

size_t ShownFrame::bytes() const {
  return FrameBytes(from_device_);
}

}  // namespace stillray::view
