// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// All views of a frame, by name: the finished picture, guides, signals, moments, variances, levels
/// of the wavelet.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/frame.h"
#include "stillray/io.h"
#include "view/hit_views.h"
#include "view/view_range.h"
#include "view/world_views.h"

namespace stillray::view {

/// Conversion of values to colours.
enum class Colouring : uint8_t {
  kLight,      ///< radiance: exposure, tone curve, sRGB
  kAlbedo,     ///< reflectance: sRGB
  kNormal,     ///< -1..1 as 0..1
  kDepth,      ///< the nearest white, infinity black
  kMotion,     ///< direction as hue, length as brightness, on a scale fitted to the picture
  kId,         ///< a colour for each number
  kUnit,       ///< 0..1 as grey
  kCount,      ///< samples, as heat on a logarithmic scale fitted to the picture
  kLuminance,  ///< one channel of light
  kRatio,      ///< logarithmic: 1/2 black, 1 grey, 2 white
  kVariance,   ///< its root as heat, on a scale fitted to the picture
  kArrows,     ///< motion as arrows over the denoised picture
  kPosition,   ///< world coordinates as red, green, blue, the origin mid grey
  kGrid,       ///< world coordinates as cubes of alternating grey
  kRelative,   ///< deviation relative to the mean as heat, on a scale fitted to the picture
};

struct ViewInfo {
  std::string name;
  std::string group;  ///< "picture", "guides", "light of this frame", ...
  Colouring colouring = Colouring::kLight;
  /// Outputs of the denoiser that the view needs; empty if none.
  std::vector<std::string> outputs;
};

/// All views available with these settings, in the order of a menu.
std::vector<ViewInfo> ListViews(const Settings& settings);
/// nullptr if there is no such view.
const ViewInfo* FindView(const std::vector<ViewInfo>& views, std::string_view name);

/// The sources of views. None may be nullptr but `reference`, `filled`, `world` and `hits`.
struct ViewSources {
  const Frame* frame = nullptr;
  const DenoisedFrame* denoised = nullptr;
  const Image3* noisy = nullptr;      ///< all light of `frame`
  const Image3* reference = nullptr;  ///< nullptr: none yet
  const Settings* settings = nullptr;
  /// The source of views named "filled.*": guides after fill_guides, if the frame's are sparse;
  /// nullptr: those of `frame`.
  const Guides* filled = nullptr;
  const WorldViews* world = nullptr;  ///< of `frame`, for views that ShowsWorld
  const HitViews* hits = nullptr;     ///< of `frame`, for views that ShowsHits
};

/// Whether the view needs planes of ViewSources::frame, or data derived from them.
bool ShowsFrame(const ViewInfo& view);
/// Whether the view needs ViewSources::filled.
bool ShowsFilledGuides(const ViewInfo& view);

/// Whether the view needs ViewSources::world.
bool ShowsWorld(const ViewInfo& view);

/// Whether the view needs ViewSources::hits.
bool ShowsHits(const ViewInfo& view);

/// Whether the view is the finished picture as displayed.
bool ShowsFinishedPicture(const ViewInfo& view);

/// The values of a view: 1 to 3 planes of one size, in full precision; none if the frame lacks them
/// (no reference yet, a history of the first frame).
std::vector<Image1> ViewValues(const ViewInfo& view, const ViewSources& sources);
/// The values at one pixel; as many as ViewValues has planes, without computing these.
std::vector<float> ViewValuesAt(const ViewInfo& view, const ViewSources& sources, int x, int y);
/// The view as a display picture. Missing data is dark grey. For the finished picture
/// DenoisedFrame::display is sufficient.
/// \param range  [out] the range of its colour scale, if it has one
Rgb8Image ViewPicture(const ViewInfo& view, const ViewSources& sources, ViewRange* range);

}  // namespace stillray::view
