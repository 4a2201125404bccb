// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The radiance of a file: its passes, or its colour alone, and the differences between both.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/aov_importer.h"
#include "io/aov_light.h"
#include "io/fill_depth.h"
#include "io/lossy.h"

namespace stillray::io {
namespace {

struct LightRow {
  Aov aov;
  SignalKind kind;
  Aov albedo;
};
constexpr LightRow kLights[] = {
    {Aov::kDirectDiffuse, SignalKind::kDirectDiffuse, Aov::kAlbedo},
    {Aov::kIndirectDiffuse, SignalKind::kIndirectDiffuse, Aov::kAlbedo},
    {Aov::kDirectSpecular, SignalKind::kDirectSpecular, Aov::kSpecularAlbedo},
    {Aov::kIndirectSpecular, SignalKind::kIndirectSpecular, Aov::kSpecularAlbedo},
    {Aov::kDirectTransmission, SignalKind::kDirectTransmission, Aov::kTransmissionAlbedo},
    {Aov::kIndirectTransmission, SignalKind::kIndirectTransmission, Aov::kTransmissionAlbedo},
};

void MultiplyBy(const Image3& factor, Image3* image) {
  ForEachPixel(image->width(), image->height(), [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      (*image)[c](x, y) *= factor[c](x, y);
    }
  });
}

void AddTo(const Image3& more, Image3* image) {
  if (image->empty()) {
    *image = more;
    return;
  }
  ForEachPixel(image->width(), image->height(), [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      (*image)[c](x, y) += more[c](x, y);
    }
  });
}

/// a - b where both are finite, else 0, so that invalid values do not spread.
float Difference(float a, float b) {
  const float difference = a - b;
  return std::isfinite(difference) ? difference : 0.0f;
}

}  // namespace

Signal& Importer::SignalOf(SignalKind kind) {
  for (Signal& signal : frame_.signals) {
    if (signal.kind == kind) {
      return signal;
    }
  }
  Signal signal;
  signal.kind = kind;
  signal.radiance = Image3(frame_.width, frame_.height);
  frame_.signals.push_back(std::move(signal));
  return frame_.signals.back();
}

void Importer::KeepPart(Aov aov, SignalKind kind, const Image3& radiance) {
  if (parts_ != nullptr) {
    parts_->push_back({aov, kind, radiance, Image3()});
  }
}

void Importer::ImportPasses() {
  for (const LightRow& row : kLights) {
    if (layout_.Find(row.aov) == nullptr) {
      continue;
    }
    Image3 light = Light(row.aov);
    if (layout_.light_is_divided) {
      MultiplyBy(Colour(row.albedo), &light);
    }
    KeepPart(row.aov, row.kind, light);
    SignalOf(row.kind).radiance = std::move(light);
  }
  for (Signal& signal : frame_.signals) {
    const std::string& name = layout_.second_moments[static_cast<size_t>(signal.kind)];
    const Channel* moment = name.empty() ? nullptr : image_.Find(name);
    if (moment != nullptr) {
      signal.second_moment = moment->values;
    }
  }
  ImportVolume();
}

/// Radiance scattered in volumes has no albedo. It is added to transmitted light: both come from
/// behind the surface of the guides.
void Importer::ImportVolume() {
  for (const auto& [aov, kind] :
       {std::pair(Aov::kDirectVolume, SignalKind::kDirectTransmission),
        std::pair(Aov::kIndirectVolume, SignalKind::kIndirectTransmission)}) {
    if (layout_.Find(aov) != nullptr) {
      const Image3 light = Light(aov);
      KeepPart(aov, kind, light);
      AddTo(light, &SignalOf(kind).radiance);
      AddTo(light, &volume_);
    }
  }
}

/// The background behind volumes is added to their radiance. \param without_depth  see
/// TakeBackground
void Importer::FilterBackground(const Plane<uint8_t>& without_depth) {
  const Image3 taken =
      TakeBackground(without_depth, volume_, frame_.guides.normal, &frame_.background);
  KeepPart(Aov::kBackground, SignalKind::kIndirectTransmission, taken);
  AddTo(taken, &SignalOf(SignalKind::kIndirectTransmission).radiance);
}

/// The only signal is the colour without emission and background.
void Importer::ImportColourAlone() {
  Image3 light = Light(Aov::kColour);
  const Image3 emission = frame_.emission;
  const Image3 background = frame_.background;
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      const float colour = light[c](x, y);
      const float known = (emission.empty() ? 0.0f : emission[c](x, y)) +
                          (background.empty() ? 0.0f : background[c](x, y));
      if (known == 0 || !std::isfinite(known)) {
        continue;
      }
      const float left = colour - known;
      const bool rounding = std::fabs(left) <= kRoundingPart * std::fabs(known);
      light[c](x, y) = rounding ? 0.0f : left;
    }
  });
  // With a transparent film, sky is in the passes but not in the colour.
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      if (light[c](x, y) < 0 && !background.empty() && background[c](x, y) > 0) {
        const float over = std::min(-light[c](x, y), background[c](x, y));
        frame_.background[c](x, y) -= over;
        light[c](x, y) += over;
      }
    }
  });
  SignalOf(SignalKind::kDirectDiffuse).radiance = std::move(light);
}

/// Layers of light without its colour stay divided by the colours of the file.
void Importer::KeepStoredAlbedos() {
  for (size_t i = 0; parts_ != nullptr && i < parts_->size(); ++i) {
    LightPart& part = (*parts_)[i];
    if (part.aov >= Aov::kDirectDiffuse && part.aov <= Aov::kIndirectSpecular) {
      part.stored_albedo = AlbedoOf(frame_.guides, part.kind);
    }
  }
}

/// Adds radiance missing in the passes to the signal AovLayout::rest, and subtracts radiance
/// missing in the colour (sky behind a transparent film) from unfiltered radiance, so that the
/// frame sums to the colour.
void Importer::AddRest() {
  const Image3 colour = Light(Aov::kColour);
  if (colour.empty() || layout_.from_colour || layout_.ignores_colour) {
    return;
  }
  const Image3 sum = SumOfLight(frame_);
  if (frame_.emission.empty()) {
    frame_.emission = Image3(frame_.width, frame_.height);
  }
  const bool filtered = layout_.rest != Aov::kEmission;
  const SignalKind kind = layout_.rest == Aov::kIndirectTransmission
                              ? SignalKind::kIndirectTransmission
                              : SignalKind::kIndirectSpecular;
  Image3* noisy = filtered ? &SignalOf(kind).radiance : nullptr;
  Image3 unnamed(filtered && parts_ != nullptr ? frame_.width : 0, frame_.height);
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      const float a = colour[c](x, y);
      const float b = sum[c](x, y);
      const float rest = Difference(a, b);
      if (std::fabs(rest) > kRoundingPart * std::max(std::fabs(a), std::fabs(b))) {
        Image3& target = rest > 0 && noisy != nullptr ? *noisy : frame_.emission;
        target[c](x, y) += rest;
        if (!unnamed.empty() && &target == noisy) {
          unnamed[c](x, y) = rest;
        }
      }
    }
  });
  if (!unnamed.empty()) {
    KeepPart(Aov::kColour, kind, unnamed);
  }
}

/// Where the transmission albedo is zero, radiance of volumes must not be divided by the clamped
/// value.
void Importer::CompleteTransmissionAlbedo() {
  Image3& albedo = frame_.guides.transmission_albedo;
  if (albedo.empty()) {
    albedo = WhiteAlbedo(frame_.width, frame_.height);
    return;
  }
  if (!layout_.Find(Aov::kDirectVolume) && !layout_.Find(Aov::kIndirectVolume)) {
    return;
  }
  for (size_t i = 0; parts_ != nullptr && i < parts_->size(); ++i) {
    if ((*parts_)[i].aov == Aov::kDirectTransmission ||
        (*parts_)[i].aov == Aov::kIndirectTransmission) {
      (*parts_)[i].stored_albedo = albedo;
    }
  }
  ForEachPixel(frame_.width, frame_.height, [&](int x, int y) {
    for (int c = 0; c < 3; ++c) {
      albedo[c](x, y) = albedo[c](x, y) > 0 ? albedo[c](x, y) : 1.0f;
    }
  });
}

/// A layer of radiance, without the negative values due to its compression.
Image3 Importer::Light(Aov aov) const {
  Image3 light = Colour(aov);
  if (IsLossyLayer(aov)) {
    RemoveRinging(&light);
  }
  return light;
}

bool Importer::IsLossyLayer(Aov aov) const {
  const AovSource* source = layout_.Find(aov);
  return source != nullptr &&
         std::any_of(source->channels.begin(), source->channels.end(),
                     [&](const std::string& name) { return IsLossy(image_, *image_.Find(name)); });
}

}  // namespace stillray::io
