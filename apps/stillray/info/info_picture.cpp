// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "info/info_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "core/printable.h"
#include "io/memory_limit.h"
#include "stillray/aov.h"

namespace stillray {

namespace {

constexpr int kRowsPerTask = 32;
constexpr size_t kMaxFileBytes = size_t{4} << 30;
/// Memory of all channels and of the file: 220 B per pixel with 35 channels.
constexpr ExrCost kCost = {10, 8};
constexpr size_t kMaxShownAttribute = 120;  // characters; JSON contains the full text
constexpr const char* kMainLayer = "(main)";

void Include(ValueRange* range, const ValueRange& part) {
  if (part.finite() > 0) {
    const bool first = range->finite() == 0;
    range->min = first ? part.min : std::min(range->min, part.min);
    range->max = first ? part.max : std::max(range->max, part.max);
  }
  range->count += part.count;
  range->nan += part.nan;
  range->infinite += part.infinite;
  range->negative += part.negative;
  range->sum += part.sum;
}

template <typename T>
ValueRange RowRange(const T* row, int width) {
  ValueRange range;
  range.count = width;
  range.min = std::numeric_limits<double>::infinity();
  range.max = -range.min;
  for (int x = 0; x < width; ++x) {
    const double value = static_cast<double>(row[x]);
    if (std::isnan(value)) {
      ++range.nan;
    } else if (std::isinf(value)) {
      ++range.infinite;
    } else {
      range.negative += value < 0;
      range.min = std::min(range.min, value);
      range.max = std::max(range.max, value);
      range.sum += value;
    }
  }
  return range;
}

/// Processes rows in parallel, and sums them in order.
template <typename T>
ValueRange PlaneRange(const Plane<T>& plane) {
  std::vector<ValueRange> rows(static_cast<size_t>(plane.height()));
  ParallelRows(plane.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      rows[static_cast<size_t>(y)] = RowRange(plane.Row(y), plane.width());
    }
  });
  ValueRange range;
  for (const ValueRange& row : rows) {
    Include(&range, row);
  }
  return range;
}

/// Sort key: R, G, B and X, Y, Z in this order; EXR files sort channels alphabetically.
int ChannelOrder(const std::string& name) {
  static constexpr std::string_view kOrder = "RGBrgbXYZWUVAa";
  const size_t at = name.size() == 1 ? kOrder.find(name[0]) : std::string_view::npos;
  return at == std::string_view::npos ? static_cast<int>(kOrder.size()) : static_cast<int>(at);
}

std::vector<LayerInfo> DescribeLayers(const ExrImage& image) {
  std::vector<LayerInfo> layers;
  for (const Channel& channel : image.channels) {
    const size_t dot = channel.name.rfind('.');
    const std::string layer_name = dot == std::string::npos ? "" : channel.name.substr(0, dot);
    auto layer = std::find_if(layers.begin(), layers.end(),
                              [&](const LayerInfo& l) { return l.name == layer_name; });
    if (layer == layers.end()) {
      layer = layers.insert(layers.end(), LayerInfo{layer_name, {}, {}});
    }
    ChannelInfo info;
    info.name = dot == std::string::npos ? channel.name : channel.name.substr(dot + 1);
    info.type = channel.type;
    info.values = channel.type == PixelType::kUint32 ? PlaneRange(channel.integers)
                                                     : PlaneRange(channel.values);
    Include(&layer->values, info.values);
    layer->channels.push_back(std::move(info));
  }
  for (LayerInfo& layer : layers) {
    std::stable_sort(layer.channels.begin(), layer.channels.end(),
                     [](const ChannelInfo& a, const ChannelInfo& b) {
                       return ChannelOrder(a.name) < ChannelOrder(b.name);
                     });
  }
  return layers;
}

Result<PictureInfo> DescribeExr(const uint8_t* data, size_t size, const AovOptions& aovs,
                                PictureInfo info) {
  Result<ExrImage> image = DecodeExr(data, size, info.path);
  if (!image.ok()) {
    return image.status();
  }
  info.format = "EXR";
  info.width = image->width;
  info.height = image->height;
  info.layers = DescribeLayers(*image);
  info.compression = image->compression_name;
  info.tiled = image->tiled;
  info.data_window = image->data_window;
  info.display_window = image->display_window;
  info.attributes = image->attributes;
  info.attributes.insert(image->other_attributes.begin(), image->other_attributes.end());
  info.notes = image->notes;
  const Result<AovLayout> layout = UnderstandAovs(*image, aovs, info.path);
  if (!layout.ok() && !aovs.view_layer.empty()) {
    return layout.status();
  }
  info.aovs = layout.ok() ? AovTable(*layout) : "";
  return info;
}

const char* FormatName(std::string_view bytes) {
  return bytes.starts_with("\x89PNG") ? "PNG" : bytes.starts_with("#?") ? "HDR" : "JPEG";
}

const char* TypeName(PixelType type) {
  switch (type) {
    case PixelType::kHalf:
      return "half";
    case PixelType::kFloat:
      return "float";
    case PixelType::kUint32:
      return "uint32";
  }
  return "?";
}

std::string ChannelList(const LayerInfo& layer) {
  std::string text;
  for (const ChannelInfo& channel : layer.channels) {
    text += (text.empty() ? "" : " ") + channel.name;
  }
  return text;
}

/// "half", or "half+float" if channels of a layer differ.
std::string TypeList(const LayerInfo& layer) {
  std::string text;
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat, PixelType::kUint32}) {
    if (std::any_of(layer.channels.begin(), layer.channels.end(),
                    [&](const ChannelInfo& c) { return c.type == type; })) {
      text += (text.empty() ? "" : "+") + std::string(TypeName(type));
    }
  }
  return text;
}

/// The value as a single line without control characters, truncated if too long.
std::string Shown(const std::string& value) {
  std::string text = value.substr(0, kMaxShownAttribute);
  for (char& c : text) {
    c = static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return value.size() > kMaxShownAttribute ? text + "..." : text;
}

std::string WindowText(const ExrWindow& w) {
  return fmt::format("({}, {}) - ({}, {})", w.x_min, w.y_min, w.x_max, w.y_max);
}

std::string LayerTable(const PictureInfo& info) {
  size_t name_width = std::string_view(kMainLayer).size();
  size_t channel_width = std::string_view("channels").size();
  for (const LayerInfo& layer : info.layers) {
    name_width = std::max(name_width, Shown(layer.name).size());
    channel_width = std::max(channel_width, Shown(ChannelList(layer)).size());
  }
  std::string text =
      fmt::format("\n{:<{}}  {:<{}}  {:<10}  {:>11}  {:>11}  {:>11}  {:>8}  {:>8}  {:>8}\n",
                  "layer", name_width, "channels", channel_width, "type", "min", "mean", "max",
                  "NaN", "inf", "negative");
  for (const LayerInfo& layer : info.layers) {
    const ValueRange& v = layer.values;
    const auto number = [&](double value) {
      return v.finite() == 0 ? std::string("-") : fmt::format("{:.5g}", value);
    };
    text += fmt::format("{:<{}}  {:<{}}  {:<10}  {:>11}  {:>11}  {:>11}  {:>8}  {:>8}  {:>8}\n",
                        layer.name.empty() ? kMainLayer : Shown(layer.name), name_width,
                        Shown(ChannelList(layer)), channel_width, TypeList(layer), number(v.min),
                        number(v.mean()), number(v.max), v.nan, v.infinite, v.negative);
  }
  return text;
}

nlohmann::ordered_json RangeJson(const ValueRange& range) {
  nlohmann::ordered_json json;
  if (range.finite() > 0) {
    json["min"] = range.min;
    json["mean"] = range.mean();
    json["max"] = range.max;
  } else {
    json["min"] = nullptr;
    json["mean"] = nullptr;
    json["max"] = nullptr;
  }
  json["nan"] = range.nan;
  json["infinite"] = range.infinite;
  json["negative"] = range.negative;
  return json;
}

nlohmann::ordered_json WindowJson(const ExrWindow& w) {
  return {{"x_min", w.x_min}, {"y_min", w.y_min}, {"x_max", w.x_max}, {"y_max", w.y_max}};
}

}  // namespace

Result<PictureInfo> DescribePicture(const std::string& path, const AovOptions& aovs) {
  const Result<std::string> bytes = ReadWholeFile(path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  const auto* data = reinterpret_cast<const uint8_t*>(bytes->data());
  PictureInfo info;
  info.path = path;
  info.file_bytes = bytes->size();
  constexpr std::string_view kExrSignature = "\x76\x2f\x31\x01";
  if (bytes->starts_with(kExrSignature)) {
    STILLRAY_RETURN_IF_ERROR(CheckExrFits(*bytes, path, kCost));
    return DescribeExr(data, bytes->size(), aovs, std::move(info));
  }
  Result<Image3> image = DecodeImage(data, bytes->size(), path, &info.linear);
  if (!image.ok()) {
    return image.status();
  }
  info.format = FormatName(*bytes);
  info.width = image->width();
  info.height = image->height();
  LayerInfo layer;
  for (int c = 0; c < 3; ++c) {
    ChannelInfo channel;
    channel.name = std::string(1, "RGB"[c]);
    channel.values = PlaneRange((*image)[c]);
    Include(&layer.values, channel.values);
    layer.channels.push_back(std::move(channel));
  }
  info.layers.push_back(std::move(layer));
  return info;
}

std::string PictureText(const PictureInfo& info) {
  std::string text = fmt::format("{}: {}, {} x {} pixels, {} bytes\n", Printable(info.path),
                                 info.format, info.width, info.height, info.file_bytes);
  if (info.format == "EXR") {
    text += fmt::format("compression     {}, {}\n", info.compression,
                        info.tiled ? "tiles" : "scanlines");
    text += fmt::format("data window     {}\n", WindowText(info.data_window));
    text += fmt::format("display window  {}\n", WindowText(info.display_window));
    for (const std::string& note : info.notes) {
      text += fmt::format("note            {}\n", Shown(note));
    }
  } else {
    text +=
        fmt::format("values          {}\n", info.linear ? "linear" : "linear, decoded from sRGB");
  }
  text += LayerTable(info);
  text += info.aovs.empty() ? "" : "\n" + info.aovs;
  if (!info.attributes.empty()) {
    text += "\nattributes\n";
    for (const auto& [name, value] : info.attributes) {
      text += fmt::format("  {} = {}\n", Shown(name), Shown(value));
    }
  }
  return text;
}

nlohmann::ordered_json PictureJson(const PictureInfo& info) {
  nlohmann::ordered_json json;
  json["file"] = info.path;
  json["kind"] = "picture";
  json["format"] = info.format;
  json["file_bytes"] = info.file_bytes;
  json["width"] = info.width;
  json["height"] = info.height;
  json["decoded_from_srgb"] = !info.linear;
  if (info.format == "EXR") {
    json["compression"] = info.compression;
    json["tiled"] = info.tiled;
    json["data_window"] = WindowJson(info.data_window);
    json["display_window"] = WindowJson(info.display_window);
    json["attributes"] = info.attributes;
    json["notes"] = info.notes;
    json["aovs"] = info.aovs;
  }
  json["layers"] = nlohmann::ordered_json::array();
  for (const LayerInfo& layer : info.layers) {
    nlohmann::ordered_json layer_json;
    layer_json["name"] = layer.name;
    layer_json.update(RangeJson(layer.values));
    layer_json["channels"] = nlohmann::ordered_json::array();
    for (const ChannelInfo& channel : layer.channels) {
      nlohmann::ordered_json channel_json;
      channel_json["name"] = channel.name;
      // The pixel type of formats other than EXR is not returned by decoding.
      if (info.format == "EXR") {
        channel_json["type"] = TypeName(channel.type);
      }
      channel_json.update(RangeJson(channel.values));
      layer_json["channels"].push_back(std::move(channel_json));
    }
    json["layers"].push_back(std::move(layer_json));
  }
  return json;
}

}  // namespace stillray
