// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/sparse_guides.h"

#include <atomic>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "denoise/stage_table.h"

namespace stillray {
namespace {

constexpr int kBand = 16;
/// Below this many pixels per frame nothing moves.
constexpr float kStill = 1e-3f;
/// Change of inverse depth that shows another surface, where there are no ids.
constexpr float kOtherDepth = 0.1f;

/// The same planes of two or three sets of guides, in one order.
template <typename Guides_, typename Emission, typename Plane_>
void ListPlanes(Guides_& g, Emission& emission, Emission& background, std::vector<Plane_*>* list) {
  for (auto* image :
       {&g.normal, &g.albedo, &g.specular_albedo, &g.transmission_albedo, &emission, &background}) {
    for (auto& plane : image->channel) {
      list->push_back(&plane);
    }
  }
  list->push_back(&g.roughness);
}

std::vector<const Image1*> PlanesOf(const Frame& frame) {
  std::vector<const Image1*> list;
  ListPlanes(frame.guides, frame.emission, frame.background, &list);
  return list;
}

std::vector<Image1*> PlanesOf(HeldGuides* held) {
  std::vector<Image1*> list;
  ListPlanes(held->guides, held->emission, held->background, &list);
  return list;
}

void MakeRoom(const Frame& frame, HeldGuides* held) {
  const auto match = [&](bool given, Image1* plane) {
    const bool fits = plane->width() == frame.width && plane->height() == frame.height;
    if (given && !fits) {
      *plane = Image1(frame.width, frame.height);
    } else if (!given) {
      *plane = Image1();
    }
  };
  for (Image1* plane : {&held->known, &held->surface, &held->inverse_depth, &held->guides.depth,
                        &held->guides.motion[0], &held->guides.motion[1]}) {
    match(true, plane);
  }
  const std::vector<const Image1*> from = PlanesOf(frame);
  const std::vector<Image1*> to = PlanesOf(held);
  for (size_t i = 0; i < from.size(); ++i) {
    match(!from[i]->empty(), to[i]);
  }
  Plane<uint32_t>& id = held->guides.id;
  if (frame.guides.id.empty()) {
    id = Plane<uint32_t>();
  } else if (id.width() != frame.width || id.height() != frame.height) {
    id = Plane<uint32_t>(frame.width, frame.height);
  }
}

bool Fits(const HeldGuides& held, const Frame& frame) {
  if (held.known.width() != frame.width || held.known.height() != frame.height ||
      held.guides.id.empty() != frame.guides.id.empty()) {
    return false;
  }
  std::vector<const Image1*> planes;
  ListPlanes(held.guides, held.emission, held.background, &planes);
  const std::vector<const Image1*> given = PlanesOf(frame);
  for (size_t i = 0; i < given.size(); ++i) {
    if (planes[i]->empty() != given[i]->empty()) {
      return false;
    }
  }
  return true;
}

/// Marks what this frame knows. \return the part of the picture that it knows
double FindKnown(const Frame& frame, Image1* known) {
  std::atomic<int64_t> count = 0;
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    int64_t sum = 0;
    for (int y = y0; y < y1; ++y) {
      const float* depth = frame.guides.depth.Row(y);
      const float* samples = frame.samples.Row(y);
      float* to = known->Row(y);
      for (int x = 0; x < frame.width; ++x) {
        const bool is_known = depth[x] != 0 || samples[x] > 0;
        to[x] = is_known ? 1.0f : 0.0f;
        sum += is_known;
      }
    }
    count += sum;
  });
  return static_cast<double>(count) / (static_cast<double>(frame.width) * frame.height);
}

bool Moves(const Frame& frame, const Image1& known) {
  std::atomic<bool> moves = false;
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* mx = frame.guides.motion[0].Row(y);
      const float* my = frame.guides.motion[1].Row(y);
      for (int x = 0; x < frame.width; ++x) {
        if (known(x, y) > 0 && !(std::abs(mx[x]) <= kStill && std::abs(my[x]) <= kStill)) {
          moves = true;
          return;
        }
      }
    }
  });
  return moves;
}

/// Takes this frame's guides at the pixels where it has any.
void TakeKnown(const Frame& frame, const Image1& known, HeldGuides* held) {
  const std::vector<const Image1*> from = PlanesOf(frame);
  const std::vector<Image1*> to = PlanesOf(held);
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < frame.width; ++x) {
        if (!(known(x, y) > 0)) {
          continue;
        }
        const float z = frame.guides.depth(x, y);
        const bool surface = std::isfinite(z) && z > 0;
        held->known(x, y) = 1;
        held->surface(x, y) = surface ? 1.0f : 0.0f;
        held->inverse_depth(x, y) = surface ? 1.0f / z : 0.0f;
        held->guides.depth(x, y) = z;
        for (size_t i = 0; i < from.size(); ++i) {
          if (!from[i]->empty()) {
            (*to[i])(x, y) = (*from[i])(x, y);
          }
        }
        if (!held->guides.id.empty()) {
          held->guides.id(x, y) = frame.guides.id(x, y);
        }
      }
    }
  });
}

/// Motion of every pixel, from what this frame knows of it.
void FillMotion(const Frame& frame, const Image1& known, bool moves, const StageTable& stages,
                FillPyramid* pyramid, Image2* motion) {
  for (int c = 0; c < 2; ++c) {
    Image1& plane = (*motion)[c];
    if (!moves) {
      plane.Fill(0.0f);
      continue;
    }
    ParallelRows(plane.height(), kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        std::copy_n(frame.guides.motion[c].Row(y), plane.width(), plane.Row(y));
      }
    });
  }
  if (moves) {
    Image1* const planes[] = {&(*motion)[0], &(*motion)[1]};
    stages.fill_holes(known, std::span<Image1* const>(planes), pyramid);
  }
}

/// Where a frame's held guides are looked up: along the motion, rounded up or down so that over
/// many frames of slow motion the mean is right.
struct Shift {
  float x;
  float y;

  explicit Shift(int64_t frame)
      : x(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.7548776662466927, 1.0))),
        y(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.5698402909980532, 1.0))) {}

  /// \return whether the place lies in the picture
  bool Find(const Image2& motion, int x0, int y0, int* qx, int* qy) const {
    const float px = std::floor(static_cast<float>(x0) + motion[0](x0, y0) + x);
    const float py = std::floor(static_cast<float>(y0) + motion[1](x0, y0) + y);
    if (!(px >= 0 && py >= 0 && px < static_cast<float>(motion.width()) &&
          py < static_cast<float>(motion.height()))) {
      return false;
    }
    *qx = static_cast<int>(px);
    *qy = static_cast<int>(py);
    return true;
  }
};

bool Differ(const HeldGuides& a, int ax, int ay, const HeldGuides& b, int bx, int by) {
  if (a.surface(ax, ay) != b.surface(bx, by)) {
    return true;
  }
  if (!a.guides.id.empty()) {
    return a.guides.id(ax, ay) != b.guides.id(bx, by);
  }
  const float i = a.inverse_depth(ax, ay);
  return std::abs(i - b.inverse_depth(bx, by)) > kOtherDepth * i;
}

/// Marks the held pixels that what is known now speaks against.
void BlockGhosts(const HeldGuides& before, const HeldGuides& now, const Image1& known,
                 const Shift& shift, double part_known, Image1* blocked) {
  const int width = known.width();
  const int height = known.height();
  blocked->Fill(0.0f);
  const int radius =
      std::min(16, static_cast<int>(std::ceil(0.75 / std::sqrt(std::max(part_known, 1e-4)))));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int qx = 0;
      int qy = 0;
      if (!(known(x, y) > 0) || !shift.Find(now.guides.motion, x, y, &qx, &qy) ||
          !(before.known(qx, qy) > 0) || !Differ(now, x, y, before, qx, qy)) {
        continue;
      }
      for (int by = std::max(qy - radius, 0); by <= std::min(qy + radius, height - 1); ++by) {
        for (int bx = std::max(qx - radius, 0); bx <= std::min(qx + radius, width - 1); ++bx) {
          if (!Differ(before, bx, by, before, qx, qy)) {
            (*blocked)(bx, by) = 1.0f;
          }
        }
      }
    }
  }
}

/// Takes what earlier frames knew along the motion; marks as unknown what nobody knows.
void TakeHeld(HeldGuides& before, const Image1& known_now, const Image1& blocked,
              const Shift& shift, HeldGuides* now) {
  const std::vector<Image1*> from = PlanesOf(&before);
  const std::vector<Image1*> to = PlanesOf(now);
  ParallelRows(known_now.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < known_now.width(); ++x) {
        if (known_now(x, y) > 0) {
          continue;
        }
        int qx = 0;
        int qy = 0;
        now->known(x, y) = 0;
        if (!shift.Find(now->guides.motion, x, y, &qx, &qy) || !(before.known(qx, qy) > 0) ||
            blocked(qx, qy) > 0) {
          continue;
        }
        now->known(x, y) = 1;
        now->surface(x, y) = before.surface(qx, qy);
        now->inverse_depth(x, y) = before.inverse_depth(qx, qy);
        now->guides.depth(x, y) = before.guides.depth(qx, qy);
        for (size_t i = 0; i < from.size(); ++i) {
          if (!from[i]->empty()) {
            (*to[i])(x, y) = (*from[i])(qx, qy);
          }
        }
        if (!now->guides.id.empty()) {
          now->guides.id(x, y) = before.guides.id(qx, qy);
        }
      }
    }
  });
}

bool AllKnown(const Image1& known) {
  std::atomic<bool> all = true;
  ParallelRows(known.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* row = known.Row(y);
      if (std::any_of(row, row + known.width(), [](float k) { return !(k > 0); })) {
        all = false;
      }
    }
  });
  return all;
}

/// Guesses the rest: first whether a hole shows a surface, then its guides from surfaces alone, its
/// background from the sky alone.
void FillRest(const StageTable& stages, SparseGuidesWork* work, HeldGuides* held) {
  Image1* const kind[] = {&held->surface};
  if (!stages.fill_holes(held->known, std::span<Image1* const>(kind), &work->pyramid)) {
    held->surface.Fill(0.0f);  // nothing is known at all: a picture of sky
  }
  Image1& on_surface = work->known_now;
  Image1& in_sky = work->blocked;
  const auto mark = [&](float surface, Image1* mask) {
    ParallelRows(mask->height(), kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        for (int x = 0; x < mask->width(); ++x) {
          (*mask)(x, y) = held->known(x, y) > 0 && held->surface(x, y) == surface ? 1.0f : 0.0f;
        }
      }
    });
  };
  mark(1.0f, &on_surface);
  mark(0.0f, &in_sky);
  std::vector<Image1*> planes = {&held->inverse_depth};
  for (Image3* image : {&held->guides.normal, &held->guides.albedo, &held->guides.specular_albedo,
                        &held->guides.transmission_albedo, &held->emission}) {
    for (Image1& plane : image->channel) {
      planes.push_back(&plane);
    }
  }
  planes.push_back(&held->guides.roughness);
  std::erase_if(planes, [](const Image1* plane) { return plane->empty(); });
  // Zero where there is no surface at all: fill_holes then leaves what stands there.
  stages.fill_holes(on_surface, planes, &work->pyramid);
  if (!held->guides.id.empty()) {
    stages.fill_ids(on_surface, &held->guides.id, &work->pyramid);
  }
  if (!held->background.empty()) {
    Image1* const sky[] = {&held->background[0], &held->background[1], &held->background[2]};
    stages.fill_holes(in_sky, std::span<Image1* const>(sky), &work->pyramid);
  }
  ParallelRows(held->known.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < held->known.width(); ++x) {
        const bool known = held->known(x, y) > 0;
        const bool surface = held->surface(x, y) >= 0.5f && held->inverse_depth(x, y) > 0;
        if (!known) {
          held->surface(x, y) = surface ? 1.0f : 0.0f;
          held->guides.depth(x, y) =
              surface ? 1.0f / held->inverse_depth(x, y) : std::numeric_limits<float>::infinity();
        }
        // Filling wrote surfaces into known sky and sky onto known surfaces.
        if (!surface) {
          held->inverse_depth(x, y) = 0;
          for (int c = 0; c < 3; ++c) {
            held->guides.normal[c](x, y) = 0;
            if (!held->emission.empty()) {
              held->emission[c](x, y) = 0;
            }
          }
          if (!held->guides.id.empty()) {
            held->guides.id(x, y) = 0;
          }
        } else if (!held->background.empty()) {
          for (int c = 0; c < 3; ++c) {
            held->background[c](x, y) = 0;
          }
        }
      }
    }
  });
}

}  // namespace

size_t HeldGuides::bytes() const {
  size_t sum = guides.id.bytes();
  VisitHeldPlanes(*this, [&](const Image1& plane) { sum += plane.bytes(); });
  return sum;
}

size_t SparseGuidesWork::bytes() const {
  return before.bytes() + known_now.bytes() + blocked.bytes() + pyramid.bytes();
}

bool HasUnknownGuides(const Frame& frame) {
  if (frame.samples.empty()) {
    return false;
  }
  std::atomic<bool> any = false;
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1 && !any; ++y) {
      const float* depth = frame.guides.depth.Row(y);
      const float* samples = frame.samples.Row(y);
      for (int x = 0; x < frame.width; ++x) {
        if (depth[x] == 0 && !(samples[x] > 0)) {
          any = true;
          break;
        }
      }
    }
  });
  return any;
}

void CompleteGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                    SparseGuidesWork* work) {
  if (!Fits(*held, frame)) {
    *held = HeldGuides();
  }
  const bool first = held->empty();
  if (work->known_now.width() != frame.width || work->known_now.height() != frame.height) {
    work->known_now = Image1(frame.width, frame.height);
    work->blocked = Image1(frame.width, frame.height);
  }
  const double part = FindKnown(frame, &work->known_now);
  const bool moves = !first && Moves(frame, work->known_now);
  if (moves) {
    std::swap(*held, work->before);
  }
  MakeRoom(frame, held);
  TakeKnown(frame, work->known_now, held);
  FillMotion(frame, work->known_now, moves, stages, &work->pyramid, &held->guides.motion);
  if (moves) {
    const Shift shift(frame.index);
    BlockGhosts(work->before, *held, work->known_now, shift, part, &work->blocked);
    TakeHeld(work->before, work->known_now, work->blocked, shift, held);
  }
  if (!AllKnown(held->known)) {
    FillRest(stages, work, held);
  }
}

}  // namespace stillray
