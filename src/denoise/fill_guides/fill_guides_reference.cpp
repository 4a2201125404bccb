// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The scalar version of fill_guides: pixel by pixel, plane by plane.
#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/fill_guides/held_guides.h"

namespace stillray::reference {
namespace {

template <typename Visit>
void ForPixels(const Frame& frame, const Visit& visit) {
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      visit(x, y);
    }
  }
}

bool IsKnown(const Frame& frame, int x, int y) {
  return frame.guides.depth(x, y) != 0 || frame.samples(x, y) > 0;
}

/// Copies the guides of known pixels.
void CopyKnown(const Frame& frame, HeldGuides* held) {
  const HeldPlanes planes = PlanesOf(frame, held);
  ForPixels(frame, [&](int x, int y) {
    if (!IsKnown(frame, x, y)) {
      return;
    }
    held->known(x, y) = 1;
    held->guides.depth(x, y) = frame.guides.depth(x, y);
    for (const HeldPlane& plane : planes) {
      (*plane.held)(x, y) = (*plane.from)(x, y);
    }
    if (!held->guides.id.empty()) {
      held->guides.id(x, y) = frame.guides.id(x, y);
    }
  });
}

/// Fills the motion of every pixel from that of the known pixels.
void FillMotion(const Frame& frame, bool moves, Image2* motion) {
  Image1 known(frame.width, frame.height);
  ForPixels(frame, [&](int x, int y) { known(x, y) = IsKnown(frame, x, y) ? 1.0f : 0.0f; });
  for (int c = 0; c < 2; ++c) {
    if (moves) {
      (*motion)[c] = frame.guides.motion[c];
      FillHoles(known, &(*motion)[c]);
    } else {
      (*motion)[c].Fill(0.0f);
    }
  }
}

/// Rejects held pixels of surfaces that known pixels contradict.
void RejectGhosts(const Frame& frame, const Guides& now, const Shift& shift, int radius,
                  HeldGuides* before) {
  Image1 known = before->known;
  ForPixels(frame, [&](int x, int y) {
    int qx = 0;
    int qy = 0;
    if (!IsKnown(frame, x, y) || !shift.Find(now.motion, x, y, &qx, &qy) ||
        !(before->known(qx, qy) > 0) ||
        !AreDifferentSurfaces(frame.guides, x, y, before->guides, qx, qy)) {
      return;
    }
    for (int by = std::max(qy - radius, 0); by <= std::min(qy + radius, frame.height - 1); ++by) {
      for (int bx = std::max(qx - radius, 0); bx <= std::min(qx + radius, frame.width - 1); ++bx) {
        if (!AreDifferentSurfaces(before->guides, bx, by, before->guides, qx, qy)) {
          known(bx, by) = 0;
        }
      }
    }
  });
  before->known = known;
}

/// Gathers held guides along the motion where the frame has none; the remaining pixels are holes.
void GatherHeld(const Frame& frame, const Shift& shift, HeldGuides* before, HeldGuides* now) {
  const HeldPlanes from = PlanesOf(frame, before);
  const HeldPlanes to = PlanesOf(frame, now);
  ForPixels(frame, [&](int x, int y) {
    int qx = 0;
    int qy = 0;
    if (IsKnown(frame, x, y)) {
      return;
    }
    now->known(x, y) = 0;
    if (!shift.Find(now->guides.motion, x, y, &qx, &qy) || !(before->known(qx, qy) > 0)) {
      return;
    }
    now->known(x, y) = 1;
    now->guides.depth(x, y) = before->guides.depth(qx, qy);
    for (int i = 0; i < to.count; ++i) {
      (*to.begin()[i].held)(x, y) = (*from.begin()[i].held)(qx, qy);
    }
    if (!now->guides.id.empty()) {
      now->guides.id(x, y) = before->guides.id(qx, qy);
    }
  });
}

/// The plane with its holes filled; zero everywhere if nothing is known.
Image1 Filled(const Image1& known, Image1 plane) {
  if (!FillHoles(known, &plane)) {
    plane.Fill(0.0f);
  }
  return plane;
}

/// Fills the holes of all planes.
void FillAllHoles(const Frame& frame, HeldGuides* held) {
  Image1 surface(frame.width, frame.height);
  Image1 sky(frame.width, frame.height);
  Image1 inverse_depth(frame.width, frame.height);
  ForPixels(frame, [&](int x, int y) {
    if (held->known(x, y) > 0) {
      const float z = held->guides.depth(x, y);
      surface(x, y) = IsSurface(z) ? 1.0f : 0.0f;
      sky(x, y) = IsSurface(z) ? 0.0f : 1.0f;
      inverse_depth(x, y) = IsSurface(z) ? 1.0f / z : 0.0f;
    }
  });
  const Image1 part = Filled(held->known, surface);
  inverse_depth = Filled(surface, std::move(inverse_depth));
  const auto is_surface = [&](int x, int y) {
    return part(x, y) >= 0.5f && inverse_depth(x, y) > 0;
  };
  ForPixels(frame, [&](int x, int y) {
    if (!(held->known(x, y) > 0)) {
      held->guides.depth(x, y) =
          is_surface(x, y) ? 1.0f / inverse_depth(x, y) : std::numeric_limits<float>::infinity();
    }
  });
  for (const HeldPlane& plane : PlanesOf(frame, held)) {
    const bool of_sky = plane.rule == FillRule::kSkyOnly;
    const Image1 filled = Filled(of_sky ? sky : surface, *plane.held);
    ForPixels(frame, [&](int x, int y) {
      if (!(held->known(x, y) > 0)) {
        const bool zero = plane.rule != FillRule::kAnywhere && is_surface(x, y) == of_sky;
        (*plane.held)(x, y) = zero ? 0.0f : filled(x, y);
      }
    });
  }
  if (!held->guides.id.empty()) {
    Plane<uint32_t> filled = held->guides.id;
    FillIds(surface, &filled);
    ForPixels(frame, [&](int x, int y) {
      if (!(held->known(x, y) > 0)) {
        held->guides.id(x, y) = is_surface(x, y) ? filled(x, y) : 0u;
      }
    });
  }
}

}  // namespace

void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work) {
  if (!Fits(*held, frame)) {
    *held = HeldGuides();
  }
  bool moves = false;
  VisibleLight seen = {!held->emission.empty(), !held->background.empty()};
  int64_t count = 0;
  const auto has_light = [](const Image3& light, int x, int y) {
    return !light.empty() && (light[0](x, y) != 0 || light[1](x, y) != 0 || light[2](x, y) != 0);
  };
  ForPixels(frame, [&](int x, int y) {
    if (IsKnown(frame, x, y)) {
      const Image2& motion = frame.guides.motion;
      moves = moves || IsMoving(motion[0](x, y)) || IsMoving(motion[1](x, y));
      seen.emission = seen.emission || has_light(frame.emission, x, y);
      seen.background = seen.background || has_light(frame.background, x, y);
      ++count;
    }
  });
  moves = moves && !held->empty();
  if (moves) {
    std::swap(*held, work->before);
    MakeRoom(frame, seen, &work->before);
  }
  MakeRoom(frame, seen, held);
  held->motionless = held->first_level_valid = false;
  CopyKnown(frame, held);
  FillMotion(frame, moves, &held->guides.motion);
  if (moves) {
    const Shift shift(frame.index);
    RejectGhosts(frame, held->guides, shift, GhostRadius(frame, count), &work->before);
    GatherHeld(frame, shift, &work->before, held);
  }
  FillAllHoles(frame, held);
}

}  // namespace stillray::reference
