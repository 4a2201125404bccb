// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Measures of picture quality.
#pragma once

#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

/// The differences of two pictures of the same size. Pixels that are not finite in either picture
/// are counted and otherwise ignored. docs/metrics.md has the formulas.
///
/// Most measures apply a curve on which differences in light and shade have equal weight: x / (1 +
/// x) of radiance, the sRGB encoding of display pictures (their values in the file). Negative light
/// counts as zero there.
struct ImageMetrics {
  double psnr = 0;  ///< dB, on the curve, peak 1; +infinity for equal pictures
  double ssim = 0;  ///< Wang et al. 2004 on Rec. 709 luma on the curve, Gaussian 11x11, sigma 1.5
  double rel_mse = 0;        ///< mean of (test - ref)^2 / (ref^2 + 0.01) over channels and pixels
  double flip = 0;           ///< LDR-FLIP (Andersson et al. 2020), mean, 67 pixels per degree
  double hdr_flip = 0;       ///< HDR-FLIP (Andersson et al. 2021), mean; 0 for display pictures
  double brightness = 0;     ///< mean luminance of test / mean luminance of reference; +infinity if
                             ///< only the reference is black, 1 if both are
  double bright_specks = 0;  ///< pixels that stand out from their neighbours as brighter, as they
                             ///< do not in the reference; 1e-4 of the pixels, 0..10000
  double dark_specks = 0;    ///< likewise darker
  double worst_share = 0;    ///< share of the squared error of psnr in the 1 % of the pixels with
                             ///< the largest, 0..1; 0 for equal pictures
  double brightness_lowest = 0;   ///< least brightness of the regions, of a grid of up to 8x8, in
                                  ///< which the reference has light; 1 if it has none
  double brightness_highest = 0;  ///< greatest, likewise
  int64_t non_finite = 0;
};

/// Deterministic: the same pictures give the same bits for any number of threads.
/// \param display  the pictures are display-referred: linear values of 0..1 as ReadImage decodes
///     them from PNG and JPEG files, which FLIP uses unchanged. Otherwise linear radiance, for
///     which LDR-FLIP uses the middle exposure of HDR-FLIP's range.
/// \return kInvalidArgument (an empty picture; sizes that differ, naming both), kBadData (no pixel
///     is finite in both pictures), kOutOfMemory
Result<ImageMetrics> CompareImages(const Image3& test, const Image3& reference, bool display);

/// Errors within the pixels of one object: sums over those that are finite in both pictures, so
/// that objects and frames can be added. The measures are those of ImageMetrics.
struct ObjectErrors {
  int64_t object = 0;        ///< its number
  int64_t pixels = 0;        ///< that are valid
  double flip = 0;           ///< LDR-FLIP
  double rel_mse = 0;        ///< of the mean over channels
  double squared_error = 0;  ///< of psnr: over the channels too
  double luminance = 0;      ///< of the test
  double reference_luminance = 0;

  /// Adds pixels of the same object.
  ObjectErrors& operator+=(const ObjectErrors& other);
};

/// The errors of each object, in ascending order of their numbers.
/// \param objects  number of the object at each pixel, up to 2^24, rounded to the nearest; pixels
///     that are not finite there belong to none
/// \return errors of CompareImages; kInvalidArgument if `objects` has another size
Result<std::vector<ObjectErrors>> CompareObjects(const Image3& test, const Image3& reference,
                                                 bool display, const Image1& objects);

/// ImageMetrics::psnr of linear radiance alone, in a fraction of the time and memory.
/// \return errors of CompareImages
Result<double> MeasurePsnr(const Image3& test, const Image3& reference);

enum class ErrorMap : uint8_t { kFlip, kHdrFlip, kRelativeSquaredError, kSsim };
/// Per-pixel error, >= 0; CompareImages returns its mean (kSsim: 1 - SSIM). NaN at ignored pixels.
/// \return errors of CompareImages; kInvalidArgument for kHdrFlip of display pictures
Result<Image1> MakeErrorMap(const Image3& test, const Image3& reference, bool display,
                            ErrorMap which);

/// Change along the motion that the reference does not have: the mean over channels and pixels with
/// visible history of |(T_t(p) - T_{t-1}(p + m)) - (R_t(p) - R_{t-1}(p + m))|, T and R on the curve
/// of ImageMetrics; bilinear lookups; `motion` as in Guides. Pixels are left out if their history
/// lies outside the picture, if a value is not finite, and, where `depth` (of t) and
/// `previous_depth` are given, if no surface within 5 % of the depth was there.
/// \param motion  empty: zero
/// \param depth, previous_depth  may be empty: then no history counts as hidden
/// \return NaN if no pixel's history is visible; kInvalidArgument for an empty picture or sizes
///     that differ, naming both images
Result<double> TemporalError(const Image3& test, const Image3& previous_test,
                             const Image3& reference, const Image3& previous_reference,
                             const Image2& motion, const Image1& depth,
                             const Image1& previous_depth, bool display);

/// Changes of light from one frame to the next, averaged over pixels, on the curve of ImageMetrics.
/// Of a sequence: the means of both members over its frames.
struct LightChange {
  double product = 0;  ///< of the test's change and the reference's
  double square = 0;   ///< of the reference's change
  /// How much of the reference's change the test makes in the same frame: the least-squares slope
  /// product / square. 1: all of it; 0: none. NaN if the reference's light is steady: square below
  /// 1e-6.
  double Share() const;
};

/// The change of luminance along the motion, in means over blocks of 8x8 pixels. Parameters and
/// pixels that are left out as in TemporalError. Noise that is independent from pixel to pixel, in
/// the test or in the reference, does not shift the result.
/// \return zeros if no pixel's history is visible; kInvalidArgument as TemporalError
Result<LightChange> MeasureLightChange(const Image3& test, const Image3& previous_test,
                                       const Image3& reference, const Image3& previous_reference,
                                       const Image2& motion, const Image1& depth,
                                       const Image1& previous_depth, bool display);

}  // namespace stillray
