// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Describes an image file for `stillray info`.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "stillray/aov.h"
#include "stillray/io.h"
#include "stillray/status.h"

namespace stillray {

/// Range of one channel, or of all channels of a layer.
struct ValueRange {
  int64_t count = 0;  ///< number of values, including non-finite ones
  int64_t nan = 0;
  int64_t infinite = 0;
  int64_t negative = 0;  ///< finite and below zero
  /// Minimum, maximum and sum of the finite values; undefined if there are none.
  double min = 0;
  double max = 0;
  double sum = 0;

  int64_t finite() const { return count - nan - infinite; }
  double mean() const { return sum / static_cast<double>(finite()); }
};

struct ChannelInfo {
  std::string name;  ///< channel name without its layer
  PixelType type = PixelType::kFloat;
  ValueRange values;
};

struct LayerInfo {
  std::string name;  ///< layer name without the last dot; empty for the main image
  std::vector<ChannelInfo> channels;
  ValueRange values;
};

struct PictureInfo {
  std::string path;
  std::string format;  ///< "EXR", "HDR", "PNG", "JPEG"
  uint64_t file_bytes = 0;
  int width = 0;
  int height = 0;
  bool linear = true;  ///< false: the values were decoded from sRGB
  std::vector<LayerInfo> layers;

  // Only for EXR files.
  std::string compression;
  bool tiled = false;
  ExrWindow data_window;
  ExrWindow display_window;
  std::map<std::string, std::string> attributes;
  std::vector<std::string> notes;
  std::string aovs;  ///< roles of the layers for `stillray denoise`; empty: none
};

/// \param aovs  options for the roles of an EXR file's layers
Result<PictureInfo> DescribePicture(const std::string& path, const AovOptions& aovs);
std::string PictureText(const PictureInfo& info);
nlohmann::ordered_json PictureJson(const PictureInfo& info);

}  // namespace stillray
