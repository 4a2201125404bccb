// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The coarse grid of limit_history and restore_energy: blocks of 2x2 pixels, each represented by
// the surface of its pixel nearest to the camera.
#if defined(STILLRAY_DENOISE_SIMD_COARSE_GRID_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_COARSE_GRID_INL_H_
#undef STILLRAY_DENOISE_SIMD_COARSE_GRID_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_COARSE_GRID_INL_H_
#endif

#include <array>

#include "denoise/row_scratch.h"
#include "denoise/simd/guide_exponents-inl.h"
#include "denoise/simd/packed_normal-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/limit_history.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// The values of one plane at the even and odd pixels of two rows.
struct BlockValues {
  VF pixel[4];
};

HWY_INLINE BlockValues LoadBlocks(const float* upper, const float* lower, int bx) {
  const DF d;
  BlockValues v;
  hn::LoadInterleaved2(d, upper + 2 * bx, v.pixel[0], v.pixel[1]);
  hn::LoadInterleaved2(d, lower + 2 * bx, v.pixel[2], v.pixel[3]);
  return v;
}

/// The three components of normals.
/// \param packed_normals  g.packs_normals(), which compilers would load again for every vector
HWY_INLINE void LoadBlockNormals(const GuidePlanes& g, bool packed_normals, int by, int bx,
                                 BlockValues normal[3]) {
  const DU du;
  if (!packed_normals) {
    for (int c = 0; c < 3; ++c) {
      normal[c] = LoadBlocks(g.normal[c].Row(2 * by), g.normal[c].Row(2 * by + 1), bx);
    }
    return;
  }
  for (int row = 0; row < 2; ++row) {
    VU packed[2];
    hn::LoadInterleaved2(du, g.packed_normal.Row(2 * by + row) + 2 * bx, packed[0], packed[1]);
    for (int side = 0; side < 2; ++side) {
      VF n[3];
      UnpackNormal(packed[side], n);
      for (int c = 0; c < 3; ++c) {
        normal[c].pixel[2 * row + side] = n[c];
      }
    }
  }
}

/// The components of the normals at the even and odd pixels of a row.
HWY_INLINE void LoadSideNormals(const GuidePlanes& g, bool packed_normals, int y, int bx, VF nx[2],
                                VF ny[2], VF nz[2]) {
  const DF d;
  const DU du;
  if (!packed_normals) {
    hn::LoadInterleaved2(d, g.normal[0].Row(y) + 2 * bx, nx[0], nx[1]);
    hn::LoadInterleaved2(d, g.normal[1].Row(y) + 2 * bx, ny[0], ny[1]);
    hn::LoadInterleaved2(d, g.normal[2].Row(y) + 2 * bx, nz[0], nz[1]);
    return;
  }
  VU packed[2];
  hn::LoadInterleaved2(du, g.packed_normal.Row(y) + 2 * bx, packed[0], packed[1]);
  for (int side = 0; side < 2; ++side) {
    VF n[3];
    UnpackNormal(packed[side], n);
    nx[side] = n[0];
    ny[side] = n[1];
    nz[side] = n[2];
  }
}

HWY_INLINE VF ComparedWeight(VF cosine, VF expected, VF found, VF own) {
  const DF d;
  const VF deviation = hn::Div(hn::Abs(hn::Sub(expected, found)), own);
  const VF exponent =
      hn::NegMulAdd(hn::Set(d, kLog2E / kComparedTolerance), deviation,
                    hn::Mul(hn::Set(d, kLog2E * kComparedSigmaN), LogCosine(cosine)));
  return Exp2(hn::Max(exponent, hn::Set(d, -120.0f)));
}

/// Finds the nearest pixel of each block of a row, and stores its surface; stores the weights of
/// the blocks' pixels in four rows of the scratch memory.
inline void CoarseRow(const GuidePlanes& g, int by, const RowScratch& scratch, int weight_row,
                      GuidePlanes* coarse) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int blocks = CoarseSize(g.id.width());
  const bool packed_normals = g.packs_normals();
  const auto load = [&](const Image1& plane, int bx) HWY_ATTR __attribute__((always_inline)) {
    return LoadBlocks(plane.Row(2 * by), plane.Row(2 * by + 1), bx);
  };
  for (int bx = 0; bx < blocks; bx += LaneCount()) {
    const BlockValues inverse = load(g.inverse_depth, bx);
    BlockValues normal[3];
    LoadBlockNormals(g, packed_normals, by, bx, normal);
    const BlockValues gradient[2] = {load(g.gradient[0], bx), load(g.gradient[1], bx)};
    VF own = inverse.pixel[0];
    VF n[3] = {normal[0].pixel[0], normal[1].pixel[0], normal[2].pixel[0]};
    VF slope[2] = {gradient[0].pixel[0], gradient[1].pixel[0]};
    VF at[2] = {zero, zero};
    for (int k = 1; k < 4; ++k) {
      const MF nearer = hn::Gt(inverse.pixel[k], own);
      own = hn::IfThenElse(nearer, inverse.pixel[k], own);
      for (int c = 0; c < 3; ++c) {
        n[c] = hn::IfThenElse(nearer, normal[c].pixel[k], n[c]);
      }
      for (int c = 0; c < 2; ++c) {
        slope[c] = hn::IfThenElse(nearer, gradient[c].pixel[k], slope[c]);
      }
      at[0] = hn::IfThenElse(nearer, hn::Set(d, static_cast<float>(k & 1)), at[0]);
      at[1] = hn::IfThenElse(nearer, hn::Set(d, static_cast<float>(k >> 1)), at[1]);
    }
    const MF surface = hn::Gt(own, zero);
    const VF divisor = hn::IfThenElse(surface, own, one);
    const auto expected_at = [&](VF x, VF y) HWY_ATTR __attribute__((always_inline)) {
      return hn::Add(own,
                     hn::MulAdd(slope[0], hn::Sub(x, at[0]), hn::Mul(slope[1], hn::Sub(y, at[1]))));
    };
    for (int k = 0; k < 4; ++k) {
      const VF cosine =
          hn::MulAdd(n[0], normal[0].pixel[k],
                     hn::MulAdd(n[1], normal[1].pixel[k], hn::Mul(n[2], normal[2].pixel[k])));
      const VF expected = expected_at(hn::Set(d, static_cast<float>(k & 1)),
                                      hn::Set(d, static_cast<float>(k >> 1)));
      const VF weight = ComparedWeight(cosine, expected, inverse.pixel[k], divisor);
      const MF same = hn::And(surface, hn::Gt(inverse.pixel[k], zero));
      hn::StoreU(hn::IfThenElseZero(same, weight), d, scratch.Row(weight_row + k) + bx);
    }
    const VF half = hn::Set(d, 0.5f);
    const VF centre = expected_at(half, half);
    StoreInRow(d, hn::IfThenElse(hn::Gt(centre, zero), centre, own), coarse->inverse_depth.Row(by),
               bx, blocks);
    for (int c = 0; c < 3; ++c) {
      StoreInRow(d, n[c], coarse->normal[c].Row(by), bx, blocks);
    }
    for (int c = 0; c < 2; ++c) {
      StoreInRow(d, hn::Add(slope[c], slope[c]), coarse->gradient[c].Row(by), bx, blocks);
    }
  }
}

/// Rows of the blocks that a row of pixels reads, and the columns of its even and odd pixels.
struct BlocksBeside {
  int row[2];

  explicit BlocksBeside(int y) : row{y / 2, y / 2 + (y & 1) * 2 - 1} {}
  int RowOf(int k) const { return row[k >> 1]; }
  static int ColumnOf(int k, int side) { return (k & 1) == 0 ? 0 : side * 2 - 1; }
};

/// The weights of the four blocks around each pixel of a row, in eight rows of the scratch memory:
/// first those of the even pixels, then those of the odd ones.
inline void WeighBlocks(const GuidePlanes& coarse, const GuidePlanes& guides, int y,
                        const RowScratch& scratch, int weight_row) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int blocks = CoarseSize(guides.id.width());
  const bool packed_normals = guides.packs_normals();
  const BlocksBeside beside(y);
  const auto load = [&](const Image1& plane, int bx, VF* sides) HWY_ATTR
      __attribute__((always_inline)) {
    hn::LoadInterleaved2(d, plane.Row(y) + 2 * bx, sides[0], sides[1]);
  };
  for (int bx = 0; bx < blocks; bx += LaneCount()) {
    VF inverse[2], nx[2], ny[2], nz[2], gx[2], gy[2];
    load(guides.inverse_depth, bx, inverse);
    LoadSideNormals(guides, packed_normals, y, bx, nx, ny, nz);
    load(guides.gradient[0], bx, gx);
    load(guides.gradient[1], bx, gy);
    for (int side = 0; side < 2; ++side) {
      const MF surface = hn::Gt(inverse[side], zero);
      const VF own = hn::IfThenElse(surface, inverse[side], one);
      for (int k = 0; k < 4; ++k) {
        const int row = beside.RowOf(k);
        const int column = BlocksBeside::ColumnOf(k, side);
        const float dx = static_cast<float>(2 * column) + 0.5f - static_cast<float>(side);
        const float dy = static_cast<float>(2 * row - y) + 0.5f;
        const float kernel = ((k & 1) == 0 ? 0.75f : 0.25f) * ((k >> 1) == 0 ? 0.75f : 0.25f);
        const auto of_block = [&](const Image1& plane) HWY_ATTR __attribute__((always_inline)) {
          return hn::LoadU(d, plane.Row(row) + bx + column);
        };
        const VF cosine = hn::MulAdd(nx[side], of_block(coarse.normal[0]),
                                     hn::MulAdd(ny[side], of_block(coarse.normal[1]),
                                                hn::Mul(nz[side], of_block(coarse.normal[2]))));
        const VF expected = hn::Add(
            inverse[side], hn::MulAdd(gx[side], hn::Set(d, dx), hn::Mul(gy[side], hn::Set(d, dy))));
        const VF weight =
            hn::Mul(hn::Set(d, kernel),
                    ComparedWeight(cosine, expected, of_block(coarse.inverse_depth), own));
        hn::StoreU(hn::IfThenElseZero(surface, weight), d,
                   scratch.Row(weight_row + 4 * side + k) + bx);
      }
    }
  }
}

/// Interpolates planes of the blocks to a row of pixels.
/// \param otherwise  the values where no block is similar
/// \param first_row  of the results in the scratch memory, a row per plane
template <size_t kPlanes>
void InterpolateBlocks(const Image1& valid, const std::array<const Image1*, kPlanes>& planes,
                       const std::array<float, kPlanes>& otherwise, int y,
                       const RowScratch& scratch, int weight_row, int first_row) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int blocks = valid.width();
  const BlocksBeside beside(y);
  for (int bx = 0; bx < blocks; bx += LaneCount()) {
    VF result[kPlanes][2];
    for (int side = 0; side < 2; ++side) {
      VF sum = zero;
      VF sums[kPlanes];
      for (VF& of_plane : sums) {
        of_plane = zero;
      }
      for (int k = 0; k < 4; ++k) {
        const int row = beside.RowOf(k);
        const int q = bx + BlocksBeside::ColumnOf(k, side);
        const auto load = [&](const Image1& plane) HWY_ATTR __attribute__((always_inline)) {
          return hn::LoadU(d, plane.Row(row) + q);
        };
        const MF known = hn::Gt(load(valid), zero);
        const VF weight =
            hn::IfThenElseZero(known, hn::LoadU(d, scratch.Row(weight_row + 4 * side + k) + bx));
        sum = hn::Add(sum, weight);
        for (size_t i = 0; i < kPlanes; ++i) {
          sums[i] = hn::MulAdd(weight, load(*planes[i]), sums[i]);
        }
      }
      const MF similar = hn::Gt(sum, hn::Set(d, kLeastComparedWeight));
      const VF scale = hn::Div(one, hn::IfThenElse(similar, sum, one));
      for (size_t i = 0; i < kPlanes; ++i) {
        result[i][side] =
            hn::IfThenElse(similar, hn::Mul(sums[i], scale), hn::Set(d, otherwise[i]));
      }
    }
    for (size_t i = 0; i < kPlanes; ++i) {
      hn::StoreInterleaved2(result[i][0], result[i][1], d,
                            scratch.Row(first_row + static_cast<int>(i)) + 2 * bx);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
