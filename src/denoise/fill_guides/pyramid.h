// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fill_guides: values for the pixels of a plane where nothing is known.
/// Source: PSVGF section 5, after Solh and AlRegib 2012: a pyramid with factor 3. Upward every cell
/// is the mean of those of its nine children that are known; downward every hole gets the value of
/// the level above at its place, interpolated. What is known stays as it is. Border: 13, 40, ...
/// pixels, as far as the next known one. Ids are not averaged: a hole takes the id of the known
/// pixel that stands for its cell.
///
/// The scalar version fills plane by plane. The vector version is part of cpu::CompleteGuides
/// (fill_guides.h), which goes through the picture itself for all planes at once; here it has
/// what lies above the picture. Both give the same bits.
#pragma once

#include <vector>

#include "stillray/image.h"

namespace stillray {

/// One kind of known pixels at the levels above the picture: the first element covers 3x3 pixels.
struct FillMask {
  std::vector<Image1> known;    ///< 1 where the cell covers a known pixel, else 0
  std::vector<Image1> inverse;  ///< 1 / number of known children; 0 where there are none

  size_t bytes() const;
};

/// A plane at the levels above the picture, kept between frames.
struct FillLevels {
  std::vector<Image1> value;

  size_t bytes() const;
};
struct FillIdLevels {
  std::vector<Plane<uint32_t>> value;

  size_t bytes() const;
};

namespace reference {
/// \param known  > 0 where the plane holds values
/// \param plane  of the mask's size, filled in place
/// \return false, and nothing is changed, if nothing is known at all
bool FillHoles(const Image1& known, Image1* plane);
bool FillIds(const Image1& known, Plane<uint32_t>* id);
}  // namespace reference
namespace cpu {
/// Makes the levels above a picture of this size, at least one, unless they are there.
void MakeLevels(int width, int height, FillMask* mask);
void MakeLevels(int width, int height, FillLevels* levels);
void MakeLevels(int width, int height, FillIdLevels* levels);

/// From the first level, which is given, all others.
void RaiseMask(FillMask* mask);
/// Fills all holes of the first level from what it knows; zero if that is nothing. Single-threaded.
void FillLevelHoles(const FillMask& mask, FillLevels* levels);
void FillLevelHoles(const FillMask& mask, FillIdLevels* levels);
}  // namespace cpu

}  // namespace stillray
