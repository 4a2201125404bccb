// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_light.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "io/aov_albedo.h"
#include "io/aov_remainder.h"
#include "io/text.h"

namespace stillray::io {
namespace {

bool IsMapped(const AovOptions& options, Aov aov) {
  const std::string start = fmt::format("{}=", AovName(aov));
  return std::any_of(options.mappings.begin(), options.mappings.end(),
                     [&](const std::string& mapping) { return mapping.starts_with(start); });
}

}  // namespace

std::string LayerNameOf(const AovLayout& layout, Aov aov) {
  const AovSource* source = layout.Find(aov);
  return source == nullptr ? "" : OneLine(source->layer, 60);
}

void Drop(Aov aov, AovLayout* layout) {
  std::erase_if(layout->sources, [&](const AovSource& s) { return s.aov == aov; });
}

bool IsLight(Aov aov) {
  return aov >= Aov::kDirectDiffuse && aov <= Aov::kIndirectVolume;
}

Aov AlbedoOf(Aov light) {
  switch (light) {
    case Aov::kDirectDiffuse:
    case Aov::kIndirectDiffuse:
      return Aov::kAlbedo;
    case Aov::kDirectSpecular:
    case Aov::kIndirectSpecular:
      return Aov::kSpecularAlbedo;
    default:
      return Aov::kTransmissionAlbedo;
  }
}

Status DecideLight(const std::string& file, AovLayout* layout) {
  const bool has_colour = layout->Find(Aov::kColour) != nullptr;
  for (const AovSource& source : std::vector<AovSource>(layout->sources)) {
    const bool divided =
        layout->light_is_divided && IsLight(source.aov) && source.aov < Aov::kDirectVolume;
    if (divided && layout->Find(AlbedoOf(source.aov)) == nullptr) {
      if (!has_colour) {
        return Status::NotFound(fmt::format("{}: layer {} is without its colour: no {} was found",
                                            file, OneLine(source.layer),
                                            AovName(AlbedoOf(source.aov))));
      }
      layout->notes.push_back(fmt::format("{} is not used: its colour ({}) is missing",
                                          source.layer, AovName(AlbedoOf(source.aov))));
      Drop(source.aov, layout);
    }
  }
  const bool has_light = std::any_of(layout->sources.begin(), layout->sources.end(),
                                     [](const AovSource& s) { return IsLight(s.aov); });
  if (!has_colour && !has_light) {
    return Status::NotFound(fmt::format(
        "{}: no light was found under the names of '{}'; set the layers with --renderer and --aov",
        file, layout->renderer));
  }
  const bool has_diffuse = layout->Find(Aov::kDirectDiffuse) || layout->Find(Aov::kIndirectDiffuse);
  // Without diffuse passes, most of the radiance would be in the remainder.
  layout->from_colour = has_colour && !has_diffuse;
  if (!layout->from_colour) {
    Drop(Aov::kFallbackAlbedo, layout);
    Drop(Aov::kFallbackNormal, layout);
    return Status::Ok();
  }
  for (int i = static_cast<int>(Aov::kDirectDiffuse); i <= static_cast<int>(Aov::kIndirectVolume);
       ++i) {
    Drop(static_cast<Aov>(i), layout);
  }
  return Status::Ok();
}

/// The albedos of the passes are noise-free where Denoising Albedo is noisy. GlossCol of Cycles is
/// 1 on all glossy surfaces, even with low reflectance, and would hide the textures: measured on
/// textured walls, glass and gold at 1 spp, DiffCol + GlossCol + TransCol gives 28.4 dB, with 0.04
/// GlossCol 31.0 dB, light passes 31.2 dB.
void DecideFallbackAlbedo(const AovOptions& options, AovLayout* layout) {
  if (!layout->from_colour) {
    return;
  }
  const bool chosen = IsMapped(options, Aov::kFallbackAlbedo);
  if (chosen && !IsMapped(options, Aov::kFallbackNormal)) {
    Drop(Aov::kFallbackNormal, layout);
  }
  const bool has_sum = layout->Find(Aov::kAlbedo) && (layout->Find(Aov::kSpecularAlbedo) ||
                                                      layout->Find(Aov::kTransmissionAlbedo));
  if (!chosen && has_sum && layout->light_is_divided) {
    Drop(Aov::kFallbackAlbedo, layout);
  }
  if (layout->Find(Aov::kFallbackAlbedo) == nullptr) {
    Drop(Aov::kFallbackNormal, layout);
  }
  layout->specular_weight = layout->light_is_divided ? kDielectricReflectance : 1.0f;
  std::string divided;
  if (layout->Find(Aov::kFallbackAlbedo) != nullptr) {
    divided = fmt::format(", divided by {}{}", LayerNameOf(*layout, Aov::kFallbackAlbedo),
                          layout->Find(Aov::kFallbackNormal) && layout->Find(Aov::kNormal)
                              ? " where that is not noise (on glass and mirrors it is)"
                              : "");
  } else if (layout->Find(Aov::kAlbedo) != nullptr) {
    divided = ", divided by " + LayerNameOf(*layout, Aov::kAlbedo);
    if (layout->Find(Aov::kSpecularAlbedo) != nullptr) {
      divided += layout->light_is_divided ? fmt::format(" + {} ", layout->specular_weight) : " + ";
      divided += LayerNameOf(*layout, Aov::kSpecularAlbedo);
    }
    if (layout->Find(Aov::kTransmissionAlbedo) != nullptr) {
      divided += " + " + LayerNameOf(*layout, Aov::kTransmissionAlbedo);
    }
  }
  layout->notes.push_back(fmt::format(
      "light passes are missing: all light is filtered as one signal{}; reflections keep less "
      "detail",
      divided));
}

void DecideColour(const ExrImage& image, const AovOptions& options, const std::string& file,
                  AovLayout* layout) {
  if (layout->from_colour || layout->Find(Aov::kColour) == nullptr ||
      IsMapped(options, Aov::kColour)) {
    return;
  }
  double part = 0;
  layout->ignores_colour = ColourIsOfOtherLight(image, *layout, file, &part);
  if (layout->ignores_colour) {
    const std::string name = LayerNameOf(*layout, Aov::kColour);
    layout->notes.push_back(fmt::format(
        "{} lacks {:.0f} % of the light of the passes (denoised or composited before?): it is not "
        "used, and the passes are taken alone, as with --aov colour=none; --aov 'colour={}' takes "
        "it all the same",
        name.empty() ? "the main picture" : name, 100 * part, name));
  }
}

void DecideRest(AovLayout* layout) {
  const auto has = [&](Aov a, Aov b) { return layout->Find(a) || layout->Find(b); };
  if (layout->from_colour || layout->ignores_colour || layout->Find(Aov::kColour) == nullptr ||
      layout->renderer == "stillray") {
    return;
  }
  if (layout->renderer != "blender" || !has(Aov::kDirectSpecular, Aov::kIndirectSpecular)) {
    layout->rest = Aov::kIndirectSpecular;
  } else if (!has(Aov::kDirectTransmission, Aov::kIndirectTransmission)) {
    layout->rest = Aov::kIndirectTransmission;
  }
  if (layout->rest != Aov::kEmission) {
    layout->notes.push_back(
        fmt::format("what the colour holds beyond the passes counts as {}", AovName(layout->rest)));
  }
}

}  // namespace stillray::io
