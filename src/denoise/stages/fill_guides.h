// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fill_guides: values for the pixels of a plane where nothing is known.
/// Source: PSVGF section 5, after Solh and AlRegib 2012: a pyramid with factor 3. Upward every cell
/// is the mean of those of its nine children that are known; downward every hole gets the value of
/// the level above at its place, interpolated. What is known stays as it is. Border: 13, 40, ...
/// pixels, as far as the next known one. Ids are not averaged: a hole takes the id of the known
/// pixel that stands for its cell. Reads 4 bytes per pixel of the mask, and per plane reads what is
/// known and writes 4 bytes per hole.
#pragma once

#include <span>
#include <vector>

#include "stillray/image.h"

namespace stillray {

/// The levels above the picture, kept between frames. Nothing in it is history.
struct FillPyramid {
  std::vector<Image1> known;  ///< 1 where the cell covers a known pixel, else 0
  std::vector<Image1> value;  ///< of the plane being filled
  std::vector<Plane<uint32_t>> id;

  size_t bytes() const;
};

namespace reference {
/// \param known   > 0 where the planes hold values
/// \param planes  of the mask's size, filled in place
/// \return false, and nothing is changed, if nothing is known at all
bool FillHoles(const Image1& known, std::span<Image1* const> planes, FillPyramid* work);
bool FillIds(const Image1& known, Plane<uint32_t>* id, FillPyramid* work);
}  // namespace reference
namespace cpu {
bool FillHoles(const Image1& known, std::span<Image1* const> planes, FillPyramid* work);
bool FillIds(const Image1& known, Plane<uint32_t>* id, FillPyramid* work);
}  // namespace cpu

}  // namespace stillray
