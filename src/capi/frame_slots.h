// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images of a frame by name.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

#include "stillray/core.h"
#include "stillray/stillray.h"

namespace stillray::capi {

using ImageMap = std::map<std::string, stillray_image, std::less<>>;

/// All inputs, in the order of the documentation.
std::span<const stillray_input_info> Inputs();

/// \return nullptr if there is no such input
const stillray_input_info* FindInput(std::string_view name);

/// Whether the input holds integers (STILLRAY_FORMAT_UINT32).
bool IsId(std::string_view name);

/// Copies the images into the frame; missing ones become empty. All images have the size
/// frame->width x frame->height.
void LoadFrame(const ImageMap& images, Frame* frame);

/// The input "next_motion" of the frame; empty if not given.
void LoadNextMotion(const ImageMap& images, const Frame& frame, Image2* motion);

/// Replaces the given images by images of one pixel, for computing the memory need.
void MarkImages(const ImageMap& images, Frame* shape);

}  // namespace stillray::capi
