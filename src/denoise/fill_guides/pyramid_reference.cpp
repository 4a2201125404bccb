// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/fill_guides/pyramid.h"

namespace stillray {

namespace reference {
namespace {

/// Calls visit(qx, qy) for the children of a cell that are known, row by row.
template <typename Visit>
void ForKnownChildren(const Image1& known, int x, int y, const Visit& visit) {
  for (int qy = y * kPyramidFactor; qy < std::min((y + 1) * kPyramidFactor, known.height()); ++qy) {
    for (int qx = x * kPyramidFactor; qx < std::min((x + 1) * kPyramidFactor, known.width());
         ++qx) {
      if (known(qx, qy) > 0) {
        visit(qx, qy);
      }
    }
  }
}

/// Mean of the known children of each cell: first the sum of each column, then of the three
/// columns.
void Downsample(const Image1& known, const Image1& plane, Image1* above_known, Image1* above) {
  for (int y = 0; y < above->height(); ++y) {
    for (int x = 0; x < above->width(); ++x) {
      float column[kPyramidFactor] = {};
      float count = 0;
      ForKnownChildren(known, x, y, [&](int qx, int qy) {
        column[qx % kPyramidFactor] += plane(qx, qy);
        count += 1;
      });
      const float sum = column[0] + column[1] + column[2];
      (*above)(x, y) = count > 0 ? sum * (1.0f / count) : 0.0f;
      (*above_known)(x, y) = count > 0 ? 1.0f : 0.0f;
    }
  }
}

/// \return false if nothing is known
bool Fill(const Image1& known, Image1* plane) {
  if (known.width() == 1 && known.height() == 1) {
    return known(0, 0) > 0;
  }
  const int width = CellsOf(known.width());
  const int height = CellsOf(known.height());
  Image1 above(width, height);
  Image1 above_known(width, height);
  Downsample(known, *plane, &above_known, &above);
  if (!Fill(above_known, &above)) {
    return false;
  }
  for (int y = 0; y < known.height(); ++y) {
    const int y0 = std::max(FirstParent(y), 0);
    const int y1 = std::min(FirstParent(y) + 1, height - 1);
    for (int x = 0; x < known.width(); ++x) {
      if (known(x, y) > 0) {
        continue;
      }
      const int x0 = std::max(FirstParent(x), 0);
      const int x1 = std::min(FirstParent(x) + 1, width - 1);
      const float wy = SecondParentWeight(y);
      (*plane)(x, y) =
          LerpParents(LerpParents(above(x0, y0), above(x0, y1), wy),
                      LerpParents(above(x1, y0), above(x1, y1), wy), SecondParentWeight(x));
    }
  }
  return true;
}

bool FillId(const Image1& known, Plane<uint32_t>* id) {
  if (known.width() == 1 && known.height() == 1) {
    return known(0, 0) > 0;
  }
  Plane<uint32_t> above(CellsOf(known.width()), CellsOf(known.height()));
  Image1 above_known(above.width(), above.height());
  for (int y = 0; y < above.height(); ++y) {
    for (int x = 0; x < above.width(); ++x) {
      ForKnownChildren(known, x, y, [&](int qx, int qy) {
        if (above_known(x, y) == 0) {
          above(x, y) = (*id)(qx, qy);
          above_known(x, y) = 1;
        }
      });
    }
  }
  if (!FillId(above_known, &above)) {
    return false;
  }
  for (int y = 0; y < known.height(); ++y) {
    for (int x = 0; x < known.width(); ++x) {
      if (!(known(x, y) > 0)) {
        (*id)(x, y) = above(x / kPyramidFactor, y / kPyramidFactor);
      }
    }
  }
  return true;
}

}  // namespace

bool FillHoles(const Image1& known, Image1* plane) {
  return Fill(known, plane);
}

bool FillIds(const Image1& known, Plane<uint32_t>* id) {
  return FillId(known, id);
}

}  // namespace reference
}  // namespace stillray
