// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Zip-compressed scan lines of OpenEXR files, by libdeflate. OpenEXR's zlib takes most of the time
/// of writing a file, and half the time of reading.
#pragma once

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>

#include <string>

namespace stillray::io {

/// Whether EncodeZip supports the part: scan lines from top to bottom, ZIP or ZIPS, without
/// subsampled channels.
bool CanEncodeZip(const Imf::Header& header);

/// Encodes a file of one part; the bytes do not depend on the number of threads.
/// \param pixels  a slice of the channel's type for every channel of the header
/// \throws OpenEXR's exceptions, and std::bad_alloc
std::string EncodeZip(const Imf::Header& header, const Imf::FrameBuffer& pixels);

/// Whether DecodeZip supports the part: scan lines in ZIP or ZIPS, without subsampled channels.
bool CanDecodeZip(const Imf::Header& header);

/// Reads all lines of a part.
/// \param pixels  as above
/// \throws OpenEXR's exceptions, also for data that cannot be decompressed, and std::bad_alloc
void DecodeZip(Imf::InputPart& part, const Imf::FrameBuffer& pixels);

}  // namespace stillray::io
