// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Reading and writing of image files, sequences and videos. Every file is written under a
/// temporary name in the same folder and then renamed, so that other programs never read a partial
/// file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

enum class PixelType : uint8_t { kHalf, kFloat, kUint32 };

/// One channel of an EXR file, e.g. "R", "normal.X". `values` holds half and float channels,
/// `integers` kUint32; the other plane is empty.
struct Channel {
  std::string name;
  PixelType type = PixelType::kHalf;
  Image1 values;
  Plane<uint32_t> integers;
};

enum class ExrCompression : uint8_t { kNone, kZip, kZips, kPiz, kDwaa, kOther };

/// Pixels x_min..x_max, y_min..y_max, inclusive, in the coordinates of an EXR file.
struct ExrWindow {
  int x_min = 0;
  int y_min = 0;
  int x_max = -1;
  int y_max = -1;
};

/// A multilayer EXR image: all channels have the same size. Layers are name prefixes ("normal.").
struct ExrImage {
  int width = 0;
  int height = 0;
  std::vector<Channel> channels;
  std::map<std::string, std::string> attributes;  ///< text attributes
  ExrCompression compression = ExrCompression::kZip;

  // Set by ReadExr, ignored by WriteExr.
  std::map<std::string, std::string> other_attributes;  ///< numbers, vectors, matrices, as text
  std::string compression_name = "zip";                 ///< exactly: "pxr24", "b44a", ...
  bool tiled = false;
  ExrWindow data_window;
  ExrWindow display_window;
  std::vector<std::string> notes;  ///< parts of the file that were left out, one line each

  /// The channel of this name; nullptr if there is none.
  const Channel* Find(const std::string& name) const;
  /// Appends a channel with a copy of the plane.
  void Add(const std::string& name, PixelType type, const Image1& values);
  void Add(const std::string& name, const Plane<uint32_t>& integers);
  /// Adds prefix + "R", "G", "B" ("X", "Y", "Z" with `xyz`). An empty prefix is the main image; any
  /// other prefix ends in a dot.
  void Add(const std::string& prefix, PixelType type, const Image3& image, bool xyz = false);
};

/// Reads part 0 of any EXR file (scanline or tiled, any compression), and the channels of other
/// parts of the same size. Pixels outside the data window are zero; the result has the size of the
/// display window.
/// \return kNotFound, kIo, kBadData, kUnsupported (deep data; larger than 32768 pixels a side),
///     kOutOfMemory
Result<ExrImage> ReadExr(const std::string& path);
/// As ReadExr, from memory; `name` is the file's name in messages. Safe on any bytes.
Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name);

/// Writes one part of scanlines. Finite values beyond the range of half are clamped to +-65504 in
/// kHalf channels; infinities and NaN are kept. kOther compresses with ZIP. Text attributes that
/// OpenEXR defines with another type are rejected.
/// \return kInvalidArgument naming the channel whose plane is missing or has another size, whose
///     name is empty or duplicate, or whose data kDwaa would damage (it is lossy on channels that
///     end in ".Y": motion, normals); kIo
Status WriteExr(const std::string& path, const ExrImage& image);
/// The bytes that WriteExr writes.
Result<std::string> EncodeExr(const ExrImage& image);
/// Sets the number of threads that compress and decompress EXR files, >= 0 (0: the calling thread
/// only). Default: one per processor. Results do not depend on it.
void SetExrThreads(int count);

/// The three channels prefix + "R", "G", "B" (or "X", "Y", "Z") as one image.
/// \return kNotFound naming the channel that is missing
Result<Image3> ExrLayer(const ExrImage& image, const std::string& prefix, bool xyz = false);
/// The colour image of a file: R, G, B without a layer; else the layer whose name ends in
/// "Combined" (Blender); else the only layer with R, G and B; else Y (grey).
/// \return kNotFound listing the layers if there is no such layer, or more than one
Result<Image3> ExrColour(const ExrImage& image, const std::string& name);

/// Reads a colour image as linear RGB: .exr (see ExrColour), .hdr, .png, .jpg (PNG and JPEG are
/// sRGB-decoded to 0..1; alpha is ignored). The format is recognised by the file's first bytes, not
/// by its name. `*linear_source`, if given, is set to whether the file stores linear values.
/// \return kNotFound, kIo, kBadData, kUnsupported (another format, larger than 32768 x 32768),
///     kOutOfMemory
Result<Image3> ReadImage(const std::string& path, bool* linear_source = nullptr);
/// As ReadImage, from memory; `name` is the file's name in messages. Safe on any bytes.
Result<Image3> DecodeImage(const uint8_t* data, size_t size, const std::string& name,
                           bool* linear_source = nullptr);

/// Interleaved 8-bit RGB, rows from the top: width * height * 3 bytes.
struct Rgb8Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;
};
/// Writes 8-bit RGB as PNG (sRGB chunk set).
/// \return kInvalidArgument if the size is not 1 to 32768 a side, or `pixels` has another size; kIo
Status WritePng(const std::string& path, const Rgb8Image& image);
/// Reads any PNG as 8-bit RGB: grey and palettes become RGB, 16 bits lose the lower 8, alpha is
/// ignored.
/// \return kNotFound, kIo, kBadData, kUnsupported (larger than 32768 pixels a side), kOutOfMemory
Result<Rgb8Image> ReadPng8(const std::string& path);
/// As ReadPng8, from memory; `name` is the file's name in messages. Safe on any bytes.
Result<Rgb8Image> DecodePng8(const uint8_t* data, size_t size, const std::string& name);
/// The bytes that WritePng writes.
Result<std::string> EncodePng(const Rgb8Image& image);

/// Writes 8-bit RGB as baseline JPEG of quality 95, without chroma subsampling.
/// \return kInvalidArgument if the size is not 1 to 65535 a side; kIo
Status WriteJpeg(const std::string& path, const Rgb8Image& image);
/// The bytes that WriteJpeg writes.
Result<std::string> EncodeJpeg(const Rgb8Image& image);
/// Writes linear radiance as a Radiance file (.hdr): 8 bits for each channel and a common exponent,
/// so that the error of a channel is at most 1/256 of the largest channel. Negative values and NaN
/// become 0, infinity the largest value (1.7e38).
/// \return kInvalidArgument if the size is not 1 to 32768 a side; kIo
Status WriteHdr(const std::string& path, const Image3& radiance);
/// The bytes that WriteHdr writes.
Result<std::string> EncodeHdr(const Image3& radiance);

/// Writes `bytes` under a temporary name in the same folder and renames the result to `path`: other
/// programs read the old file or the new one, never a part, and a failed write leaves no file. A
/// path that is not a regular file (/dev/stdout, a named pipe) is written directly; for a symbolic
/// link the target is replaced.
/// \return kNotFound (no such folder), kIo naming the path and the system's reason
Status WriteFileAtomically(const std::string& path, const void* bytes, size_t size);
/// Reads a file into memory.
/// \return kNotFound, kIo (a folder, no permission), kUnsupported (larger than `max_size` bytes)
Result<std::string> ReadWholeFile(const std::string& path, size_t max_size);

/// Sends frames to an ffmpeg process that writes an H.264 .mp4 (4:2:0, BT.709, index at the front).
/// Odd sizes are padded by repeating a column or row, as 4:2:0 requires even sizes. Not
/// thread-safe.
class VideoWriter {
 public:
  /// \param width, height  of the frames, 1..16384
  /// \param fps  frames per second, 0.001 to 1000
  /// \return kUnsupported if ffmpeg is not installed (message says what to install)
  static Result<std::unique_ptr<VideoWriter>> Create(const std::string& path, int width, int height,
                                                     double fps);
  virtual ~VideoWriter() = default;  ///< without Finish() the unfinished file is removed
  /// Appends a frame. \return kInvalidArgument (another size, or after Finish()); kIo with ffmpeg's
  /// message, also from all later calls
  virtual Status Write(const Rgb8Image& frame) = 0;
  /// Completes the file. \return kInvalidArgument if there is no frame; kIo with ffmpeg's message
  virtual Status Finish() = 0;
};

/// Inserts the frame number in "dir/name.####.exr" or "name.%04d.exr": with as many digits as there
/// are marks, more if the number needs them, and a leading minus if it is negative. The last run of
/// marks in the file name is replaced; a path without marks is returned unchanged.
std::string FrameFileName(const std::string& pattern, int64_t frame);
/// Whether the file name (without its folder) contains '#', "%d" or "%0Nd".
bool IsFramePattern(const std::string& path);
/// Numbers of the files on disk that match the pattern, sorted.
std::vector<int64_t> FindFrames(const std::string& pattern);

}  // namespace stillray
