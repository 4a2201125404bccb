// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of spline_coefficients.
#ifndef STILLRAY_DENOISE_SPLINE_COEFFICIENTS_SHARED_H
#define STILLRAY_DENOISE_SPLINE_COEFFICIENTS_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The inverse of the B-spline's samples (1, 4, 1) / 6: sqrt(3) z^|k| with z = sqrt(3) - 2. The last
// weight includes the cut-off ones, so that the sum is 1.
const int kSplineRadius = 4;
const float kSplineWeight0 = 1.7320508f;
const float kSplineWeight1 = -0.46410162f;
const float kSplineWeight2 = 0.12435565f;
const float kSplineWeight3 = -0.033320997f;
const float kSplineWeight4 = 0.00704154f;

SHARED_END

#endif
