// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The pyramid of fill_guides: fills the holes of a plane from the known pixels around them.
/// Source: PSVGF section 5, after Solh and AlRegib 2012: levels with factor 3. Downsampling: every
/// cell is the mean of the known ones of its 3x3 children. Upsampling: every hole gets the bilinear
/// interpolation of the level above. Known values are unchanged. Border: 13, 40, ... pixels, up to
/// the nearest known pixel. Ids are not averaged: a cell has the id of its first known child, a
/// hole the id of its parent.
///
/// The reference fills plane by plane. The vector version processes all planes of the image at once
/// (gather_known.cpp, fill_holes.cpp); the functions here process the levels above the image.
/// Results are bit-identical.
#pragma once

#include <vector>

#include "stillray/image.h"

namespace stillray {

/// Known cells of one kind, at the levels above the image: the first element covers 3x3 pixels.
struct PyramidMask {
  std::vector<Image1> known;    ///< 1 where the cell covers a known pixel, else 0
  std::vector<Image1> inverse;  ///< 1 / number of known children; 0 without any

  size_t bytes() const;
};

/// A plane at the levels above the image; the memory is kept between frames.
struct Pyramid {
  std::vector<Image1> value;

  size_t bytes() const;
};
struct IdPyramid {
  std::vector<Plane<uint32_t>> value;

  size_t bytes() const;
};

namespace reference {
/// Fills the holes of a plane, in place.
/// \param known  > 0 where the plane has values; size of \p plane
/// \return false, with the plane unchanged, if no pixel is known
bool FillHoles(const Image1& known, Image1* plane);
/// FillHoles for ids.
bool FillIds(const Image1& known, Plane<uint32_t>* id);
}  // namespace reference

namespace cpu {
/// Allocates the levels above an image of this size (at least one), unless they exist.
void ResizePyramid(int width, int height, PyramidMask* mask);
void ResizePyramid(int width, int height, Pyramid* pyramid);
void ResizePyramid(int width, int height, IdPyramid* pyramid);

/// Computes all levels above the first, which must be set.
void DownsampleMask(PyramidMask* mask);
/// Fills the holes of the first level, whose cells must be set where `mask` is known, from the
/// levels above; zero if no cell is known. Single-threaded.
void FillPyramid(const PyramidMask& mask, Pyramid* pyramid);
void FillPyramid(const PyramidMask& mask, IdPyramid* pyramid);
}  // namespace cpu

}  // namespace stillray
