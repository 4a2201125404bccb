// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/render_files.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include "core/status_prefix.h"

namespace stillray {
namespace {

/// Depth and motion need more precision than a half, and one float per pixel is cheap.
constexpr PixelType kExact = PixelType::kFloat;

void AddGuide(const std::string& name, const Frame& frame, PixelType type, ExrImage* image) {
  const Guides& g = frame.guides;
  if (name == "motion" && !g.motion.empty()) {
    image->Add("motion.X", kExact, g.motion[0]);
    image->Add("motion.Y", kExact, g.motion[1]);
  } else if (name == "depth") {
    image->Add("depth.Z", kExact, g.depth);
  } else if (name == "normal") {
    image->Add("normal.", type, g.normal, true);
  } else if (name == "albedo") {
    image->Add("albedo.", type, g.albedo);
  } else if (name == "specular_albedo") {
    image->Add("specular_albedo.", type, g.specular_albedo);
  } else if (name == "transmission_albedo" && !g.transmission_albedo.empty()) {
    image->Add("transmission_albedo.", type, g.transmission_albedo);
  } else if (name == "id") {
    image->Add("id.X", g.id);
  } else if (name == "roughness") {
    image->Add("roughness.X", type, g.roughness);
  } else if (name == "emission") {
    image->Add("emission.", type, frame.emission);
  } else if (name == "background") {
    image->Add("background.", type, frame.background);
  }
}

void AddVirtualGuides(const std::string& name, const VirtualGuides& guides, PixelType type,
                      ExrImage* image) {
  if (guides.empty()) {
    return;
  }
  image->Add(name + "_depth.Z", kExact, guides.depth);
  image->Add(name + "_normal.", type, guides.normal, true);
  image->Add(name + "_albedo.", type, guides.albedo);
  image->Add(name + "_motion.X", kExact, guides.motion[0]);
  image->Add(name + "_motion.Y", kExact, guides.motion[1]);
  image->Add(name + "_id.X", guides.id);
}

void Describe(const RenderOptions& options, const Frame& frame, ExrImage* image) {
  image->width = frame.width;
  image->height = frame.height;
  image->attributes["stillray"] = STILLRAY_VERSION;
  // Images are published: the attribute has the scene's file name without folders.
  image->attributes["scene"] = FileNameOf(options.text.scene);
  image->attributes["frame"] = fmt::format("{}", frame.index);
  image->attributes["jitter"] = fmt::format("{} {}", frame.jitter_x, frame.jitter_y);
  image->attributes["focal_pixels"] = fmt::format("{}", frame.focal_pixels);
}

/// The display image, if required by --format, and its encoded files in memory.
struct EncodedPicture {
  struct File {
    const char* extension;
    Result<std::string> bytes;
  };
  Rgb8Image display;
  std::vector<File> files;
};

void EncodePicture(const RenderOptions& options, int64_t frame, const Image3& colour,
                   EncodedPicture* out) {
  if (!options.png && !options.jpg && !options.mp4) {
    return;
  }
  out->display.width = colour.width();
  out->display.height = colour.height();
  out->display.pixels = ToDisplay(colour, options.denoise.exposure, options.denoise.tonemap,
                                  options.denoise.dither, frame);
  if (options.png) {
    out->files.push_back({"png", EncodePng(out->display)});
  }
  if (options.jpg) {
    out->files.push_back({"jpg", EncodeJpeg(out->display)});
  }
}

Status WriteEncoded(const RenderOptions& options, const std::string& view, int64_t frame,
                    const EncodedPicture& picture, std::vector<std::string>* written) {
  for (const EncodedPicture::File& file : picture.files) {
    const std::string path =
        FrameFileName(ViewPattern(options.text.folder, view, file.extension), frame);
    if (!file.bytes.ok()) {
      return PrefixStatus(path, file.bytes.status());
    }
    STILLRAY_RETURN_IF_ERROR(WriteFileAtomically(path, file.bytes->data(), file.bytes->size()));
    written->push_back(path);
  }
  return Status::Ok();
}

Status WritePicture(const RenderOptions& options, const std::string& view, int64_t frame,
                    const Image3& colour, std::vector<std::string>* written) {
  if (!options.png && !options.jpg) {
    return Status::Ok();
  }
  EncodedPicture picture;
  EncodePicture(options, frame, colour, &picture);
  return WriteEncoded(options, view, frame, picture, written);
}

Status WriteExrFile(const RenderOptions& options, const std::string& view, int64_t frame,
                    const ExrImage& image, std::vector<std::string>* written) {
  const std::string path = FrameFileName(ViewPattern(options.text.folder, view, "exr"), frame);
  written->push_back(path);
  return WriteExr(path, image);
}

Status WritePlainView(const RenderOptions& options, const Frame& frame, const std::string& view,
                      const Image3& colour, std::vector<std::string>* written) {
  if (options.exr) {
    ExrImage image;
    Describe(options, frame, &image);
    image.Add("", options.exr_type, colour);
    for (const char* name : {"motion", "depth"}) {
      if (options.WritesGuide(name)) {
        AddGuide(name, frame, options.exr_type, &image);
      }
    }
    STILLRAY_RETURN_IF_ERROR(WriteExrFile(options, view, frame.index, image, written));
  }
  return WritePicture(options, view, frame.index, colour, written);
}

/// Writes all files except for the denoised display image.
Status WriteOtherFiles(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out,
                       const Image3* reference, std::vector<std::string>* written) {
  if (options.exr && options.text.save_inputs) {
    STILLRAY_RETURN_IF_ERROR(
        WriteExrFile(options, "noisy", frame.index, NoisyExr(options, frame), written));
  }
  if (options.exr) {
    STILLRAY_RETURN_IF_ERROR(
        WriteExrFile(options, "denoised", frame.index, DenoisedExr(options, frame, out), written));
  }
  if ((options.png || options.jpg) && options.text.save_inputs) {
    STILLRAY_RETURN_IF_ERROR(
        WritePicture(options, "noisy", frame.index, SumOfLight(frame), written));
  }
  for (const NamedImage& named : out.images) {
    if (IsPictureOutput(named.name)) {
      Image3 colour(frame.width, frame.height);
      for (int c = 0; c < 3; ++c) {
        colour[c] = named.channels[static_cast<size_t>(c)];
      }
      STILLRAY_RETURN_IF_ERROR(WritePlainView(options, frame, named.name, colour, written));
    }
  }
  return reference == nullptr ? Status::Ok()
                              : WritePlainView(options, frame, "reference", *reference, written);
}

}  // namespace

bool IsPictureOutput(const std::string& name) {
  return name == "temporal" || name == "aliased" || name.rfind("atrous", 0) == 0;
}

std::string ViewPattern(const std::string& folder, const std::string& view,
                        const std::string& extension) {
  return (std::filesystem::path(folder) / fmt::format("{}.####.{}", view, extension)).string();
}

ExrImage DenoisedExr(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out) {
  ExrImage image;
  Describe(options, frame, &image);
  image.Add("", options.exr_type, out.colour);
  for (const std::string& name : options.guides) {
    AddGuide(name, frame, options.exr_type, &image);
  }
  for (const NamedImage& named : out.images) {
    const char* letters = named.channels.size() == 3 ? "RGB" : "XYZ";
    for (size_t c = 0; c < named.channels.size(); ++c) {
      image.Add(fmt::format("{}.{}", named.name, letters[c]), options.exr_type, named.channels[c]);
    }
  }
  return image;
}

ExrImage NoisyExr(const RenderOptions& options, const Frame& frame) {
  ExrImage image;
  Describe(options, frame, &image);
  image.Add("", options.exr_type, SumOfLight(frame));
  for (const Signal& signal : frame.signals) {
    const std::string name = SignalName(signal.kind);
    image.Add(name + ".", options.exr_type, signal.radiance);
    if (!signal.second_moment.empty()) {
      image.Add(name + ".second_moment.X", kExact, signal.second_moment);
    }
  }
  for (const char* name : kGuideNames) {
    AddGuide(name, frame, options.exr_type, &image);
  }
  AddVirtualGuides("reflection", frame.reflection, options.exr_type, &image);
  AddVirtualGuides("refraction", frame.refraction, options.exr_type, &image);
  if (!frame.samples.empty()) {
    image.Add("samples.X", options.exr_type, frame.samples);
  }
  if (!frame.guides.previous_normal.empty()) {
    image.Add("previous_normal.", options.exr_type, frame.guides.previous_normal, true);
  }
  if (!frame.confidence.empty()) {
    image.Add("confidence.X", options.exr_type, frame.confidence);
  }
  return image;
}

uint32_t PlanesInFiles(const RenderOptions& options) {
  if (options.post.any()) {
    return kAllPlanes;
  }
  if (options.exr && (options.text.save_inputs || !options.guides.empty())) {
    return kAllPlanes;
  }
  return (options.png || options.jpg) && options.text.save_inputs ? kLightPlanes : 0;
}

Status WriteFrameFiles(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out,
                       const Image3* reference, Rgb8Image* display,
                       std::vector<std::string>* written) {
  EncodedPicture picture;
  Status others;
  tbb::parallel_invoke([&] { EncodePicture(options, frame.index, out.colour, &picture); },
                       [&] { others = WriteOtherFiles(options, frame, out, reference, written); });
  STILLRAY_RETURN_IF_ERROR(others);
  // Written last, so that the denoised image indicates a complete frame.
  STILLRAY_RETURN_IF_ERROR(WriteEncoded(options, "denoised", frame.index, picture, written));
  *display = std::move(picture.display);
  return Status::Ok();
}

}  // namespace stillray
