// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Files with the layers that Cycles writes of a room with mirrors.
#pragma once

#include <string>

#include "io/mirror_room.h"
#include "stillray/io.h"

namespace stillray {

Image3 White(int width, int height);

/// Light of 1 in each pass, in the view layer V.
/// \param without  layers whose names begin with "V." and this are left out
ExrImage FileOf(const RoomPicture& picture, const std::string& without = "nothing");

}  // namespace stillray
