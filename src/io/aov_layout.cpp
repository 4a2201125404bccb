// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Assigns the layers of a file to AOVs.
#include <algorithm>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/nearest_names.h"
#include "core/pixels.h"
#include "io/aov_light.h"
#include "io/aov_mapping.h"
#include "io/aov_presets.h"
#include "io/aov_samples.h"
#include "io/aov_seen.h"
#include "io/text.h"
#include "stillray/aov.h"

namespace stillray {
namespace {

constexpr std::string_view kRendererNames[] = {"auto",   "blender",   "stillray",
                                               "arnold", "renderman", "vray"};

std::string LayerOf(const std::string& channel) {
  const size_t dot = channel.rfind('.');
  return dot == std::string::npos ? "" : channel.substr(0, dot);
}

std::string ChannelOf(const std::string& layer, char letter) {
  return layer.empty() ? std::string(1, letter) : fmt::format("{}.{}", layer, letter);
}

/// The names of a file's channels, indexed for look-ups.
class ChannelNames {
 public:
  explicit ChannelNames(const ExrImage& image) {
    for (const Channel& channel : image.channels) {
      names_.insert(channel.name);
      layers_.insert(LayerOf(channel.name));
    }
  }
  const std::set<std::string>& layers() const { return layers_; }
  bool Has(const std::string& channel) const { return names_.count(channel) != 0; }
  /// The full names, if the layer has all these letters.
  std::optional<std::vector<std::string>> Find(const std::string& layer,
                                               std::string_view letters) const {
    std::vector<std::string> channels;
    for (const char letter : letters) {
      channels.push_back(ChannelOf(layer, letter));
      if (!Has(channels.back())) {
        return std::nullopt;
      }
    }
    return channels;
  }

 private:
  std::set<std::string> names_;
  std::set<std::string> layers_;
};

bool Has(const std::vector<AovSource>& sources, Aov aov) {
  return std::any_of(sources.begin(), sources.end(),
                     [&](const AovSource& s) { return s.aov == aov; });
}

/// The rows of the table that match behind `prefix` ("ViewLayer.").
std::vector<AovSource> MatchRows(const ChannelNames& names, const io::AovPreset& preset,
                                 const std::string& prefix) {
  std::vector<AovSource> sources;
  for (const io::AovNameRow& row : preset.rows) {
    const std::string layer = *row.layer == '\0' ? "" : prefix + row.layer;
    auto channels = names.Find(layer, row.channels);
    if (channels && !Has(sources, row.aov)) {
      sources.push_back({row.aov, layer, std::move(*channels)});
    }
  }
  return sources;
}

struct PresetMatch {
  std::vector<AovSource> sources;
  std::string prefix;                   ///< with its dot
  std::vector<std::string> also_light;  ///< other prefixes with light to filter
};

/// Whether the sources form a view layer, not a separate image ("Composite.Combined"). The main
/// image has no prefix.
bool HasLightAndPasses(const std::vector<AovSource>& sources, const std::string& prefix) {
  constexpr int kColourResultAndAlpha = 3;
  const auto is_own = [&](const AovSource& s) { return s.layer.starts_with(prefix); };
  const bool light = std::any_of(sources.begin(), sources.end(), [&](const AovSource& s) {
    return s.aov == Aov::kColour && is_own(s);
  });
  return light && std::count_if(sources.begin(), sources.end(), is_own) > kColourResultAndAlpha;
}

/// Chooses the prefix with the most matches: renderers put the name of the view layer, of the
/// scene, or nothing before the names of passes.
/// \param view_layer  empty: any
PresetMatch MatchPreset(const ChannelNames& names, const io::AovPreset& preset,
                        const std::string& view_layer) {
  std::set<std::string> prefixes = {""};
  for (const std::string& layer : names.layers()) {
    for (const io::AovNameRow& row : preset.rows) {
      const std::string tail = fmt::format(".{}", row.layer);
      if (tail.size() > 1 && layer.ends_with(tail)) {
        prefixes.insert(layer.substr(0, layer.size() - tail.size() + 1));
      }
    }
  }
  if (!view_layer.empty()) {
    const std::string wanted = view_layer + ".";
    std::erase_if(prefixes, [&](const std::string& prefix) { return prefix != wanted; });
  }
  PresetMatch best;
  std::vector<std::string> with_light;
  for (const std::string& prefix : prefixes) {
    std::vector<AovSource> sources = MatchRows(names, preset, prefix);
    if (!prefix.empty() && HasLightAndPasses(sources, prefix)) {
      with_light.push_back(prefix);
    }
    if (sources.size() > best.sources.size()) {
      best.sources = std::move(sources);
      best.prefix = prefix;
    }
  }
  std::erase(with_light, best.prefix);
  best.also_light = std::move(with_light);
  return best;
}

/// The name in a prefix, without its dot.
std::string ViewLayerName(const std::string& prefix) {
  return prefix.substr(0, prefix.size() - std::min<size_t>(prefix.size(), 1));
}

void UseMatch(PresetMatch match, AovLayout* layout) {
  layout->sources = std::move(match.sources);
  layout->view_layer = ViewLayerName(match.prefix);
  layout->other_view_layers.clear();
  for (const std::string& prefix : match.also_light) {
    layout->other_view_layers.push_back(ViewLayerName(prefix));
  }
}

Result<const io::AovPreset*> PickPreset(const ChannelNames& names, const AovOptions& options,
                                        AovLayout* layout) {
  const std::string& renderer = options.renderer;
  const io::AovPreset* picked = nullptr;
  bool known = renderer == "auto";
  for (const io::AovPreset& preset : io::AovPresets()) {
    known = known || preset.name == renderer;
    if (renderer != "auto" && preset.name != renderer) {
      continue;
    }
    PresetMatch found = MatchPreset(names, preset, options.view_layer);
    if (picked == nullptr || found.sources.size() > layout->sources.size()) {
      picked = &preset;
      UseMatch(std::move(found), layout);
    }
  }
  if (!known) {
    return Status::InvalidArgument(
        fmt::format("--renderer is '{}', expected one of {}{}", io::OneLine(renderer),
                    fmt::join(kRendererNames, ", "), DidYouMean(renderer, kRendererNames)));
  }
  return picked;
}

/// Reports a view layer that is missing, or adds a note on the view layers that are not used.
Status CheckViewLayer(const ChannelNames& names, const AovOptions& options, const std::string& file,
                      AovLayout* layout) {
  if (!options.view_layer.empty() && layout->sources.empty()) {
    std::set<std::string> firsts;
    for (const std::string& layer : names.layers()) {
      const size_t dot = layer.rfind('.');
      if (dot != std::string::npos) {
        firsts.insert(layer.substr(0, dot));
      }
    }
    return Status::NotFound(fmt::format(
        "{}: --view-layer is '{}', expected one of the file's: {}", file,
        io::OneLine(options.view_layer),
        io::OneLine(firsts.empty() ? "it has none, only passes"
                                   : fmt::format("{}{}", fmt::join(firsts, ", "),
                                                 DidYouMeanOneOf(options.view_layer, firsts)))));
  }
  if (!options.view_layer.empty()) {
    layout->other_view_layers.clear();  // left out by request
  }
  if (!layout->other_view_layers.empty()) {
    const std::string others =
        io::OneLine(fmt::format("{}", fmt::join(layout->other_view_layers, ", ")));
    layout->notes.push_back(
        fmt::format("of several view layers only {} is denoised; {} {} as noisy as before "
                    "(--view-layer NAME denoises another one)",
                    io::OneLine(layout->view_layer), others,
                    layout->other_view_layers.size() == 1 ? "stays" : "stay"));
  }
  return Status::Ok();
}

int ComponentCount(Aov aov) {
  switch (aov) {
    case Aov::kAlpha:
    case Aov::kDepth:
    case Aov::kSeenDepth:
    case Aov::kHitDistance:
    case Aov::kReflectionDepth:
    case Aov::kReflectionId:
    case Aov::kRefractionDepth:
    case Aov::kRefractionId:
    case Aov::kId:
    case Aov::kCryptomatte:
    case Aov::kRoughness:
    case Aov::kSamples:
    case Aov::kConfidence:
      return 1;
    case Aov::kMotion:
    case Aov::kNextMotion:
    case Aov::kSpecularMotion:
    case Aov::kReflectionMotion:
    case Aov::kRefractionMotion:
      return 2;
    default:
      return 3;
  }
}

std::vector<const char*> UsualLetters(Aov aov) {
  switch (ComponentCount(aov)) {
    case 1:
      if (aov == Aov::kAlpha) {
        return {"A", "a", "V", "R"};
      }
      return {"Z", "z", "V", "X", "R", "r", "Y"};
    case 2:
      return {"XY", "RG", "xy", "rg", "UV"};
    default:
      return {"RGB", "XYZ", "rgb", "xyz"};
  }
}

/// The layer of that name, or the only one that ends in ".name".
Result<std::string> FindLayer(const ChannelNames& names, const io::AovMapping& mapping,
                              const std::string& file) {
  if (names.layers().count(mapping.layer) != 0) {
    return mapping.layer;
  }
  std::vector<std::string> found;
  for (const std::string& layer : names.layers()) {
    if (layer.ends_with(fmt::format(".{}", mapping.layer))) {
      found.push_back(layer);
    }
  }
  if (found.size() == 1) {
    return found[0];
  }
  return Status::NotFound(fmt::format(
      "{}: --aov {}: {} layers are called '{}'{}", file, AovName(mapping.aov),
      found.empty() ? "no" : "several", io::OneLine(mapping.layer),
      io::OneLine(fmt::format(
          " among {}", fmt::join(found.empty() ? std::vector<std::string>(names.layers().begin(),
                                                                          names.layers().end())
                                               : found,
                                 ", ")))));
}

Status ApplyMapping(const ChannelNames& names, const std::string& text, const std::string& file,
                    AovLayout* layout) {
  const Result<io::AovMapping> mapping = io::ParseAovMapping(text);
  if (!mapping.ok()) {
    return mapping.status();
  }
  io::Drop(mapping->aov, layout);
  if (mapping->aov == Aov::kMotion) {
    // The preset's next motion belongs to another motion layer.
    io::Drop(Aov::kNextMotion, layout);
  }
  if (mapping->layer == "none") {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(io::ApplyWords(*mapping, layout));
  // A single channel may be given by its full name.
  if (ComponentCount(mapping->aov) == 1 && names.Has(mapping->layer)) {
    layout->sources.push_back({mapping->aov, LayerOf(mapping->layer), {mapping->layer}});
    return Status::Ok();
  }
  const Result<std::string> layer = FindLayer(names, *mapping, file);
  if (!layer.ok()) {
    return layer.status();
  }
  std::vector<const char*> choices = UsualLetters(mapping->aov);
  if (!mapping->channels.empty()) {
    if (static_cast<int>(mapping->channels.size()) != ComponentCount(mapping->aov)) {
      return Status::InvalidArgument(
          fmt::format("--aov {}: channels= is '{}', expected {} letters", AovName(mapping->aov),
                      io::OneLine(mapping->channels), ComponentCount(mapping->aov)));
    }
    choices = {mapping->channels.c_str()};
  }
  for (const char* letters : choices) {
    if (auto channels = names.Find(*layer, letters)) {
      layout->sources.push_back({mapping->aov, *layer, std::move(*channels)});
      return Status::Ok();
    }
  }
  return Status::NotFound(fmt::format("{}: --aov {}: layer '{}' has no channels {}", file,
                                      AovName(mapping->aov), io::OneLine(*layer),
                                      fmt::join(choices, " or ")));
}

void NoteMissingGuides(AovLayout* layout) {
  if (layout->single_layer) {
    layout->notes = {
        "the file holds the picture alone, without passes: every frame is denoised on its own, and "
        "textures lose detail (Blender: File Format is OpenEXR, choose OpenEXR MultiLayer in "
        "Output "
        "Properties > Output)"};
    return;
  }
  const auto note = [&](Aov aov, const char* text) {
    if (layout->Find(aov) == nullptr) {
      layout->notes.push_back(fmt::format("no {}: {}", AovName(aov), text));
    }
  };
  if (layout->motion_from_cameras) {
    layout->notes.push_back(
        "no motion: it is derived from depth and the cameras (worldToCamera, worldToNDC), without "
        "the motion of objects");
  } else {
    note(Aov::kMotion, "every frame is denoised separately, without history");
  }
  note(Aov::kDepth, "only normals and light stop the filter at edges");
  note(Aov::kNormal, "only depth and light stop the filter at edges");
  if (layout->from_colour && layout->Find(Aov::kFallbackAlbedo) == nullptr) {
    note(Aov::kAlbedo, "textures are filtered together with the light and lose detail");
  } else if (!layout->from_colour) {
    note(Aov::kAlbedo, "textures are filtered together with the light and lose detail");
  }
  const bool steady = layout->motion.direction == MotionDirection::kToNext ||
                      layout->motion.direction == MotionDirection::kFromNext;
  if (steady && layout->Find(Aov::kMotion)) {
    layout->notes.push_back(
        "motion points to the next frame; it is reversed, which is right where motion is steady");
  }
  if (layout->normal.camera_space && layout->Find(Aov::kNormal)) {
    layout->notes.push_back(
        "normals in camera space become world space only in files with worldToCamera");
  }
}

/// Fraction of the pixels with a normal whose normal is much shorter than 1: a mean of different
/// normals. Pixels without a normal (background) are excluded.
double PartOfShortNormals(const ExrImage& image, const AovLayout& layout) {
  const AovSource* source = layout.Find(Aov::kNormal);
  if (source == nullptr) {
    return 0;
  }
  std::array<const Image1*, 3> planes{};
  for (size_t c = 0; c < 3; ++c) {
    const Channel* channel = image.Find(source->channels[c]);
    if (channel == nullptr || channel->type == PixelType::kUint32) {
      return 0;
    }
    planes[c] = &channel->values;
  }
  constexpr float kNone = 0.1f;
  constexpr float kShort = 0.97f;
  int64_t any = 0;
  int64_t less = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float squared = 0;
      for (const Image1* plane : planes) {
        const float n = layout.normal.encoded ? 2.0f * (*plane)(x, y) - 1.0f : (*plane)(x, y);
        squared += n * n;
      }
      any += squared > kNone * kNone;
      less += squared > kNone * kNone && squared < kShort * kShort;
    }
  }
  return any == 0 ? 0 : static_cast<double>(less) / static_cast<double>(any);
}

/// Guides of one sample per pixel have sharp edges; with several, some per cent of all pixels lie
/// on an edge.
void NoteSoftGuides(const ExrImage& image, AovLayout* layout) {
  constexpr double kEnough = 0.002;
  const double part = PartOfShortNormals(image, *layout);
  layout->soft_guides = part > kEnough;
  if (layout->soft_guides) {
    layout->notes.push_back(fmt::format(
        "normals are shorter than 1 at {:.1f} % of the pixels: guides are antialiased or noisy",
        100 * part));
  }
}

/// Only one id layer is used. Object numbers that were never assigned carry no information.
void PickId(const ExrImage& image, bool id_is_index, AovLayout* layout) {
  const AovSource* id = layout->Find(Aov::kId);
  if (id != nullptr && id_is_index) {
    const Channel* channel = image.Find(id->channels[0]);
    if (channel != nullptr && channel->type != PixelType::kUint32 &&
        !AnyPixel(channel->values, [](float v) { return v != 0; })) {
      layout->notes.push_back(fmt::format("{} is zero everywhere and is not used", id->layer));
      io::Drop(Aov::kId, layout);
    }
  }
  if (layout->Find(Aov::kId) != nullptr) {
    io::Drop(Aov::kCryptomatte, layout);
    return;
  }
  const AovSource* matte = layout->Find(Aov::kCryptomatte);
  const Channel* channel = matte == nullptr ? nullptr : image.Find(matte->channels[0]);
  if (channel != nullptr && channel->type != PixelType::kFloat) {
    layout->notes.push_back(
        fmt::format("{} is not used: its names do not survive in less than 32 bits", matte->layer));
    io::Drop(Aov::kCryptomatte, layout);
  }
}

void ListCarried(const ChannelNames& names, AovLayout* layout) {
  for (const std::string& layer : names.layers()) {
    const bool serves = std::any_of(layout->sources.begin(), layout->sources.end(),
                                    [&](const AovSource& s) { return s.layer == layer; });
    const std::string first = layer + ".X";
    const bool is_moment = std::find(layout->second_moments.begin(), layout->second_moments.end(),
                                     first) != layout->second_moments.end();
    if (!serves && !is_moment) {
      layout->carried.push_back(layer);
    }
  }
}

std::string LettersOf(const AovSource& source) {
  std::string letters;
  for (const std::string& channel : source.channels) {
    letters += channel.substr(channel.rfind('.') + 1);
  }
  return letters;
}

std::string ConventionOf(const AovLayout& layout, const AovSource& source) {
  switch (source.aov) {
    case Aov::kMotion:
    case Aov::kReflectionMotion:
    case Aov::kRefractionMotion:
      return ConventionText(layout.motion);
    case Aov::kNextMotion:
      return ConventionText(layout.next_motion);
    case Aov::kSpecularMotion:
      return ConventionText(layout.specular_motion);
    case Aov::kHitDistance:
      return ConventionText(layout.hit_distance);
    case Aov::kDepth:
      return ConventionText(layout.depth);
    case Aov::kNormal:
      return ConventionText(layout.normal);
    default:
      return layout.light_is_divided && io::IsLight(source.aov) && source.aov < Aov::kDirectVolume
                 ? fmt::format("times {}", AovName(io::AlbedoOf(source.aov)))
                 : "";
  }
}

}  // namespace

std::span<const std::string_view> RendererNames() {
  return kRendererNames;
}

const AovSource* AovLayout::Find(Aov aov) const {
  const auto at = std::find_if(sources.begin(), sources.end(),
                               [&](const AovSource& s) { return s.aov == aov; });
  return at == sources.end() ? nullptr : &*at;
}

Result<AovLayout> UnderstandAovs(const ExrImage& image, const AovOptions& options,
                                 const std::string& name) {
  const ChannelNames names(image);
  AovLayout layout;
  const Result<const io::AovPreset*> preset = PickPreset(names, options, &layout);
  if (!preset.ok()) {
    return preset.status();
  }
  STILLRAY_RETURN_IF_ERROR(CheckViewLayer(names, options, name, &layout));
  layout.renderer = (*preset)->name;
  layout.motion = (*preset)->motion;
  layout.next_motion = (*preset)->next_motion;
  layout.specular_motion = (*preset)->motion;
  layout.depth = (*preset)->depth;
  layout.normal = (*preset)->normal;
  layout.light_is_divided = (*preset)->light_is_divided;
  bool without_motion = false;
  for (const std::string& mapping : options.mappings) {
    STILLRAY_RETURN_IF_ERROR(ApplyMapping(names, mapping, name, &layout));
    without_motion = without_motion || mapping == "motion=none";
  }
  PickId(image, (*preset)->id_is_index, &layout);
  STILLRAY_RETURN_IF_ERROR(io::DecideLight(name, &layout));
  io::DecideFallbackAlbedo(options, &layout);
  io::DecideSeenGuides(image, &layout);
  io::DecideHits(image, &layout);
  io::DecideColour(image, options, name, &layout);
  io::DecideRest(&layout);
  std::stable_sort(layout.sources.begin(), layout.sources.end(),
                   [](const AovSource& a, const AovSource& b) { return a.aov < b.aov; });
  layout.motion_from_cameras = !without_motion && layout.Find(Aov::kMotion) == nullptr &&
                               layout.Find(Aov::kDepth) != nullptr && CameraOf(image).has_value();
  layout.single_layer = names.layers() == std::set<std::string>{""} && !layout.motion_from_cameras;
  io::DecideCurvedImages(image, &layout);
  NoteMissingGuides(&layout);
  io::DecideSamples(image, &layout);
  io::DecideSecondMoments(image, &layout);
  NoteSoftGuides(image, &layout);
  ListCarried(names, &layout);
  return layout;
}

std::string AovTable(const AovLayout& layout) {
  size_t width = 8;
  for (const AovSource& source : layout.sources) {
    width = std::max(width, std::min<size_t>(source.layer.size(), 60));
  }
  std::string text = fmt::format("understood as frames of {}\n", layout.renderer);
  for (const AovSource& source : layout.sources) {
    std::string line = fmt::format("  {:<22}  {:<{}}  {:<4}  {}", AovName(source.aov),
                                   source.layer.empty() ? "(main)" : io::OneLine(source.layer, 60),
                                   width, LettersOf(source), ConventionOf(layout, source));
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  for (const std::string& channel : layout.second_moments) {
    if (!channel.empty()) {
      text += fmt::format("  {:<22}  {:<{}}  X\n", "second_moment",
                          channel.substr(0, channel.rfind('.')), width);
    }
  }
  for (const std::string& layer : layout.carried) {
    text += fmt::format("  {:<22}  {}\n", "(carried through)",
                        layer.empty() ? "(main)" : io::OneLine(layer, 60));
  }
  for (const std::string& note : layout.notes) {
    text += "note: " + io::OneLine(note) + "\n";
  }
  return text;
}

}  // namespace stillray
