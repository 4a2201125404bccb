// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/picture_file.h"

#include <algorithm>
#include <array>
#include <utility>

#include "io/memory_limit.h"
#include "stillray/aov.h"
#include "stillray/frame.h"
#include "stillray/io.h"

namespace stillray {
namespace {

/// Maximum size of a file.
constexpr size_t kMaxFileBytes = size_t{4} << 30;
/// Memory of both images of a comparison and the planes of all metrics: 290 bytes per pixel with 35
/// channels.
constexpr ExrCost kCost = {120, 8};

Image1 TakeLayer(const ExrImage& exr, const char* name) {
  const Channel* channel = exr.Find(name);
  return channel != nullptr ? channel->values : Image1();
}

/// The sum of the light passes of a file without a colour.
Result<Image3> LightOfPasses(const ExrImage& exr, const std::string& path) {
  const Result<AovLayout> layout = UnderstandAovs(exr, AovOptions(), path);
  if (!layout.ok()) {
    return layout.status();
  }
  const Result<Frame> frame = ImportFrame(exr, *layout, {0, 0}, path);
  return frame.ok() ? Result<Image3>(SumOfLight(*frame)) : Result<Image3>(frame.status());
}

/// Whether a channel has this name, possibly after the prefix of its view layer.
bool IsLayer(std::string_view channel, std::string_view name) {
  const size_t before = channel.size() - std::min(channel.size(), name.size());
  return channel.ends_with(name) && (before == 0 || channel[before - 1] == '.');
}

/// The layer of that name; for kAnyObjects, the first layer with object numbers.
const Channel* FindObjects(const ExrImage& exr, const std::string& layer) {
  if (layer != kAnyObjects) {
    return exr.Find(layer);
  }
  for (const std::string_view ending : {"id.X", "IndexOB.X"}) {
    for (const Channel& channel : exr.channels) {
      if (IsLayer(channel.name, ending)) {
        return &channel;
      }
    }
  }
  return nullptr;
}

Image1 TakeObjects(const ExrImage& exr, const std::string& layer) {
  const Channel* channel = FindObjects(exr, layer);
  if (channel == nullptr || channel->integers.empty()) {
    return channel != nullptr ? channel->values : Image1();
  }
  Image1 objects(exr.width, exr.height);
  for (int y = 0; y < exr.height; ++y) {
    for (int x = 0; x < exr.width; ++x) {
      objects(x, y) = static_cast<float>(channel->integers(x, y));
    }
  }
  return objects;
}

Result<PictureFile> DecodeExrPicture(const std::string& bytes, const std::string& path,
                                     const std::string& objects) {
  const Result<ExrImage> exr =
      DecodeExr(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), path);
  if (!exr.ok()) {
    return exr.status();
  }
  Result<Image3> colour = ExrColour(*exr, path);
  if (!colour.ok()) {
    Result<Image3> light = LightOfPasses(*exr, path);
    if (!light.ok()) {
      return colour.status();
    }
    colour = std::move(light);
  }
  PictureFile picture;
  picture.colour = std::move(*colour);
  picture.linear = true;
  picture.depth = TakeLayer(*exr, "depth.Z");
  picture.objects = TakeObjects(*exr, objects);
  Image1 motion_x = TakeLayer(*exr, "motion.X");
  Image1 motion_y = TakeLayer(*exr, "motion.Y");
  if (!motion_x.empty() && !motion_y.empty()) {
    picture.motion[0] = std::move(motion_x);
    picture.motion[1] = std::move(motion_y);
  }
  return picture;
}

}  // namespace

Result<PictureFile> ReadPictureFile(const std::string& path, const std::string& objects) {
  constexpr std::array<char, 4> kExrMagic = {0x76, 0x2f, 0x31, 0x01};
  const Result<std::string> bytes = ReadWholeFile(path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  if (bytes->size() >= kExrMagic.size() &&
      std::equal(kExrMagic.begin(), kExrMagic.end(), bytes->begin())) {
    STILLRAY_RETURN_IF_ERROR(CheckExrFits(*bytes, path, kCost));
    return DecodeExrPicture(*bytes, path, objects);
  }
  PictureFile picture;
  Result<Image3> colour = DecodeImage(reinterpret_cast<const uint8_t*>(bytes->data()),
                                      bytes->size(), path, &picture.linear);
  if (!colour.ok()) {
    return colour.status();
  }
  picture.colour = std::move(*colour);
  return picture;
}

}  // namespace stillray
