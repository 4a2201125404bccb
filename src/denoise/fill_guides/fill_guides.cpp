// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The work is bound by memory: some twenty planes, of which a frame knows one pixel in a hundred.
// So every plane is gone through twice, by rows of cells of the pyramid: once to take what is known
// and to raise it to the first level (in a still view only the cells that have learnt something),
// once to fill the holes from there. What lies between is an eighth of the work.
#include "denoise/fill_guides/fill_guides.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "core/parallel.h"
#include "denoise/fill_guides/fill_guides_task.h"

namespace stillray::cpu {
namespace {

using Work = SparseGuidesWork;
using Task = SparseGuidesTask;

struct FoundPixels {
  int64_t count = 0;
  bool moves = false;
  LightSeen seen;
};

bool Shines(const Image3& light, int x, int y) {
  return !light.empty() && (light[0](x, y) != 0 || light[1](x, y) != 0 || light[2](x, y) != 0);
}

/// What the frame knows: lists its pixels, and says what of it is new to `held`.
FoundPixels FindKnown(const Frame& frame, const HeldGuides& held, RowLists* list) {
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
        if (!emission && Shines(frame.emission, x, y)) {
          emission = true;
        }
        if (!background && Shines(frame.background, x, y)) {
          background = true;
        }
      }
    }
  });
  return {count, moves, {emission, background}};
}

/// Lists held pixels that what is known now speaks against.
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
            Differ(now, x, y, t.before->guides, qx, qy)) {
          to[count++] = qy * t.width() + qx;
        }
      }
      t.work->ghosts.SetCount(y, count);
    }
  });
}

/// Forgets the same surface around the ghosts. Each band looks at all ghosts, for the rows that
/// are its own.
void ForgetGhosts(const Task& t, int radius) {
  const Guides& g = t.before->guides;
  ParallelRows(t.height(), kRowBand, [&](int y0, int y1) {
    for (int row = 0; row < t.height(); ++row) {
      for (const int32_t q : t.work->ghosts.Row(row)) {
        const int qx = q % t.width();
        const int qy = q / t.width();
        for (int y = std::max(qy - radius, y0); y < std::min(qy + radius + 1, y1); ++y) {
          float* known = t.before->known.Row(y);
          for (int x = std::max(qx - radius, 0); x <= std::min(qx + radius, t.width() - 1); ++x) {
            if (known[x] > 0 && !Differ(g, x, y, g, qx, qy)) {
              known[x] = 0;
            }
          }
        }
      }
    }
  });
}

/// This frame's motion on all levels.
void FillMotion(const Task& t) {
  RaiseMotion(t);
  const FillMask& mask = t.work->mask[Work::kNew];
  RaiseMask(&t.work->mask[Work::kNew]);
  tbb::parallel_for(0, 2,
                    [&](int k) { FillLevelHoles(mask, &t.work->motion[static_cast<size_t>(k)]); });
}

/// The levels between the passes through the picture, each plane on its own.
void FillLevelsOf(const Task& t) {
  Work& w = *t.work;
  for (const Work::Kind kind : t.kinds()) {
    RaiseMask(&w.mask[kind]);
  }
  tbb::parallel_for(-3, t.planes.count, [&](int i) {
    if (i >= 0) {
      FillLevelHoles(w.mask[t.KindOf(i)], &w.plane[static_cast<size_t>(i)]);
    } else if (i == -1) {
      FillLevelHoles(w.mask[Work::kAny], &w.surface);
    } else if (i == -2) {
      FillLevelHoles(w.mask[Work::kSurface], &w.inverse_depth);
    } else if (!t.held->guides.id.empty()) {
      FillLevelHoles(w.mask[Work::kSurface], &w.id);
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

void MakeAllLevels(const Frame& frame, const HeldPlanes& planes, bool moves, Work* work) {
  const int w = frame.width;
  const int h = frame.height;
  for (FillMask& mask : work->mask) {
    MakeLevels(w, h, &mask);
  }
  MakeLevels(w, h, &work->surface);
  MakeLevels(w, h, &work->inverse_depth);
  for (int i = 0; i < planes.count; ++i) {
    MakeLevels(w, h, &work->plane[static_cast<size_t>(i)]);
  }
  for (FillLevels& levels : work->motion) {
    if (moves) {
      MakeLevels(w, h, &levels);
    }
  }
  if (!frame.guides.id.empty()) {
    MakeLevels(w, h, &work->id);
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

void CompleteGuides(const Frame& frame, HeldGuides* held, SparseGuidesWork* work) {
  if (!Fits(*held, frame)) {
    *held = HeldGuides();
  }
  work->known_now.Resize(frame.width, frame.height);
  const FoundPixels found = FindKnown(frame, *held, &work->known_now);
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
  MakeAllLevels(frame, task.planes, moves, work);
  if (moves) {
    task.planes_before = PlanesOf(frame, &work->before);
    held->motionless = held->raised = false;
    FindGhosts(task);
    ForgetGhosts(task, GhostRadius(frame, found.count));
    FillMotion(task);
  } else {
    StopMotion(held);
  }
  TakeKnown(task);
  held->raised = true;
  if (!HasHoles(held->known)) {
    return;
  }
  FillLevelsOf(task);
  FillHoles(task);
}

}  // namespace stillray::cpu
