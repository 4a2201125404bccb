// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// All views of a frame, by name: the finished image, guides, signals, moments, variances, levels
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
  kDepth,      ///< nearest depth white, infinity black
  kMotion,     ///< direction as hue, length as brightness, on a scale fitted to the image
  kId,         ///< one colour per id
  kUnit,       ///< 0..1 as grey
  kCount,      ///< samples, as heat on a logarithmic scale fitted to the image
  kLuminance,  ///< one channel of radiance
  kRatio,      ///< logarithmic: 1/2 black, 1 grey, 2 white
  kVariance,   ///< its root as heat, on a scale fitted to the image
  kArrows,     ///< motion as arrows over the denoised image
  kPosition,   ///< world coordinates as red, green, blue, the origin mid grey
  kGrid,       ///< world coordinates as cubes of alternating grey
  kRelative,   ///< deviation relative to the mean as heat, on a scale fitted to the image
};

struct ViewInfo {
  std::string name;
  std::string group;  ///< "picture", "guides", "light of this frame", ...
  Colouring colouring = Colouring::kLight;
  /// Outputs of the denoiser required by the view; empty if none.
  std::vector<std::string> outputs;
};

/// All views available with these settings, in the order of a menu.
std::vector<ViewInfo> ListViews(const Settings& settings);
/// The view with this name; nullptr if there is none.
const ViewInfo* FindView(const std::vector<ViewInfo>& views, std::string_view name);

/// The sources of views. Only `reference`, `filled`, `world` and `hits` may be nullptr.
struct ViewSources {
  const Frame* frame = nullptr;
  const DenoisedFrame* denoised = nullptr;
  const Image3* noisy = nullptr;      ///< total radiance of `frame`
  const Image3* reference = nullptr;  ///< nullptr: none yet
  const Settings* settings = nullptr;
  /// The source of views named "filled.*": guides after fill_guides, if the frame's are sparse;
  /// nullptr: guides of `frame`.
  const Guides* filled = nullptr;
  const WorldViews* world = nullptr;  ///< world views of `frame`, for views that satisfy ShowsWorld
  const HitViews* hits = nullptr;     ///< hit views of `frame`, for views that satisfy ShowsHits
};

/// Whether the view requires planes of ViewSources::frame, or data derived from them.
bool ShowsFrame(const ViewInfo& view);
/// Whether the view needs ViewSources::filled.
bool ShowsFilledGuides(const ViewInfo& view);

/// Whether the view needs ViewSources::world.
bool ShowsWorld(const ViewInfo& view);

/// Whether the view needs ViewSources::hits.
bool ShowsHits(const ViewInfo& view);

/// Whether the view is the finished display image.
bool ShowsFinishedPicture(const ViewInfo& view);

/// The values of a view: 1 to 3 planes of equal size, in full precision; empty if the frame lacks
/// them (no reference yet, history in the first frame).
std::vector<Image1> ViewValues(const ViewInfo& view, const ViewSources& sources);
/// The values at one pixel, one per plane of ViewValues, without computing the planes.
std::vector<float> ViewValuesAt(const ViewInfo& view, const ViewSources& sources, int x, int y);
/// The view as a display image. Missing data is dark grey. For the finished image
/// DenoisedFrame::display suffices.
/// \param range  [out] the range of its colour scale, if it has one
Rgb8Image ViewPicture(const ViewInfo& view, const ViewSources& sources, ViewRange* range);

}  // namespace stillray::view
