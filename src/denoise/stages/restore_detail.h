// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_detail: adds back detail that the wavelet has removed in this frame and in earlier ones.
/// The residual of a frame, samples minus filtered signal, is noise plus the filter's bias:
/// softened contact shadows, highlights and textures of light. Noise is independent between frames,
/// the bias is not: it remains in the mean of the residuals along the motion. The valid part of
/// that mean is measured in this frame, whose residuals are compared with the mean of the earlier
/// ones over the surface around each pixel. Where the light has moved away there is no correlation,
/// and nothing is added. Source: Tukey 1977, "twicing", with the residual smoothed in time instead
/// of by the same filter; the factor of the added mean is that of linear regression, times a Wiener
/// filter of the mean. Departs from SVGF, which has no such stage. State: mean residual and its
/// length per signal. The mean is of 3x3 pixels, the sums of four wavelet levels, all with
/// geometry-only weights. Border: as for these levels. Reads 128, writes 84 bytes per pixel and
/// signal around these levels.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/restore_detail_shared.h"

namespace stillray {

inline constexpr int kRestoreDetailLevels = 4;

struct DetailInput {
  const NewLight* light;       ///< of this frame
  const LumaImage3* filtered;  ///< the same signal after all other stages, luminance first
  const Image1* variance;      ///< of the luminance of single samples, >= 0
};

/// BeginDetail: \p mean = the fetched residual and the variance of its noise, \p valid = 1 on
/// surfaces with a known residual.
/// MeasureDetail: luminance of \p measured = product of this frame's residual and the mean, red =
/// square of the mean, both in units of DetailScale; variance = 0. Zero where a pixel has no
/// sample.
/// RestoreDetail: adds the mean times DetailShare of \p sums.
/// AccumulateResidual: adds the residuals of this frame to the fetched mean.
/// \param residual  its colour and length are used
/// \param mean      of 3x3 pixels in MeasureDetail and RestoreDetail
/// \param sums      `measured` after the wavelet levels; not read where \p valid is 0
namespace reference {
void BeginDetail(const DetailInput& in, const SignalHistory& residual, const GuidePlanes& guides,
                 const RestoreDetailParameters& parameters, FilterPlanes* mean, Image1* valid);
void MeasureDetail(const DetailInput& in, const FilterPlanes& mean, const Image1& valid,
                   FilterPlanes* measured);
void RestoreDetail(const FilterPlanes& sums, const FilterPlanes& mean, const Image1& variance,
                   const Image1& valid, LumaImage3* filtered);
void AccumulateResidual(const DetailInput& in, const RestoreDetailParameters& parameters,
                        SignalHistory* residual);
}  // namespace reference
namespace cpu {
void BeginDetail(const DetailInput& in, const SignalHistory& residual, const GuidePlanes& guides,
                 const RestoreDetailParameters& parameters, FilterPlanes* mean, Image1* valid);
void MeasureDetail(const DetailInput& in, const FilterPlanes& mean, const Image1& valid,
                   FilterPlanes* measured);
void RestoreDetail(const FilterPlanes& sums, const FilterPlanes& mean, const Image1& variance,
                   const Image1& valid, LumaImage3* filtered);
void AccumulateResidual(const DetailInput& in, const RestoreDetailParameters& parameters,
                        SignalHistory* residual);
}  // namespace cpu

}  // namespace stillray
