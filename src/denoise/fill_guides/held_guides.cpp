// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/fill_guides/held_guides.h"

#include <utility>

namespace stillray {
namespace {

bool HasSize(const Frame& frame, int width, int height) {
  return width == frame.width && height == frame.height;
}

template <typename T>
void MakePlane(const Frame& frame, bool wanted, Plane<T>* plane) {
  if (!wanted) {
    *plane = Plane<T>();
  } else if (!HasSize(frame, plane->width(), plane->height())) {
    *plane = Plane<T>(frame.width, frame.height);
  }
}

template <int N>
void MakePlanes(const Frame& frame, bool wanted, Planes<float, N>* planes) {
  for (Image1& plane : planes->channel) {
    MakePlane(frame, wanted, &plane);
  }
}

}  // namespace

size_t HeldGuides::bytes() const {
  size_t sum = guides.id.bytes();
  VisitHeldPlanes(*this, [&](const Image1& plane) { sum += plane.bytes(); });
  return sum;
}

HeldPlanes PlanesOf(const Frame& frame, HeldGuides* held) {
  HeldPlanes list;
  const auto add = [&](const Image3& from, Image3* to, FillRule rule) {
    for (int c = 0; c < 3 && !to->empty(); ++c) {
      list.plane[static_cast<size_t>(list.count++)] = {&from[c], &(*to)[c], rule};
    }
  };
  Guides& g = held->guides;
  add(frame.guides.normal, &g.normal, FillRule::kSurfaceOnly);
  add(frame.guides.albedo, &g.albedo, FillRule::kAnywhere);
  add(frame.guides.specular_albedo, &g.specular_albedo, FillRule::kAnywhere);
  add(frame.guides.transmission_albedo, &g.transmission_albedo, FillRule::kAnywhere);
  add(frame.emission, &held->emission, FillRule::kSurfaceOnly);
  add(frame.background, &held->background, FillRule::kSkyOnly);
  return list;
}

bool Fits(const HeldGuides& held, const Frame& frame) {
  const auto fits = [&](const auto& plane, bool required, bool given) {
    return plane.empty() ? !required : given && HasSize(frame, plane.width(), plane.height());
  };
  const auto all_fit = [&](const auto& planes, bool required, bool given) {
    return std::all_of(planes.channel.begin(), planes.channel.end(),
                       [&](const Image1& plane) { return fits(plane, required, given); });
  };
  const Guides& h = held.guides;
  const Guides& g = frame.guides;
  bool fit = fits(held.known, true, true) && fits(h.depth, true, true) &&
             all_fit(h.motion, true, true) && fits(h.id, !g.id.empty(), !g.id.empty());
  for (const auto& [image, given] :
       {std::pair{&h.normal, &g.normal}, std::pair{&h.albedo, &g.albedo},
        std::pair{&h.specular_albedo, &g.specular_albedo},
        std::pair{&h.transmission_albedo, &g.transmission_albedo}}) {
    fit = fit && all_fit(*image, !given->empty(), !given->empty());
  }
  for (const auto& [image, given] : {std::pair{&held.emission, &frame.emission},
                                     std::pair{&held.background, &frame.background}}) {
    fit = fit && all_fit(*image, !image->empty(), !given->empty());
  }
  return fit;
}

void MakeRoom(const Frame& frame, const VisibleLight& seen, HeldGuides* held) {
  const bool fits = Fits(*held, frame);
  const bool complete = fits && seen.emission != held->emission.empty() &&
                        seen.background != held->background.empty();
  if (complete) {
    return;
  }
  if (!fits) {
    *held = HeldGuides();
  }
  held->first_level_valid = false;
  Guides& h = held->guides;
  const Guides& g = frame.guides;
  MakePlane(frame, true, &held->known);
  MakePlane(frame, true, &h.depth);
  MakePlane(frame, !g.id.empty(), &h.id);
  MakePlanes(frame, true, &h.motion);
  MakePlanes(frame, !g.normal.empty(), &h.normal);
  MakePlanes(frame, !g.albedo.empty(), &h.albedo);
  MakePlanes(frame, !g.specular_albedo.empty(), &h.specular_albedo);
  MakePlanes(frame, !g.transmission_albedo.empty(), &h.transmission_albedo);
  MakePlanes(frame, seen.emission, &held->emission);
  MakePlanes(frame, seen.background, &held->background);
}

}  // namespace stillray
