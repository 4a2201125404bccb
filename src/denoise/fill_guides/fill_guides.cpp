// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The stage is limited by memory bandwidth: some twenty planes, of which one pixel in a hundred is
// known. It therefore makes only two passes over each plane, by rows of pyramid cells: GatherKnown,
// which also downsamples to the first level (in a static view only cells with new pixels), and
// FillHoles. The higher levels cost an eighth of the time.
#include "denoise/fill_guides/fill_guides.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "core/parallel.h"
#include "denoise/fill_guides/fill_guides_task.h"
#include "denoise/stage_table.h"

namespace stillray {

void RowLists::Resize(int width, int height) {
  constexpr int kVector = 64;
  const auto stride = static_cast<size_t>(width) + kVector;
  if (stride != stride_ || counts_.size() != static_cast<size_t>(height)) {
    stride_ = stride;
    values_.resize(stride * static_cast<size_t>(height));
    counts_.resize(static_cast<size_t>(height));
  }
}

size_t FillGuidesWork::bytes() const {
  size_t sum = before.bytes() + known_now.bytes() + ghosts.bytes() + surface.bytes() +
               inverse_depth.bytes() + id.bytes();
  for (const PyramidMask& levels : mask) {
    sum += levels.bytes();
  }
  for (const Pyramid& levels : plane) {
    sum += levels.bytes();
  }
  for (const Pyramid& levels : motion) {
    sum += levels.bytes();
  }
  return sum;
}

bool HasIncompleteGuides(const Frame& frame) {
  if (frame.samples.empty()) {
    return false;
  }
  std::atomic<bool> any = false;
  ParallelRows(frame.height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1 && !any; ++y) {
      const float* depth = frame.guides.depth.Row(y);
      const float* samples = frame.samples.Row(y);
      int unknown = 0;  // a sum without early exit, which the compiler vectorises
      for (int x = 0; x < frame.width; ++x) {
        unknown |= static_cast<int>(depth[x] == 0) & static_cast<int>(!(samples[x] > 0));
      }
      if (unknown != 0) {
        any = true;
      }
    }
  });
  return any;
}

void FillGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                FillGuidesWork* work) {
  stages.fill_guides(frame, held, work);
}

}  // namespace stillray

namespace stillray::cpu {
namespace {

using Work = FillGuidesWork;
using Task = FillGuidesTask;

struct KnownPixels {
  int64_t count = 0;
  bool moves = false;
  VisibleLight seen;
};

bool HasLight(const Image3& light, int x, int y) {
  return !light.empty() && (light[0](x, y) != 0 || light[1](x, y) != 0 || light[2](x, y) != 0);
}

/// Lists the known pixels. \return whether any of them has motion, or emission or background for
/// which `held` has no planes
KnownPixels FindKnown(const Frame& frame, const HeldGuides& held, RowLists* list) {
  std::atomic<int64_t> count = 0;
  std::atomic<bool> moves = false;
  std::atomic<bool> emission = !held.emission.empty();
  std::atomic<bool> background = !held.background.empty();
  ParallelRows(frame.height, kRowBand, [&](int y0, int y1) {
    count += ListKnown(frame, y0, y1, list);
    for (int y = y0; y < y1; ++y) {
      for (const int32_t x : list->Row(y)) {
        if (!moves &&
            (IsMoving(frame.guides.motion[0](x, y)) || IsMoving(frame.guides.motion[1](x, y)))) {
          moves = true;
        }
        if (!emission && HasLight(frame.emission, x, y)) {
          emission = true;
        }
        if (!background && HasLight(frame.background, x, y)) {
          background = true;
        }
      }
    }
  });
  return {count, moves, {emission, background}};
}

/// Lists held pixels that contradict known ones.
void FindGhosts(const Task& t) {
  t.work->ghosts.Resize(t.width(), t.height());
  const Guides& now = t.frame->guides;
  ParallelRows(t.height(), kRowBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      int32_t* to = t.work->ghosts.Begin(y);
      int count = 0;
      for (const int32_t x : t.work->known_now.Row(y)) {
        int qx = 0;
        int qy = 0;
        if (t.shift.Find(now.motion, x, y, &qx, &qy) && t.before->known(qx, qy) > 0 &&
            AreDifferentSurfaces(now, x, y, t.before->guides, qx, qy)) {
          to[count++] = qy * t.width() + qx;
        }
      }
      t.work->ghosts.SetCount(y, count);
    }
  });
}

/// Rejects held pixels of the same surface around ghosts. Each band reads all ghosts and writes its
/// own rows.
void RejectGhosts(const Task& t, int radius) {
  const Guides& g = t.before->guides;
  ParallelRows(t.height(), kRowBand, [&](int y0, int y1) {
    for (int row = 0; row < t.height(); ++row) {
      for (const int32_t q : t.work->ghosts.Row(row)) {
        const int qx = q % t.width();
        const int qy = q / t.width();
        for (int y = std::max(qy - radius, y0); y < std::min(qy + radius + 1, y1); ++y) {
          float* known = t.before->known.Row(y);
          for (int x = std::max(qx - radius, 0); x <= std::min(qx + radius, t.width() - 1); ++x) {
            if (known[x] > 0 && !AreDifferentSurfaces(g, x, y, g, qx, qy)) {
              known[x] = 0;
            }
          }
        }
      }
    }
  });
}

/// Computes the motion of this frame on all levels.
void FillMotion(const Task& t) {
  DownsampleMotion(t);
  const PyramidMask& mask = t.work->mask[Work::kNew];
  DownsampleMask(&t.work->mask[Work::kNew]);
  tbb::parallel_for(0, 2,
                    [&](int k) { FillPyramid(mask, &t.work->motion[static_cast<size_t>(k)]); });
}

/// Fills all levels of the pyramids, in parallel over planes.
void FillPyramids(const Task& t) {
  Work& w = *t.work;
  for (const Work::Kind kind : t.kinds()) {
    DownsampleMask(&w.mask[kind]);
  }
  tbb::parallel_for(-3, t.planes.count, [&](int i) {
    if (i >= 0) {
      FillPyramid(w.mask[t.KindOf(i)], &w.plane[static_cast<size_t>(i)]);
    } else if (i == -1) {
      FillPyramid(w.mask[Work::kAny], &w.surface);
    } else if (i == -2) {
      FillPyramid(w.mask[Work::kSurface], &w.inverse_depth);
    } else if (!t.held->guides.id.empty()) {
      FillPyramid(w.mask[Work::kSurface], &w.id);
    }
  });
}

bool HasHoles(const Image1& known) {
  std::atomic<bool> any = false;
  ParallelRows(known.height(), kRowBand, [&](int y0, int y1) {
    for (int y = y0; y < y1 && !any; ++y) {
      const float* row = known.Row(y);
      int holes = 0;
      for (int x = 0; x < known.width(); ++x) {
        holes |= static_cast<int>(!(row[x] > 0));
      }
      if (holes != 0) {
        any = true;
      }
    }
  });
  return any;
}

void ResizePyramids(const Frame& frame, const HeldPlanes& planes, bool moves, Work* work) {
  const int w = frame.width;
  const int h = frame.height;
  for (PyramidMask& mask : work->mask) {
    ResizePyramid(w, h, &mask);
  }
  ResizePyramid(w, h, &work->surface);
  ResizePyramid(w, h, &work->inverse_depth);
  for (int i = 0; i < planes.count; ++i) {
    ResizePyramid(w, h, &work->plane[static_cast<size_t>(i)]);
  }
  for (Pyramid& levels : work->motion) {
    if (moves) {
      ResizePyramid(w, h, &levels);
    }
  }
  if (!frame.guides.id.empty()) {
    ResizePyramid(w, h, &work->id);
  }
}

void StopMotion(HeldGuides* held) {
  if (!held->motionless) {
    for (Image1& plane : held->guides.motion.channel) {
      plane.Fill(0.0f);
    }
    held->motionless = true;
  }
}

}  // namespace

void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work) {
  if (!Fits(*held, frame)) {
    *held = HeldGuides();
  }
  work->known_now.Resize(frame.width, frame.height);
  const KnownPixels found = FindKnown(frame, *held, &work->known_now);
  const bool moves = found.moves && !held->empty();
  if (moves) {
    std::swap(*held, work->before);
    MakeRoom(frame, found.seen, &work->before);
  }
  MakeRoom(frame, found.seen, held);
  Task task = {&frame,
               held,
               moves ? &work->before : nullptr,
               work,
               PlanesOf(frame, held),
               {},
               Shift(frame.index)};
  ResizePyramids(frame, task.planes, moves, work);
  if (moves) {
    task.planes_before = PlanesOf(frame, &work->before);
    held->motionless = held->first_level_valid = false;
    FindGhosts(task);
    RejectGhosts(task, GhostRadius(frame, found.count));
    FillMotion(task);
  } else {
    StopMotion(held);
  }
  GatherKnown(task);
  held->first_level_valid = true;
  if (!HasHoles(held->known)) {
    return;
  }
  FillPyramids(task);
  FillHoles(task);
}

}  // namespace stillray::cpu
