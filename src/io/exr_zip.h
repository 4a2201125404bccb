// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Zip-compressed scan lines of OpenEXR files, by libdeflate: OpenEXR's own zlib takes most of the
/// time that writing a file takes, and half of that of reading one.
#pragma once

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>

#include <string>

namespace stillray::io {

/// Whether EncodeZip can write such a part: scan lines from top to bottom, ZIP or ZIPS, and every
/// channel with a value for every pixel.
bool CanEncodeZip(const Imf::Header& header);

/// A file of one part, byte for byte the same for any number of threads.
/// \param pixels  a slice of the channel's type for every channel of the header
/// \throws what OpenEXR throws, and std::bad_alloc
std::string EncodeZip(const Imf::Header& header, const Imf::FrameBuffer& pixels);

/// Whether DecodeZip can read such a part: scan lines in ZIP or ZIPS, and every channel with a
/// value for every pixel.
bool CanDecodeZip(const Imf::Header& header);

/// Reads all lines of a part.
/// \param pixels  as above
/// \throws what OpenEXR throws, also for data that cannot be decompressed, and std::bad_alloc
void DecodeZip(Imf::InputPart& part, const Imf::FrameBuffer& pixels);

}  // namespace stillray::io
