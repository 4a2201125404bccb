// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "capi/frame_slots.h"

#include <algorithm>
#include <array>

#include "capi/image_access.h"

namespace stillray::capi {
namespace {

constexpr stillray_input_info Input(const char* name, const char* help, int channels) {
  return {sizeof(stillray_input_info), name, help, channels};
}

constexpr std::array kInputs = {
    Input("direct_diffuse",
          "Light straight from a light, diffusely reflected: linear RGB, albedo "
          "multiplied in, mean of this frame's samples.",
          3),
    Input("indirect_diffuse", "Diffusely reflected light that met other surfaces before.", 3),
    Input("direct_specular", "Light straight from a light, specularly reflected.", 3),
    Input("indirect_specular", "Specularly reflected light that met other surfaces before.", 3),
    Input("direct_transmission", "Light straight from a light, through the first surface.", 3),
    Input("indirect_transmission",
          "Light through the first surface that met other surfaces before.", 3),
    Input("direct_diffuse.second_moment",
          "Mean over the pixel's samples of luminance(sample / max(albedo, 0.01))^2; "
          "for several samples per pixel.",
          1),
    Input("indirect_diffuse.second_moment", "The same of indirect_diffuse.", 1),
    Input("direct_specular.second_moment", "The same of direct_specular.", 1),
    Input("indirect_specular.second_moment", "The same of indirect_specular.", 1),
    Input("direct_transmission.second_moment", "The same of direct_transmission.", 1),
    Input("indirect_transmission.second_moment", "The same of indirect_transmission.", 1),
    Input("depth",
          "Linear view-space z of the first surface, > 0; infinite where the ray left "
          "the scene.",
          1),
    Input("normal", "World-space unit normal of the first surface; zero where there is none.", 3),
    Input("albedo", "Diffuse reflectance of the first surface, linear RGB.", 3),
    Input("specular_albedo",
          "Specular reflectance towards the viewer, linear RGB, of specular "
          "light.",
          3),
    Input("transmission_albedo", "Transmittance, linear RGB, of transmitted light.", 3),
    Input("motion",
          "Pixels, x right, y down, without jitter: the point seen at p was at p + "
          "motion(p) one frame ago.",
          2),
    Input("next_motion",
          "For push: the point seen at p stands at p + next_motion(p) one frame later; not given: "
          "found from the next frame's motion.",
          2),
    Input("id", "Same surface, same number, in every frame; 0 where there is none.", 1),
    Input("previous_normal",
          "World-space normal that the same point had one frame ago, for surfaces that turn: they "
          "keep their history; zero: as normal, as it is everywhere if not given.",
          3),
    Input("roughness", "Perceptual roughness, 0 to 1: what smooth surfaces mirror stays sharp.", 1),
    Input(
        "reflection_depth",
        "Virtual guides of specular light, of the image that a smooth surface reflects: view-space "
        "z of the point on the pixel's ray that is as far away as the reflected path is long; "
        "infinite where the sky is reflected; 0 where there is no image.",
        1),
    Input(
        "reflection_normal",
        "World-space unit normal of the reflected surface; zero or not given: that of the mirror.",
        3),
    Input("reflection_albedo",
          "Reflectance of the reflected surface, linear RGB, all its lobes together; not given: 1.",
          3),
    Input("reflection_motion", "Motion of the reflected image, as motion.", 2),
    Input("reflection_id", "Id of the reflected surface; not given: that of the mirror.", 1),
    Input("refraction_depth",
          "Virtual guides of transmitted light, of the image seen through the first surface: as "
          "reflection_depth, for the refracted path.",
          1),
    Input("refraction_normal", "World-space unit normal of what is seen through the surface.", 3),
    Input("refraction_albedo", "Its reflectance, linear RGB.", 3),
    Input("refraction_motion", "Motion of the refracted image, as motion.", 2),
    Input("refraction_id", "Its id.", 1),
    Input(
        "confidence",
        "How far the light of the last frame still holds at what a pixel shows, 0 to 1: the length "
        "that its history counts for is multiplied by it; 0: that history is dropped; not given: "
        "1 everywhere.",
        1),
    Input("emission", "Light that the first surface emits: added after filtering, linear RGB.", 3),
    Input("background", "Light of rays that left the scene: added after filtering, linear RGB.", 3),
    Input("samples",
          "Samples that each pixel got in this frame, 0 where it is missing; not "
          "given: 1 everywhere.",
          1),
};

const stillray_image* Find(const ImageMap& images, std::string_view name) {
  const auto at = images.find(name);
  return at == images.end() ? nullptr : &at->second;
}

template <typename T>
void Fit(const Frame& frame, Plane<T>* plane) {
  if (plane->width() != frame.width || plane->height() != frame.height) {
    *plane = Plane<T>(frame.width, frame.height);
  }
}

void Load(const ImageMap& images, std::string_view name, const Frame& frame, Image1* plane) {
  const stillray_image* image = Find(images, name);
  if (image == nullptr) {
    *plane = Image1();
    return;
  }
  Fit(frame, plane);
  ReadChannel(*image, 0, plane);
}

/// One pixel in place of a given image.
template <typename Image>
void Mark(const ImageMap& images, std::string_view name, Image* image) {
  *image = Find(images, name) != nullptr ? Image(1, 1) : Image();
}

template <int N>
void Load(const ImageMap& images, std::string_view name, const Frame& frame,
          Planes<float, N>* planes) {
  const stillray_image* image = Find(images, name);
  for (int c = 0; c < N; ++c) {
    Image1& plane = (*planes)[c];
    if (image == nullptr) {
      plane = Image1();
      continue;
    }
    Fit(frame, &plane);
    ReadChannel(*image, c, &plane);
  }
}

void LoadIds(const ImageMap& images, std::string_view name, const Frame& frame,
             Plane<uint32_t>* ids) {
  const stillray_image* image = Find(images, name);
  if (image == nullptr) {
    *ids = Plane<uint32_t>();
    return;
  }
  Fit(frame, ids);
  ReadIds(*image, ids);
}

void LoadVirtualGuides(const ImageMap& images, const std::string& of, const Frame& frame,
                       VirtualGuides* guides) {
  Load(images, of + "_depth", frame, &guides->depth);
  Load(images, of + "_normal", frame, &guides->normal);
  Load(images, of + "_albedo", frame, &guides->albedo);
  Load(images, of + "_motion", frame, &guides->motion);
  LoadIds(images, of + "_id", frame, &guides->id);
}

void MarkVirtualGuides(const ImageMap& images, const std::string& of, VirtualGuides* guides) {
  Mark(images, of + "_depth", &guides->depth);
  Mark(images, of + "_normal", &guides->normal);
  Mark(images, of + "_albedo", &guides->albedo);
  Mark(images, of + "_motion", &guides->motion);
  Mark(images, of + "_id", &guides->id);
}

void LoadSignals(const ImageMap& images, Frame* frame) {
  std::vector<Signal> before = std::move(frame->signals);
  frame->signals.clear();
  for (int k = 0; k < kSignalKindCount; ++k) {
    const auto kind = static_cast<SignalKind>(k);
    const std::string name = SignalName(kind);
    if (Find(images, name) == nullptr) {
      continue;
    }
    const auto old =
        std::find_if(before.begin(), before.end(), [&](const Signal& s) { return s.kind == kind; });
    Signal signal = old == before.end() ? Signal() : std::move(*old);
    signal.kind = kind;
    Load(images, name, *frame, &signal.radiance);
    Load(images, name + ".second_moment", *frame, &signal.second_moment);
    frame->signals.push_back(std::move(signal));
  }
}

}  // namespace

std::span<const stillray_input_info> Inputs() {
  return kInputs;
}

const stillray_input_info* FindInput(std::string_view name) {
  const auto at = std::find_if(kInputs.begin(), kInputs.end(),
                               [&](const stillray_input_info& i) { return name == i.name; });
  return at == kInputs.end() ? nullptr : &*at;
}

bool IsId(std::string_view name) {
  return name == "id" || name == "reflection_id" || name == "refraction_id";
}

void LoadFrame(const ImageMap& images, Frame* frame) {
  LoadSignals(images, frame);
  Guides& g = frame->guides;
  Load(images, "depth", *frame, &g.depth);
  Load(images, "normal", *frame, &g.normal);
  Load(images, "albedo", *frame, &g.albedo);
  Load(images, "specular_albedo", *frame, &g.specular_albedo);
  Load(images, "transmission_albedo", *frame, &g.transmission_albedo);
  Load(images, "motion", *frame, &g.motion);
  Load(images, "previous_normal", *frame, &g.previous_normal);
  Load(images, "roughness", *frame, &g.roughness);
  Load(images, "emission", *frame, &frame->emission);
  Load(images, "background", *frame, &frame->background);
  Load(images, "samples", *frame, &frame->samples);
  Load(images, "confidence", *frame, &frame->confidence);
  LoadIds(images, "id", *frame, &g.id);
  LoadVirtualGuides(images, "reflection", *frame, &frame->reflection);
  LoadVirtualGuides(images, "refraction", *frame, &frame->refraction);
}

void LoadNextMotion(const ImageMap& images, const Frame& frame, Image2* motion) {
  Load(images, "next_motion", frame, motion);
}

void MarkImages(const ImageMap& images, Frame* shape) {
  for (int k = 0; k < kSignalKindCount; ++k) {
    const auto kind = static_cast<SignalKind>(k);
    const std::string name = SignalName(kind);
    Signal signal = {kind, Image3(), Image1()};
    Mark(images, name, &signal.radiance);
    Mark(images, name + ".second_moment", &signal.second_moment);
    if (!signal.radiance.empty()) {
      shape->signals.push_back(std::move(signal));
    }
  }
  Guides& g = shape->guides;
  Mark(images, "depth", &g.depth);
  Mark(images, "normal", &g.normal);
  Mark(images, "albedo", &g.albedo);
  Mark(images, "specular_albedo", &g.specular_albedo);
  Mark(images, "transmission_albedo", &g.transmission_albedo);
  Mark(images, "motion", &g.motion);
  Mark(images, "previous_normal", &g.previous_normal);
  Mark(images, "id", &g.id);
  Mark(images, "roughness", &g.roughness);
  MarkVirtualGuides(images, "reflection", &shape->reflection);
  MarkVirtualGuides(images, "refraction", &shape->refraction);
  Mark(images, "emission", &shape->emission);
  Mark(images, "background", &shape->background);
  Mark(images, "samples", &shape->samples);
  Mark(images, "confidence", &shape->confidence);
}

}  // namespace stillray::capi
