// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Images described by strides: checks, and copies to and from planes.
#pragma once

#include <string_view>

#include "stillray/core.h"
#include "stillray/stillray.h"

namespace stillray::capi {

inline constexpr int kMaxSide = 32768;
/// Rows that one thread takes at a time.
inline constexpr int kBand = 32;

/// Fills in strides that are 0.
/// \param name      of the image, for the message
/// \param channels  required number
/// \param id        whether the image must be STILLRAY_FORMAT_UINT32; else it must not
/// \return kInvalidArgument naming the fault of the description
Status CheckImage(std::string_view name, int channels, bool id, stillray_image* image);

/// Copies a channel; sizes are equal.
void ReadChannel(const stillray_image& image, int channel, Image1* plane);
void ReadIds(const stillray_image& image, Plane<uint32_t>* plane);
void WriteChannel(const Image1& plane, int channel, const stillray_image& image);
/// Sets a channel to zero.
void ClearChannel(int channel, const stillray_image& image);

}  // namespace stillray::capi
