// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/exr_stream.h"
#include "io/text.h"
#include "stillray/io.h"

namespace stillray {

namespace {

constexpr std::array<const char*, 3> kRgb = {"R", "G", "B"};
constexpr std::array<const char*, 3> kXyz = {"X", "Y", "Z"};

/// Prefixes, with their dot, of all layers that have R, G and B.
std::vector<std::string> ColourLayers(const ExrImage& image) {
  std::vector<std::string> layers;
  for (const Channel& channel : image.channels) {
    if (!channel.name.ends_with("R")) {
      continue;
    }
    const std::string prefix = channel.name.substr(0, channel.name.size() - 1);
    const bool is_layer = prefix.empty() || prefix.back() == '.';
    if (is_layer && image.Find(prefix + "G") && image.Find(prefix + "B")) {
      layers.push_back(prefix);
    }
  }
  return layers;
}

std::string ChannelNames(const ExrImage& image) {
  constexpr size_t kMaxShownName = 100;
  constexpr size_t kMostNames = 40;  // enough for an overview, short enough for one line
  std::vector<std::string> names;
  for (const Channel& channel : image.channels) {
    if (names.size() == kMostNames) {
      names.push_back("...");
      break;
    }
    names.push_back(io::OneLine(channel.name, kMaxShownName));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

Image1 AsFloat(const Channel& channel) {
  if (channel.type != PixelType::kUint32) {
    return channel.values;
  }
  const Plane<uint32_t>& from = channel.integers;
  Image1 to(from.width(), from.height());
  for (int y = 0; y < from.height(); ++y) {
    for (int x = 0; x < from.width(); ++x) {
      to(x, y) = static_cast<float>(from(x, y));
    }
  }
  return to;
}

Status NoColour(const ExrImage& image, const std::string& name,
                const std::vector<std::string>& layers) {
  if (layers.empty()) {
    return Status::NotFound(
        fmt::format("{}: no colour picture (channels R, G, B) was found among its channels {}",
                    name, ChannelNames(image)));
  }
  return Status::NotFound(fmt::format(
      "{}: has no main picture but {} layers with R, G and B ({}); which one is meant is "
      "not clear",
      name, layers.size(), io::OneLine(fmt::format("{}", fmt::join(layers, ", ")))));
}

}  // namespace

const Channel* ExrImage::Find(const std::string& name) const {
  for (const Channel& channel : channels) {
    if (channel.name == name) {
      return &channel;
    }
  }
  return nullptr;
}

void ExrImage::Add(const std::string& name, PixelType type, const Image1& values) {
  Channel channel;
  channel.name = name;
  channel.type = type;
  channel.values = values;
  channels.push_back(std::move(channel));
}

void ExrImage::Add(const std::string& name, const Plane<uint32_t>& integers) {
  Channel channel;
  channel.name = name;
  channel.type = PixelType::kUint32;
  channel.integers = integers;
  channels.push_back(std::move(channel));
}

void ExrImage::Add(const std::string& prefix, PixelType type, const Image3& image, bool xyz) {
  const auto& letters = xyz ? kXyz : kRgb;
  for (int c = 0; c < 3; ++c) {
    Add(prefix + letters[static_cast<size_t>(c)], type, image[c]);
  }
}

Result<Image3> ExrLayer(const ExrImage& image, const std::string& prefix, bool xyz) {
  const auto& letters = xyz ? kXyz : kRgb;
  Image3 result;
  for (int c = 0; c < 3; ++c) {
    const std::string name = prefix + letters[static_cast<size_t>(c)];
    const Channel* channel = image.Find(name);
    if (channel == nullptr) {
      return Status::NotFound(
          fmt::format("there is no channel {} among {}", name, ChannelNames(image)));
    }
    result[c] = AsFloat(*channel);
  }
  return result;
}

Result<Image3> ExrColour(const ExrImage& image, const std::string& name) {
  const std::vector<std::string> layers = ColourLayers(image);
  if (std::find(layers.begin(), layers.end(), "") != layers.end()) {
    return ExrLayer(image, "");
  }
  const auto is_combined = [](const std::string& prefix) { return prefix.ends_with("Combined."); };
  if (std::count_if(layers.begin(), layers.end(), is_combined) == 1) {
    return ExrLayer(image, *std::find_if(layers.begin(), layers.end(), is_combined));
  }
  if (layers.size() == 1) {
    return ExrLayer(image, layers[0]);
  }
  if (const Channel* grey = image.Find("Y"); grey != nullptr && layers.empty()) {
    Image3 result;
    result[0] = AsFloat(*grey);
    result[1] = result[0];
    result[2] = result[0];
    return result;
  }
  return NoColour(image, name, layers);
}

namespace {

std::mutex& ExrSetupMutex() {
  static std::mutex mutex;
  return mutex;
}
bool exr_is_prepared = false;  // guarded by ExrSetupMutex

void PrepareLocked(int threads) {
  // Larger than the accepted size, so that stillray's message comes first, yet small enough that
  // the line and tile tables that OpenEXR allocates from the header stay small.
  constexpr int kMaxClaim = 1 << 16;
  Imf::Header::setMaxImageSize(kMaxClaim, kMaxClaim);
  Imf::Header::setMaxTileSize(kMaxClaim, kMaxClaim);
  Imf::setGlobalThreadCount(threads);
  exr_is_prepared = true;
}

}  // namespace

void SetExrThreads(int count) {
  const std::lock_guard<std::mutex> lock(ExrSetupMutex());
  PrepareLocked(std::max(count, 0));
}

namespace io {

void PrepareOpenExr() {
  const std::lock_guard<std::mutex> lock(ExrSetupMutex());
  if (!exr_is_prepared) {
    PrepareLocked(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  }
}

bool ExrMemoryInput::read(char bytes[], int count) {
  if (count < 0 || position_ > size_ || static_cast<uint64_t>(count) > size_ - position_) {
    throw std::runtime_error("the file ends too early");
  }
  std::memcpy(bytes, data_ + position_, static_cast<size_t>(count));
  position_ += static_cast<uint64_t>(count);
  return position_ < size_;
}

void ExrMemoryOutput::write(const char bytes[], int count) {
  if (count <= 0) {
    return;
  }
  const size_t end = static_cast<size_t>(position_) + static_cast<size_t>(count);
  if (bytes_.size() < end) {
    bytes_.resize(end);
  }
  std::memcpy(bytes_.data() + position_, bytes, static_cast<size_t>(count));
  position_ = end;
}

}  // namespace io

}  // namespace stillray
