// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/views.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/parallel.h"
#include "stillray/render.h"
#include "view/colour_maps.h"
#include "view/motion_arrows.h"

namespace stillray::view {
namespace {

constexpr int kRangeStep = 3;  // spacing of the pixels that determine the range
constexpr std::string_view kFilled = "filled.";
constexpr std::pair<const char*, Colouring> kWorldViews[] = {{"position", Colouring::kPosition},
                                                             {"world_grid", Colouring::kGrid},
                                                             {"object_motion", Colouring::kMotion}};
constexpr std::pair<const char*, Colouring> kHitViews[] = {{"barycentrics", Colouring::kAlbedo},
                                                           {"triangle", Colouring::kId},
                                                           {"material", Colouring::kId}};
constexpr uint8_t kAbsent = 40;  // dark grey: the image does not exist yet

Colouring ColouringOf(const std::string& kind) {
  if (kind == "disocclusion" || kind == "alpha" || kind.starts_with("weights")) {
    return Colouring::kUnit;
  }
  if (kind == "history" || kind == "limit") {
    return Colouring::kCount;
  }
  if (kind == "ratio") {
    return Colouring::kRatio;
  }
  if (kind == "moment_mean") {
    return Colouring::kLuminance;
  }
  return kind.find("variance") != std::string::npos ? Colouring::kVariance : Colouring::kLight;
}

std::string GroupOfOutput(const std::string& kind) {
  if (kind == "temporal" || kind == "aliased") {
    return "picture";
  }
  if (kind.starts_with("atrous") || kind.starts_with("weights")) {
    return "wavelet levels";
  }
  if (kind == "alpha" || kind == "history" || kind == "limit" || kind == "ratio" ||
      kind == "disocclusion") {
    return "history";
  }
  return ColouringOf(kind) == Colouring::kLight ? "light without albedo" : "moments and variance";
}

std::string KindOf(const std::string& name) {
  return name.substr(0, name.find('.'));
}

/// Source planes of a view: at most three, or the ids.
struct Layer {
  std::vector<const Image1*> planes;
  const Plane<uint32_t>* ids = nullptr;
  const Image1* divisor = nullptr;  ///< mean for kRelative, where planes[0] is the variance
  bool ones = false;                ///< constant 1: frames without a plane of samples
};

template <size_t N>
Layer LayerOf(const Planes<float, static_cast<int>(N)>& image) {
  Layer layer;
  for (const Image1& plane : image.channel) {
    if (!plane.empty()) {
      layer.planes.push_back(&plane);
    }
  }
  return layer;
}

Layer LayerOf(const Image1& plane) {
  return plane.empty() ? Layer{} : Layer{{&plane}};
}

const NamedImage* FindOutput(const DenoisedFrame& denoised, std::string_view name) {
  for (const NamedImage& image : denoised.images) {
    if (image.name == name) {
      return &image;
    }
  }
  return nullptr;
}

Layer OutputLayer(const DenoisedFrame& denoised, std::string_view name) {
  Layer layer;
  if (const NamedImage* image = FindOutput(denoised, name); image != nullptr) {
    for (const Image1& plane : image->channels) {
      layer.planes.push_back(&plane);
    }
  }
  return layer;
}

Layer RelativeLayer(const ViewInfo& view, const DenoisedFrame& denoised) {
  Layer layer = OutputLayer(denoised, view.outputs[0]);
  const Layer mean = OutputLayer(denoised, view.outputs[1]);
  layer.divisor = mean.planes.empty() ? nullptr : mean.planes[0];
  return layer.planes.empty() || mean.planes.empty() ? Layer{} : layer;
}

Layer GuideLayer(std::string_view name, const Guides& g) {
  if (name == "depth") {
    return LayerOf(g.depth);
  }
  if (name == "normal") {
    return LayerOf<3>(g.normal);
  }
  if (name == "albedo") {
    return LayerOf<3>(g.albedo);
  }
  if (name == "specular_albedo") {
    return LayerOf<3>(g.specular_albedo);
  }
  if (name == "transmission_albedo") {
    return LayerOf<3>(g.transmission_albedo);
  }
  if (name == "motion" || name == "motion_arrows") {
    return LayerOf<2>(g.motion);
  }
  if (name == "id") {
    Layer layer;
    layer.ids = g.id.empty() ? nullptr : &g.id;
    return layer;
  }
  return name == "roughness" ? LayerOf(g.roughness) : Layer{};
}

Layer HitLayer(std::string_view name, const HitViews& hits) {
  Layer layer;
  if (name == "barycentrics") {
    return LayerOf<3>(hits.barycentrics);
  }
  layer.ids = name == "triangle" ? &hits.triangle : &hits.material;
  return layer;
}

Layer FindLayer(const ViewInfo& view, const ViewSources& s) {
  const std::string& name = view.name;
  if (name == "denoised") {
    return LayerOf<3>(s.denoised->colour);
  }
  if (name == "noisy") {
    return LayerOf<3>(*s.noisy);
  }
  if (name == "reference") {
    return s.reference == nullptr ? Layer{} : LayerOf<3>(*s.reference);
  }
  if (name == "emission") {
    return LayerOf<3>(s.frame->emission);
  }
  if (name == "background") {
    return LayerOf<3>(s.frame->background);
  }
  if (name == "samples") {
    Layer layer = LayerOf(s.frame->samples);
    layer.ones = s.frame->samples.empty();
    return layer;
  }
  if (ShowsWorld(view)) {
    if (s.world == nullptr) {
      return {};
    }
    return name == "object_motion" ? LayerOf<2>(s.world->object_motion)
                                   : LayerOf<3>(s.world->position);
  }
  if (ShowsHits(view)) {
    return s.hits == nullptr ? Layer{} : HitLayer(name, *s.hits);
  }
  for (const Signal& signal : s.frame->signals) {
    if (name == SignalName(signal.kind)) {
      return LayerOf<3>(signal.radiance);
    }
  }
  if (view.colouring == Colouring::kRelative) {
    return RelativeLayer(view, *s.denoised);
  }
  if (ShowsFilledGuides(view)) {
    return GuideLayer(std::string_view(name).substr(kFilled.size()),
                      s.filled != nullptr ? *s.filled : s.frame->guides);
  }
  return view.outputs.empty() ? GuideLayer(name, s.frame->guides)
                              : OutputLayer(*s.denoised, view.outputs[0]);
}

float Relative(const Layer& layer, int x, int y) {
  const float mean = std::max((*layer.divisor)(x, y), 1e-6f);
  return std::sqrt(std::max((*layer.planes[0])(x, y), 0.0f)) / mean;
}

/// The value for the colour scale: the square root for variance.
float ScaledValue(Colouring colouring, const float* v) {
  if (colouring == Colouring::kMotion) {
    return std::hypot(v[0], v[1]);
  }
  return colouring == Colouring::kVariance ? std::sqrt(std::max(v[0], 0.0f)) : std::max(v[0], 0.0f);
}

/// Returns the values of a pixel that are converted to a colour.
void ValuesOf(const Layer& layer, int x, int y, float values[3]) {
  for (size_t c = 0; c < layer.planes.size() && c < 3; ++c) {
    values[c] = (*layer.planes[c])(x, y);
  }
  if (layer.divisor != nullptr) {
    values[0] = Relative(layer, x, y);
  }
}

/// The range of a view with a colour scale.
ViewRange RangeOf(Colouring colouring, const Layer& layer, int width, int height) {
  ViewRange range;
  switch (colouring) {
    case Colouring::kCount:
      range = {0, true, false, "samples"};
      break;
    case Colouring::kVariance:
      range = {0, false, false, "deviation"};
      break;
    case Colouring::kRelative:
      range = {0, false, false, "of the mean"};
      break;
    case Colouring::kMotion:
      range = {0, false, true, "pixels"};
      break;
    default:
      return range;
  }
  std::vector<float> sample;
  for (int y = 0; y < height; y += kRangeStep) {
    for (int x = 0; x < width; x += kRangeStep) {
      float values[3] = {1, 0, 0};
      ValuesOf(layer, x, y, values);
      sample.push_back(ScaledValue(colouring, values));
    }
  }
  range.top = FittedTop(&sample);
  return range;
}

/// Checkerboard of cubes with corners at odd multiples of half an edge, so that rounding errors do
/// not affect walls at round coordinates.
Rgb8 GridColour(const float* v, float cubes_per_unit) {
  constexpr float kDark = 0.25f;
  constexpr float kBright = 0.7f;
  if (v[0] == 0 && v[1] == 0 && v[2] == 0) {
    return {};  // no surface
  }
  int64_t sum = 0;
  for (int c = 0; c < 3; ++c) {
    sum += static_cast<int64_t>(std::floor(v[c] * cubes_per_unit + 0.5f));
  }
  return Grey((sum & 1) != 0 ? kDark : kBright);
}

/// The largest finite coordinate, at least a millionth.
float LargestCoordinate(const Layer& layer) {
  float largest = 1e-6f;
  for (const Image1* plane : layer.planes) {
    for (int y = 0; y < plane->height(); ++y) {
      for (int x = 0; x < plane->width(); ++x) {
        const float value = std::abs((*plane)(x, y));
        largest = std::isfinite(value) ? std::max(largest, value) : largest;
      }
    }
  }
  return largest;
}

/// Cubes of the world grid have a power of ten as edge length, with 2 to 20 cubes along the longest
/// axis.
float CubesPerUnit(const Layer& layer) {
  return std::pow(10.0f, -std::floor(std::log10(LargestCoordinate(layer) / 2)));
}

Rgb8 Colour(Colouring colouring, const float* v, float scale, const ViewRange& range) {
  // Infinite depth marks the sky.
  const bool is_sky = colouring == Colouring::kDepth && v[0] == INFINITY;
  const std::optional<Rgb8> mark = NotFiniteColour(v[0], v[1], v[2]);
  if (mark && !is_sky) {
    return *mark;
  }
  switch (colouring) {
    case Colouring::kNormal:
      return NormalColour(v[0], v[1], v[2]);
    case Colouring::kDepth:
      return Grey(std::isfinite(v[0]) && v[0] > 0 ? scale / v[0] : 0);
    case Colouring::kMotion:
      return MotionColour(v[0], v[1], range.top);
    case Colouring::kPosition:
      return {Grey(0.5f + 0.5f * v[0] * scale).r, Grey(0.5f + 0.5f * v[1] * scale).r,
              Grey(0.5f + 0.5f * v[2] * scale).r};
    case Colouring::kGrid:
      return GridColour(v, scale);
    case Colouring::kUnit:
      return Grey(v[0]);
    case Colouring::kCount:
    case Colouring::kVariance:
    case Colouring::kRelative:
      return Heat(range.At(ScaledValue(colouring, v)));
    case Colouring::kLuminance:
      return Grey(ToSrgb(v[0] * scale / (1 + v[0] * scale)));
    case Colouring::kRatio:
      return Grey(0.5f + 0.5f * std::log2(std::max(v[0], 1e-6f)));
    case Colouring::kAlbedo:
      return {Grey(ToSrgb(v[0])).r, Grey(ToSrgb(v[1])).r, Grey(ToSrgb(v[2])).r};
    case Colouring::kLight:
    case Colouring::kArrows:
    case Colouring::kId:
      break;
  }
  return {};
}

/// Factor applied to values before the conversion to colours.
float ScaleOf(Colouring colouring, const Layer& layer, const Settings& settings) {
  if (colouring == Colouring::kDepth) {
    float nearest = INFINITY;
    const Image1& depth = *layer.planes[0];
    for (int y = 0; y < depth.height(); ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        const float z = depth(x, y);
        nearest = z > 0 && z < nearest ? z : nearest;
      }
    }
    return std::isfinite(nearest) ? nearest : 1.0f;
  }
  if (colouring == Colouring::kPosition) {
    return 1 / LargestCoordinate(layer);
  }
  if (colouring == Colouring::kGrid) {
    return CubesPerUnit(layer);
  }
  return std::exp2(settings.exposure);
}

/// Marks non-finite values after tone mapping, which clamps them.
void MarkNotFinite(const Image3& colour, Rgb8Image* picture) {
  ParallelRows(picture->height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      uint8_t* row = picture->pixels.data() + static_cast<size_t>(y) * picture->width * 3;
      for (int x = 0; x < picture->width; ++x) {
        if (const std::optional<Rgb8> mark =
                NotFiniteColour(colour[0](x, y), colour[1](x, y), colour[2](x, y))) {
          row[3 * x] = mark->r;
          row[3 * x + 1] = mark->g;
          row[3 * x + 2] = mark->b;
        }
      }
    }
  });
}

Image3 AsColour(const Layer& layer) {
  Image3 colour(layer.planes[0]->width(), layer.planes[0]->height());
  for (int c = 0; c < 3; ++c) {
    colour[c] = *layer.planes[std::min(static_cast<size_t>(c), layer.planes.size() - 1)];
  }
  return colour;
}

std::vector<uint8_t> DisplayOf(const Image3& colour, const ViewSources& s) {
  return ToDisplay(colour, s.settings->exposure, s.settings->tonemap, s.settings->dither,
                   s.frame->index);
}

std::vector<uint8_t> FinishedPicture(const ViewSources& s) {
  return s.denoised->display.empty() ? DisplayOf(s.denoised->colour, s) : s.denoised->display;
}

template <typename Pixel>
void Paint(Rgb8Image* picture, const Pixel& pixel) {
  ParallelRows(picture->height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      uint8_t* row = picture->pixels.data() + static_cast<size_t>(y) * picture->width * 3;
      for (int x = 0; x < picture->width; ++x) {
        const Rgb8 c = pixel(x, y);
        row[3 * x] = c.r;
        row[3 * x + 1] = c.g;
        row[3 * x + 2] = c.b;
      }
    }
  });
}

}  // namespace

std::vector<ViewInfo> ListViews(const Settings& settings) {
  std::vector<ViewInfo> views = {{"denoised", "picture", Colouring::kLight, {}},
                                 {"noisy", "picture", Colouring::kLight, {}},
                                 {"reference", "picture", Colouring::kLight, {}}};
  const std::vector<std::string> outputs = Denoiser::OutputNames(settings);
  for (const char* group :
       {"picture", "wavelet levels", "history", "moments and variance", "light without albedo"}) {
    for (const std::string& name : outputs) {
      const std::string kind = KindOf(name);
      if (GroupOfOutput(kind) == group) {
        views.push_back(
            {kind == "noisy" ? "new" + name.substr(5) : name, group, ColouringOf(kind), {name}});
      }
      if (kind == "variance" && std::string(group) == "moments and variance") {
        const std::string signal = name.substr(kind.size());
        views.push_back({"relative_noise" + signal,
                         group,
                         Colouring::kRelative,
                         {name, "moment_mean" + signal}});
      }
    }
  }
  for (int k = 0; k < kMostTracedSignals; ++k) {
    views.push_back(
        {SignalName(static_cast<SignalKind>(k)), "light of this frame", Colouring::kLight, {}});
  }
  for (const char* name : {"emission", "background"}) {
    views.push_back({name, "light of this frame", Colouring::kLight, {}});
  }
  const std::pair<const char*, Colouring> guides[] = {{"samples", Colouring::kCount},
                                                      {"depth", Colouring::kDepth},
                                                      {"normal", Colouring::kNormal},
                                                      {"albedo", Colouring::kAlbedo},
                                                      {"specular_albedo", Colouring::kAlbedo},
                                                      {"transmission_albedo", Colouring::kAlbedo},
                                                      {"motion", Colouring::kMotion},
                                                      {"motion_arrows", Colouring::kArrows},
                                                      {"id", Colouring::kId},
                                                      {"roughness", Colouring::kUnit}};
  for (const auto& [name, colouring] : guides) {
    views.push_back({name, "guides", colouring, {}});
  }
  for (const auto& [name, colouring] : kWorldViews) {
    views.push_back({name, "guides", colouring, {}});
  }
  for (const auto& [name, colouring] : kHitViews) {
    views.push_back({name, "guides", colouring, {}});
  }
  for (const auto& [name, colouring] : guides) {
    if (colouring != Colouring::kArrows && colouring != Colouring::kCount &&
        colouring != Colouring::kMotion) {
      views.push_back({std::string(kFilled) + name, "guides, completed", colouring, {}});
    }
  }
  return views;
}

bool ShowsFinishedPicture(const ViewInfo& view) {
  return view.name == "denoised" || view.colouring == Colouring::kArrows;
}

bool ShowsFrame(const ViewInfo& view) {
  return view.outputs.empty() && view.name != "denoised" && view.name != "reference";
}

bool ShowsWorld(const ViewInfo& view) {
  return std::ranges::any_of(kWorldViews, [&](const auto& one) { return view.name == one.first; });
}

bool ShowsHits(const ViewInfo& view) {
  return std::ranges::any_of(kHitViews, [&](const auto& one) { return view.name == one.first; });
}

bool ShowsFilledGuides(const ViewInfo& view) {
  return view.name.starts_with(kFilled);
}

const ViewInfo* FindView(const std::vector<ViewInfo>& views, std::string_view name) {
  for (const ViewInfo& view : views) {
    if (view.name == name) {
      return &view;
    }
  }
  return nullptr;
}

std::vector<Image1> ViewValues(const ViewInfo& view, const ViewSources& sources) {
  const Layer layer = FindLayer(view, sources);
  const int width = sources.frame->width;
  const int height = sources.frame->height;
  std::vector<Image1> values;
  if (layer.ids != nullptr || layer.ones || layer.divisor != nullptr) {
    values.emplace_back(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        values[0](x, y) = layer.ids != nullptr ? static_cast<float>((*layer.ids)(x, y))
                          : layer.ones         ? 1.0f
                                               : Relative(layer, x, y);
      }
    }
    return values;
  }
  for (const Image1* plane : layer.planes) {
    values.push_back(*plane);
  }
  return values;
}

std::vector<float> ViewValuesAt(const ViewInfo& view, const ViewSources& sources, int x, int y) {
  const Layer layer = FindLayer(view, sources);
  if (layer.ids != nullptr) {
    return {static_cast<float>((*layer.ids)(x, y))};
  }
  if (layer.ones) {
    return {1.0f};
  }
  if (layer.divisor != nullptr) {
    return {Relative(layer, x, y)};
  }
  std::vector<float> values;
  for (const Image1* plane : layer.planes) {
    values.push_back((*plane)(x, y));
  }
  return values;
}

Rgb8Image ViewPicture(const ViewInfo& view, const ViewSources& sources, ViewRange* range) {
  *range = {};
  Rgb8Image picture;
  picture.width = sources.frame->width;
  picture.height = sources.frame->height;
  const Layer layer = FindLayer(view, sources);
  if (view.name == "denoised" && !sources.denoised->display.empty()) {
    picture.pixels = sources.denoised->display;
    return picture;
  }
  const bool absent = layer.planes.empty() && layer.ids == nullptr && !layer.ones;
  if (!absent && view.colouring == Colouring::kLight) {
    const Image3 colour = AsColour(layer);
    picture.pixels = DisplayOf(colour, sources);
    MarkNotFinite(colour, &picture);
    return picture;
  }
  if (!absent && view.colouring == Colouring::kArrows) {
    picture.pixels = FinishedPicture(sources);
    DrawMotionArrows(sources.frame->guides.motion, &picture);
    return picture;
  }
  picture.pixels.resize(static_cast<size_t>(picture.width) * picture.height * 3, kAbsent);
  if (absent) {
    return picture;
  }
  if (layer.ids != nullptr) {
    Paint(&picture, [&](int x, int y) { return IdColour((*layer.ids)(x, y)); });
    return picture;
  }
  const float scale = ScaleOf(view.colouring, layer, *sources.settings);
  *range = RangeOf(view.colouring, layer, picture.width, picture.height);
  Paint(&picture, [&](int x, int y) {
    float values[3] = {1, 0, 0};
    ValuesOf(layer, x, y, values);
    return Colour(view.colouring, values, scale, *range);
  });
  return picture;
}

}  // namespace stillray::view
