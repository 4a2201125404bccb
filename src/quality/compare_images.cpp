// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <new>
#include <utility>

#include <fmt/core.h>

#include "quality/metrics.h"
#include "quality/row_sums.h"
#include "stillray/quality.h"

namespace stillray {
namespace quality {

double MeanOfMap(const PicturePair& pair, const Image1& map) {
  return MeanOfValid(pair, [&map](int x, int y) { return map(x, y); });
}

}  // namespace quality

namespace {

using quality::PicturePair;

Image1 MakeMap(const PicturePair& pair, ErrorMap which) {
  switch (which) {
    case ErrorMap::kFlip:
      return quality::FlipErrorMap(pair, {quality::LdrFlipExposure(pair)});
    case ErrorMap::kHdrFlip:
      return quality::FlipErrorMap(pair, quality::HdrFlipExposures(pair));
    case ErrorMap::kRelativeSquaredError:
      return quality::RelativeSquaredErrorMap(pair);
    case ErrorMap::kSsim:
      break;
  }
  return quality::SsimErrorMap(pair);
}

Result<ImageMetrics> Compare(const Image3& test, const Image3& reference, bool display) {
  const Result<PicturePair> made = quality::MakePicturePair(test, reference, display);
  if (!made.ok()) {
    return made.status();
  }
  const PicturePair& pair = *made;
  ImageMetrics metrics;
  quality::SquaredErrors errors = quality::FindSquaredErrors(pair);
  metrics.psnr = quality::Psnr(pair, errors);
  metrics.ssim = 1.0 - quality::MeanOfMap(pair, MakeMap(pair, ErrorMap::kSsim));
  metrics.rel_mse = quality::RelativeMse(pair);
  metrics.flip = quality::MeanOfMap(pair, MakeMap(pair, ErrorMap::kFlip));
  if (!display) {
    metrics.hdr_flip = quality::MeanOfMap(pair, MakeMap(pair, ErrorMap::kHdrFlip));
  }
  metrics.brightness = quality::BrightnessRatio(pair);
  const quality::SpeckShares specks = quality::FindSpecks(pair);
  metrics.bright_specks = specks.bright;
  metrics.dark_specks = specks.dark;
  metrics.worst_share = quality::WorstShare(pair, std::move(errors));
  const quality::BrightnessRange regions = quality::RegionBrightness(pair);
  metrics.brightness_lowest = regions.lowest;
  metrics.brightness_highest = regions.highest;
  metrics.non_finite = pair.PixelCount() - pair.valid_count;
  return metrics;
}

Result<Image1> MakeMarkedMap(const Image3& test, const Image3& reference, bool display,
                             ErrorMap which) {
  const Result<PicturePair> pair = quality::MakePicturePair(test, reference, display);
  if (!pair.ok()) {
    return pair.status();
  }
  Image1 map = MakeMap(*pair, which);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (pair->valid(x, y) == 0) {
        map(x, y) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return map;
}

Status OutOfMemory(const Image3& image) {
  return Status::OutOfMemory(fmt::format("not enough memory to compare pictures of {}x{} pixels",
                                         image.width(), image.height()));
}

}  // namespace

Result<ImageMetrics> CompareImages(const Image3& test, const Image3& reference, bool display) {
  try {
    return Compare(test, reference, display);
  } catch (const std::bad_alloc&) {
    return OutOfMemory(test);
  }
}

Result<double> MeasurePsnr(const Image3& test, const Image3& reference) {
  try {
    const Result<PicturePair> pair = quality::MakePicturePair(test, reference, false);
    return pair.ok() ? Result<double>(quality::Psnr(*pair, quality::FindSquaredErrors(*pair)))
                     : Result<double>(pair.status());
  } catch (const std::bad_alloc&) {
    return OutOfMemory(test);
  }
}

Result<Image1> MakeErrorMap(const Image3& test, const Image3& reference, bool display,
                            ErrorMap which) {
  if (display && which == ErrorMap::kHdrFlip) {
    return Status::InvalidArgument(
        "HDR-FLIP is defined for linear radiance, not for display pictures: ask for FLIP");
  }
  try {
    return MakeMarkedMap(test, reference, display, which);
  } catch (const std::bad_alloc&) {
    return OutOfMemory(test);
  }
}

}  // namespace stillray
