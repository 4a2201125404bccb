// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Pictures and sequences on disk. Every file is written whole under a temporary name beside its
/// target and then renamed, so that a reader never sees half a file.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

enum class PixelType : uint8_t { kHalf, kFloat, kUint32 };

/// One channel of an EXR file, e.g. "R", "normal.X". Values are held in full: `values` for half and
/// float, `integers` for kUint32; the other plane is empty.
struct Channel {
  std::string name;
  PixelType type = PixelType::kHalf;
  Image1 values;
  Plane<uint32_t> integers;
};

enum class ExrCompression : uint8_t { kNone, kZip, kZips, kPiz, kDwaa, kOther };

/// A multilayer EXR picture: all channels have its size. Layers are name prefixes ("normal.").
struct ExrImage {
  int width = 0;
  int height = 0;
  std::vector<Channel> channels;
  std::map<std::string, std::string> attributes;  ///< text attributes
  ExrCompression compression = ExrCompression::kZip;

  const Channel* Find(const std::string& name) const;
  void Add(const std::string& name, PixelType type, const Image1& values);
  void Add(const std::string& name, const Plane<uint32_t>& integers);
  /// Adds prefix + "R", "G", "B" ("X", "Y", "Z" with `xyz`); an empty prefix makes the main
  /// picture, any other ends in a dot.
  void Add(const std::string& prefix, PixelType type, const Image3& image, bool xyz = false);
};

/// Reads part 0 of any EXR file (scanline or tiled, any compression); other parts' channels are
/// added where their size is the same. Pixels outside the data window are zero; the result has the
/// size of the display window.
/// \return kNotFound, kBadData, kUnsupported (deep data; larger than 32768 pixels a side),
/// kOutOfMemory
Result<ExrImage> ReadExr(const std::string& path);
Status WriteExr(const std::string& path, const ExrImage& image);

/// Reads a colour picture as linear RGB: .exr (its main or else only RGB layer), .hdr, .png, .jpg
/// (the last two are sRGB-decoded). `*linear_source`, if given, tells whether the file itself was
/// linear.
Result<Image3> ReadImage(const std::string& path, bool* linear_source = nullptr);

/// Interleaved 8-bit RGB, rows from the top.
struct Rgb8Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;
};
/// Writes 8-bit RGB as PNG (sRGB chunk set).
Status WritePng(const std::string& path, const Rgb8Image& image);
Result<Rgb8Image> ReadPng8(const std::string& path);

/// Writes `bytes` under a temporary name and renames the result to `path`.
Status WriteFileAtomically(const std::string& path, const void* bytes, size_t size);
Result<std::string> ReadWholeFile(const std::string& path, size_t max_size);

/// Feeds frames to an ffmpeg process that writes an H.264 .mp4.
class VideoWriter {
 public:
  /// \return kUnsupported if ffmpeg is not installed (message says what to install)
  static Result<std::unique_ptr<VideoWriter>> Create(const std::string& path, int width, int height,
                                                     double fps);
  virtual ~VideoWriter() = default;  ///< without Finish(): the unfinished file is removed
  virtual Status Write(const Rgb8Image& frame) = 0;
  virtual Status Finish() = 0;
};

/// "dir/name.####.exr" or "name.%04d.exr" with the frame number put in.
std::string FrameFileName(const std::string& pattern, int64_t frame);
bool IsFramePattern(const std::string& path);
/// Numbers of the files on disk that match the pattern, sorted.
std::vector<int64_t> FindFrames(const std::string& pattern);

}  // namespace stillray
