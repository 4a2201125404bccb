// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of pixels that show several surfaces.
#pragma once

#include <cstdint>

#include "stillray/image.h"

namespace stillray::io {

/// Makes the motion of pixels unknown that is a mean over surfaces which move differently: at the
/// outline of a moving object, by the pixel filter or a lens. It is the motion of none of them, and
/// what the pixel shows of the surface behind was elsewhere. Such a pixel has the motion of fewer
/// than three of the eight pixels around it, within half a pixel; a sharp outline has that of more
/// on either side. The outermost pixels stay.
/// \return the number of these pixels
int64_t ForgetMixedMotion(Image2* motion);

}  // namespace stillray::io
