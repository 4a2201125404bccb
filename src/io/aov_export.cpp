// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Writes a copy of a file with replaced radiance. Exceptions of OpenEXR are caught in this file.
#include <Imath/half.h>
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepScanLineInputPart.h>
#include <OpenEXR/ImfDeepScanLineOutputPart.h>
#include <OpenEXR/ImfDeepTiledInputPart.h>
#include <OpenEXR/ImfDeepTiledOutputPart.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTiledInputPart.h>
#include <OpenEXR/ImfTiledOutputPart.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <new>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "io/exr_stored.h"
#include "io/exr_stream.h"
#include "io/exr_zip.h"
#include "io/text.h"
#include "stillray/aov.h"

namespace stillray {
namespace {

constexpr float kHalfMax = 65504.0f;

/// Channels by the names of ReadExr, and the plane to store in each.
using NewLight = std::map<std::string, const Image1*>;

/// The planes to write to one part, by the channel names of the file.
struct PartPlan {
  NewLight light;  ///< existing channels of the part
  NewLight added;  ///< new channels
  Imf::Header header;
};

/// Clamps to the range of a half, so that finite values stay finite.
void Store(float value, Imf::PixelType type, char* to) {
  if (type == Imf::HALF) {
    const half h(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value);
    std::memcpy(to, &h, sizeof(h));
  } else {
    std::memcpy(to, &value, sizeof(value));
  }
}

/// Copies the plane, which covers the display window, to the overlap with the part's data window;
/// overscan is left unchanged.
void Put(const Image1& plane, const Imath::Box2i& data, const Imath::Box2i& display,
         io::StoredPlane* stored) {
  for (int y = std::max(data.min.y, display.min.y); y <= std::min(data.max.y, display.max.y); ++y) {
    const float* row = plane.Row(y - display.min.y);
    char* to = stored->Row(y - data.min.y);
    for (int x = std::max(data.min.x, display.min.x); x <= std::min(data.max.x, display.max.x);
         ++x) {
      Store(row[x - display.min.x], stored->type,
            to + static_cast<size_t>(x - data.min.x) * io::BytesOf(stored->type));
    }
  }
}

bool IsLossyAgain(Imf::Compression compression) {
  return compression == Imf::DWAA_COMPRESSION || compression == Imf::DWAB_COMPRESSION;
}

bool SameSize(const Imath::Box2i& a, const Imath::Box2i& b) {
  return a.max.x - a.min.x == b.max.x - b.min.x && a.max.y - a.min.y == b.max.y - b.min.y;
}

/// Whether ReadExr reads the part's channels.
bool IsRead(const Imf::MultiPartInputFile& file, int part) {
  const Imf::Header& header = file.header(part);
  return part == 0 || (!(header.hasType() && Imf::isDeepData(header.type())) &&
                       SameSize(header.displayWindow(), file.header(0).displayWindow()));
}

/// Assigns the new planes to parts, by the names that ReadExr gives to channels: where a name is
/// taken, the part's name is the prefix.
std::vector<PartPlan> PlanParts(const Imf::MultiPartInputFile& file, NewLight light) {
  std::vector<PartPlan> plans(static_cast<size_t>(file.parts()));
  std::set<std::string> taken;
  for (int i = 0; i < file.parts(); ++i) {
    PartPlan& plan = plans[static_cast<size_t>(i)];
    plan.header = file.header(i);
    if (!IsRead(file, i)) {
      continue;
    }
    const Imf::ChannelList& list = plan.header.channels();
    bool clash = false;
    for (auto it = list.begin(); it != list.end(); ++it) {
      clash = clash || taken.count(it.name()) != 0;
    }
    const std::string part_name =
        plan.header.hasName() ? plan.header.name() : fmt::format("part{}", i);
    for (auto it = list.begin(); it != list.end(); ++it) {
      const std::string name = clash ? fmt::format("{}.{}", part_name, it.name()) : it.name();
      taken.insert(name);
      if (const auto at = light.find(name); at != light.end()) {
        plan.light[it.name()] = at->second;
        light.erase(at);
      }
    }
  }
  plans[0].added = std::move(light);
  for (PartPlan& plan : plans) {
    if (!plan.added.empty() || !plan.light.empty()) {
      for (const auto& [name, plane] : plan.added) {
        plan.header.channels().insert(name, Imf::Channel(Imf::HALF));
      }
      if (IsLossyAgain(plan.header.compression())) {
        plan.header.compression() = Imf::ZIP_COMPRESSION;
      }
    }
  }
  return plans;
}

/// Reads the part's pixels that are not yet loaded, inserts the new radiance, and writes the part.
/// \param planes  the part's pixels as stored, or nothing
template <typename Output>
void RewritePart(Imf::MultiPartInputFile& in, Imf::MultiPartOutputFile& out, int part,
                 const PartPlan& plan, io::StoredPart planes, const Output& write) {
  const Imath::Box2i data = plan.header.dataWindow();
  const Imath::Box2i display = plan.header.displayWindow();
  const bool decoded = !planes.empty();
  Imf::FrameBuffer input_buffer;
  Imf::FrameBuffer output_buffer;
  const Imf::ChannelList& list = plan.header.channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    io::StoredPlane& plane = planes.try_emplace(it.name(), it.channel().type, data).first->second;
    output_buffer.insert(it.name(), plane.Slice(data));
    if (plan.added.count(it.name()) == 0) {
      input_buffer.insert(it.name(), plane.Slice(data));
    }
  }
  if (!decoded) {
    Imf::InputPart input(in, part);
    input.setFrameBuffer(input_buffer);
    input.readPixels(data.min.y, data.max.y);
  }
  for (const NewLight* light : {&plan.light, &plan.added}) {
    for (const auto& [name, plane] : *light) {
      Put(*plane, data, display, &planes.at(name));
    }
  }
  write(out, part, data, output_buffer);
}

void WriteLines(Imf::MultiPartOutputFile& out, int part, const Imath::Box2i& data,
                const Imf::FrameBuffer& buffer) {
  Imf::OutputPart output(out, part);
  if (io::CanEncodeZip(output.header())) {
    // Copies the compressed bytes.
    const std::string bytes = io::EncodeZip(output.header(), buffer);
    io::ExrMemoryInput stream(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(),
                              "memory");
    Imf::InputFile compressed(stream);
    output.copyPixels(compressed);
    return;
  }
  output.setFrameBuffer(buffer);
  output.writePixels(data.max.y - data.min.y + 1);
}

void WriteTiles(Imf::MultiPartOutputFile& out, int part, const Imath::Box2i&,
                const Imf::FrameBuffer& buffer) {
  Imf::TiledOutputPart output(out, part);
  output.setFrameBuffer(buffer);
  output.writeTiles(0, output.numXTiles(0) - 1, 0, output.numYTiles(0) - 1);
}

/// Copies the part without decompressing it.
void CopyPart(Imf::MultiPartInputFile& in, Imf::MultiPartOutputFile& out, int part,
              const std::string& type) {
  if (type == Imf::DEEPSCANLINE) {
    Imf::DeepScanLineInputPart input(in, part);
    Imf::DeepScanLineOutputPart(out, part).copyPixels(input);
  } else if (type == Imf::DEEPTILE) {
    Imf::DeepTiledInputPart input(in, part);
    Imf::DeepTiledOutputPart(out, part).copyPixels(input);
  } else if (type == Imf::TILEDIMAGE) {
    Imf::TiledInputPart input(in, part);
    Imf::TiledOutputPart(out, part).copyPixels(input);
  } else {
    Imf::InputPart input(in, part);
    Imf::OutputPart(out, part).copyPixels(input);
  }
}

std::string TypeOf(const Imf::Header& header) {
  return header.hasType()              ? header.type()
         : header.hasTileDescription() ? Imf::TILEDIMAGE
                                       : Imf::SCANLINEIMAGE;
}

std::string Rewrite(Imf::MultiPartInputFile& in, NewLight light,
                    std::map<int, io::StoredPart> stored) {
  std::vector<PartPlan> plans = PlanParts(in, std::move(light));
  std::vector<Imf::Header> headers;
  for (PartPlan& plan : plans) {
    const bool changed = !plan.light.empty() || !plan.added.empty();
    // Smaller mip levels would contain the old radiance; a file without them is still valid.
    if (changed && plan.header.hasTileDescription()) {
      plan.header.tileDescription().mode = Imf::ONE_LEVEL;
    }
    // The writer sorts lines itself.
    if (changed) {
      plan.header.lineOrder() = Imf::INCREASING_Y;
    }
    plan.header.setType(TypeOf(plan.header));
    headers.push_back(plan.header);
  }
  io::ExrMemoryOutput stream;
  {
    Imf::MultiPartOutputFile out(stream, headers.data(), static_cast<int>(headers.size()));
    for (int i = 0; i < in.parts(); ++i) {
      const PartPlan& plan = plans[static_cast<size_t>(i)];
      const std::string type = TypeOf(plan.header);
      if (plan.light.empty() && plan.added.empty()) {
        CopyPart(in, out, i, type);
      } else if (type == Imf::TILEDIMAGE) {
        RewritePart(in, out, i, plan, std::move(stored[i]), WriteTiles);
      } else {
        RewritePart(in, out, i, plan, std::move(stored[i]), WriteLines);
      }
    }
  }  // the destructor writes the line table
  return stream.Take();
}

/// The layer for the result if the file has none: "Combined" beside Blender's passes, else
/// "denoised".
std::array<std::string, 3> NamesForNewLayer(const AovLayout& layout) {
  std::string prefix;
  if (const AovSource* pass = layout.Find(Aov::kDirectDiffuse)) {
    const size_t dot = pass->layer.rfind('.');
    prefix = dot == std::string::npos ? "" : pass->layer.substr(0, dot + 1);
  }
  prefix += layout.renderer == "blender" ? "Combined" : "denoised";
  return {prefix + ".R", prefix + ".G", prefix + ".B"};
}

Status CheckSize(const Imf::MultiPartInputFile& file, const Image3& colour,
                 const std::string& name) {
  const Imath::Box2i display = file.header(0).displayWindow();
  const int64_t width = int64_t{display.max.x} - display.min.x + 1;
  const int64_t height = int64_t{display.max.y} - display.min.y + 1;
  if (width != colour.width() || height != colour.height()) {
    return Status::InvalidArgument(fmt::format("{}: has {} x {} pixels, the new light {} x {}",
                                               name, width, height, colour.width(),
                                               colour.height()));
  }
  return Status::Ok();
}

}  // namespace

StoredPixels::StoredPixels() = default;
StoredPixels::StoredPixels(StoredPixels&&) noexcept = default;
StoredPixels& StoredPixels::operator=(StoredPixels&&) noexcept = default;
StoredPixels::~StoredPixels() = default;

Result<std::string> ReplaceLight(const std::string& original, const AovLayout& layout,
                                 const Image3& colour, const std::string& name,
                                 const std::vector<NewLayer>& layers, StoredPixels stored) {
  const AovSource* target = layout.Find(Aov::kResult);
  if (target == nullptr) {
    target = layout.Find(Aov::kColour);
  }
  const std::array<std::string, 3> added = NamesForNewLayer(layout);
  NewLight light;
  for (const NewLayer& layer : layers) {
    const AovSource* source = layout.Find(layer.aov);
    for (size_t c = 0; source != nullptr && c < std::min(source->channels.size(), size_t{3}); ++c) {
      light[source->channels[c]] = &layer.values[static_cast<int>(c)];
    }
  }
  for (size_t c = 0; c < 3; ++c) {
    light[target != nullptr ? target->channels[c] : added[c]] = &colour[static_cast<int>(c)];
  }
  try {
    io::PrepareOpenExr();
    io::ExrMemoryInput stream(reinterpret_cast<const uint8_t*>(original.data()), original.size(),
                              name);
    Imf::MultiPartInputFile file(stream);
    STILLRAY_RETURN_IF_ERROR(CheckSize(file, colour, name));
    for (const NewLayer& layer : layers) {
      STILLRAY_RETURN_IF_ERROR(CheckSize(file, layer.values, name));
    }
    return Rewrite(
        file, std::move(light),
        stored.empty() ? std::map<int, io::StoredPart>() : std::move(stored.impl_->parts));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory to write it again", name));
  } catch (const std::exception& error) {
    return Status::BadData(
        fmt::format("{}: cannot be written again: {}", name, io::OneLine(error.what())));
  }
}

}  // namespace stillray
