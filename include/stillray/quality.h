// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Image quality metrics.
#pragma once

#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

/// The differences of a test image and a reference of the same size. Pixels that are not finite in
/// either image are counted and otherwise ignored. docs/metrics.md has the formulas.
///
/// Most metrics are computed from tone-mapped values, which weight differences in dark and bright
/// regions alike: x / (1 + x) for radiance, the sRGB encoding for display images (the values in the
/// file). Negative values count as zero there.
struct ImageMetrics {
  double psnr = 0;  ///< dB, of tone-mapped values, peak 1; +infinity for equal images
  double ssim = 0;  ///< Wang et al. 2004, of tone-mapped Rec. 709 luma, Gaussian 11x11, sigma 1.5
  double rel_mse = 0;        ///< mean of (test - ref)^2 / (ref^2 + 0.01) over channels and pixels
  double flip = 0;           ///< LDR-FLIP (Andersson et al. 2020), mean, 67 pixels per degree
  double hdr_flip = 0;       ///< HDR-FLIP (Andersson et al. 2021), mean; 0 for display images
  double brightness = 0;     ///< mean luminance of test / mean luminance of reference; +infinity if
                             ///< only the reference is black, 1 if both are
  double bright_specks = 0;  ///< pixels brighter than their neighbourhood, but not in the
                             ///< reference, per 10000 pixels, 0..10000
  double dark_specks = 0;    ///< pixels darker than their neighbourhood, but not in the reference,
                             ///< per 10000 pixels, 0..10000
  double worst_share = 0;    ///< fraction of psnr's squared error in the 1 % of the pixels with the
                             ///< largest error, 0..1; 0 for equal images
  /// Minimum and maximum of `brightness` over the cells of a grid of up to 8x8, without cells where
  /// the reference is (almost) black; 1 if all are.
  double brightness_lowest = 0;
  double brightness_highest = 0;
  int64_t non_finite = 0;  ///< pixels with NaN or infinity in either image
};

/// Compares two images. Deterministic: equal inputs give equal bits for any number of threads.
/// \param display  the images are display-referred: linear values of 0..1 as ReadImage decodes them
///     from PNG and JPEG files, which FLIP uses unchanged. Otherwise the images are linear
///     radiance, for which LDR-FLIP uses the middle exposure of HDR-FLIP's range.
/// \return kInvalidArgument (an empty image; sizes that differ, naming both), kBadData (no pixel is
///     finite in both images), kOutOfMemory
Result<ImageMetrics> CompareImages(const Image3& test, const Image3& reference, bool display);

/// Errors within one object: sums over its pixels that are finite in both images, so that objects
/// and frames can be added. Metrics as in ImageMetrics.
struct ObjectErrors {
  int64_t object = 0;        ///< the object's number
  int64_t pixels = 0;        ///< number of finite pixels
  double flip = 0;           ///< LDR-FLIP
  double rel_mse = 0;        ///< sum of the mean over channels
  double squared_error = 0;  ///< of psnr: sum over pixels and channels
  double luminance = 0;      ///< of the test image
  double reference_luminance = 0;

  /// Adds further pixels of the same object.
  ObjectErrors& operator+=(const ObjectErrors& other);
};

/// The errors of each object, in ascending order of their numbers.
/// \param objects  number of the object at each pixel, up to 2^24, rounded to the nearest integer;
///     pixels with NaN or infinity belong to no object
/// \return errors of CompareImages; kInvalidArgument if `objects` has another size
Result<std::vector<ObjectErrors>> CompareObjects(const Image3& test, const Image3& reference,
                                                 bool display, const Image1& objects);

/// ImageMetrics::psnr of linear radiance alone, in a fraction of the time and memory.
/// \return errors of CompareImages
Result<double> MeasurePsnr(const Image3& test, const Image3& reference);

enum class ErrorMap : uint8_t { kFlip, kHdrFlip, kRelativeSquaredError, kSsim };
/// Per-pixel error, >= 0; CompareImages returns its mean (kSsim: 1 - SSIM). NaN at ignored pixels.
/// \return errors of CompareImages; kInvalidArgument for kHdrFlip of display images
Result<Image1> MakeErrorMap(const Image3& test, const Image3& reference, bool display,
                            ErrorMap which);

/// Temporal error: change along the motion that the reference does not have, as the mean over
/// channels and pixels with visible history of |(T_t(p) - T_{t-1}(p + m)) - (R_t(p) - R_{t-1}(p +
/// m))|, with the test T and the reference R tone-mapped as in ImageMetrics; bilinear lookups;
/// `motion` as in Guides. Pixels are excluded if p + m lies outside the image, if a value is not
/// finite, or, where `depth` (of t) and `previous_depth` are given, if no surface within 5 % of the
/// depth was at p + m.
/// \param motion  empty: zero
/// \param depth, previous_depth  may be empty: then there is no test for disocclusion
/// \return NaN if no pixel's history is visible; kInvalidArgument for an empty image or sizes that
///     differ, naming both images
Result<double> TemporalError(const Image3& test, const Image3& previous_test,
                             const Image3& reference, const Image3& previous_reference,
                             const Image2& motion, const Image1& depth,
                             const Image1& previous_depth, bool display);

/// Changes of luminance from one frame to the next, averaged over pixels, tone-mapped as in
/// ImageMetrics. For a sequence, average both members over its frames.
struct LightChange {
  double product = 0;  ///< of the changes of test and reference
  double square = 0;   ///< of the change of the reference
  /// The fraction of the reference's change that the test reproduces in the same frame: the
  /// least-squares slope product / square. 1: all of it; 0: none. NaN if the reference is constant:
  /// square below 1e-6.
  double Share() const;
};

/// Measures the change of luminance along the motion, averaged over blocks of 8x8 pixels.
/// Parameters and excluded pixels are those of TemporalError. Noise that is uncorrelated between
/// pixels, in the test or in the reference, does not bias the result.
/// \return zeros if no pixel's history is visible; kInvalidArgument as TemporalError
Result<LightChange> MeasureLightChange(const Image3& test, const Image3& previous_test,
                                       const Image3& reference, const Image3& previous_reference,
                                       const Image2& motion, const Image1& depth,
                                       const Image1& previous_depth, bool display);

}  // namespace stillray
