// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The work is bound by memory and by scattered holes, not by arithmetic: rows on threads, loops
// that the compiler turns into vectors, no intrinsics.
#include "denoise/stages/fill_guides.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/stages/fill_guides_shared.h"

namespace stillray::cpu {
namespace {

constexpr int kBand = 8;

int Above(int size) {
  return (size + kPyramidFactor - 1) / kPyramidFactor;
}

template <typename T>
void MakeLevels(int width, int height, std::vector<Plane<T>>* levels) {
  size_t i = 0;
  while (width > 1 || height > 1) {
    width = Above(width);
    height = Above(height);
    if (levels->size() <= i) {
      levels->emplace_back();
    }
    Plane<T>& level = (*levels)[i++];
    if (level.width() != width || level.height() != height) {
      level = Plane<T>(width, height);
    }
  }
  levels->resize(i);
}

/// Calls visit(x, first, last, q0, q1) for each cell of a row: its children are the columns first
/// to last (exclusive) of the rows q0 to q1 (exclusive) below.
template <typename Visit>
void ForCells(const Image1& below, int y, int width, const Visit& visit) {
  const int q0 = y * kPyramidFactor;
  const int q1 = std::min(q0 + kPyramidFactor, below.height());
  for (int x = 0; x < width; ++x) {
    const int first = x * kPyramidFactor;
    visit(x, first, std::min(first + kPyramidFactor, below.width()), q0, q1);
  }
}

void RaiseKnown(const Image1& below, Image1* above) {
  ParallelRows(above->height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      ForCells(below, y, above->width(), [&](int x, int first, int last, int q0, int q1) {
        bool any = false;
        for (int qy = q0; qy < q1; ++qy) {
          for (int qx = first; qx < last; ++qx) {
            any = any || below(qx, qy) > 0;
          }
        }
        (*above)(x, y) = any ? 1.0f : 0.0f;
      });
    }
  });
}

/// The masks of all levels. \return false if nothing is known
bool RaiseMasks(const Image1& known, FillPyramid* work) {
  MakeLevels(known.width(), known.height(), &work->known);
  const Image1* below = &known;
  for (Image1& level : work->known) {
    RaiseKnown(*below, &level);
    below = &level;
  }
  return (*below)(0, 0) > 0;
}

void RaiseValues(const Image1& known, const Image1& below, const Image1& above_known,
                 Image1* above) {
  ParallelRows(above->height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      ForCells(below, y, above->width(), [&](int x, int first, int last, int q0, int q1) {
        if (!(above_known(x, y) > 0)) {
          (*above)(x, y) = 0.0f;
          return;
        }
        float sum = 0;
        float count = 0;
        for (int qy = q0; qy < q1; ++qy) {
          for (int qx = first; qx < last; ++qx) {
            if (known(qx, qy) > 0) {
              sum += below(qx, qy);
              count += 1;
            }
          }
        }
        (*above)(x, y) = sum / count;
      });
    }
  });
}

void LowerValues(const Image1& known, const Image1& above, Image1* below) {
  const int width = below->width();
  ParallelRows(below->height(), kBand, [&](int y0, int y1) {
    std::vector<float> mixed(static_cast<size_t>(above.width()) + 2);
    for (int y = y0; y < y1; ++y) {
      const float* row0 = above.Row(std::max(FirstParent(y), 0));
      const float* row1 = above.Row(std::min(FirstParent(y) + 1, above.height() - 1));
      const float weight = SecondParentWeight(y);
      // One cell more on either side repeats the outermost.
      float* inner = mixed.data() + 1;
      for (int x = 0; x < above.width(); ++x) {
        inner[x] = MixParents(row0[x], row1[x], weight);
      }
      mixed.front() = inner[0];
      inner[above.width()] = inner[above.width() - 1];
      const float* mask = known.Row(y);
      float* to = below->Row(y);
      for (int cell = 0, x = 0; x < width; ++cell) {
        for (int child = 0; child < kPyramidFactor && x < width; ++child, ++x) {
          const int first = cell - (child == 0 ? 1 : 0);
          const float value = MixParents(inner[first], inner[first + 1], SecondParentWeight(child));
          to[x] = mask[x] > 0 ? to[x] : value;
        }
      }
    }
  });
}

}  // namespace

bool FillHoles(const Image1& known, std::span<Image1* const> planes, FillPyramid* work) {
  if (!RaiseMasks(known, work)) {
    return false;
  }
  MakeLevels(known.width(), known.height(), &work->value);
  const int levels = static_cast<int>(work->known.size());
  const auto mask = [&](int level) -> const Image1& {
    return level == 0 ? known : work->known[static_cast<size_t>(level - 1)];
  };
  for (Image1* plane : planes) {
    const auto value = [&](int level) -> Image1& {
      return level == 0 ? *plane : work->value[static_cast<size_t>(level - 1)];
    };
    for (int level = 0; level < levels; ++level) {
      RaiseValues(mask(level), value(level), mask(level + 1), &value(level + 1));
    }
    for (int level = levels - 1; level >= 0; --level) {
      LowerValues(mask(level), value(level + 1), &value(level));
    }
  }
  return true;
}

bool FillIds(const Image1& known, Plane<uint32_t>* id, FillPyramid* work) {
  if (!RaiseMasks(known, work)) {
    return false;
  }
  MakeLevels(known.width(), known.height(), &work->id);
  const int levels = static_cast<int>(work->known.size());
  const auto mask = [&](int level) -> const Image1& {
    return level == 0 ? known : work->known[static_cast<size_t>(level - 1)];
  };
  const auto value = [&](int level) -> Plane<uint32_t>& {
    return level == 0 ? *id : work->id[static_cast<size_t>(level - 1)];
  };
  for (int level = 0; level < levels; ++level) {
    Plane<uint32_t>& above = value(level + 1);
    ParallelRows(above.height(), kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        ForCells(mask(level), y, above.width(), [&](int x, int first, int last, int q0, int q1) {
          above(x, y) = 0;
          for (int qy = q1 - 1; qy >= q0; --qy) {
            for (int qx = last - 1; qx >= first; --qx) {
              above(x, y) = mask(level)(qx, qy) > 0 ? value(level)(qx, qy) : above(x, y);
            }
          }
        });
      }
    });
  }
  for (int level = levels - 1; level >= 0; --level) {
    ParallelRows(value(level).height(), kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        const uint32_t* above = value(level + 1).Row(y / kPyramidFactor);
        const float* known_row = mask(level).Row(y);
        uint32_t* to = value(level).Row(y);
        for (int x = 0; x < value(level).width(); ++x) {
          to[x] = known_row[x] > 0 ? to[x] : above[x / kPyramidFactor];
        }
      }
    });
  }
  return true;
}

}  // namespace stillray::cpu
