// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray compare: error metrics of images against references, defined in docs/metrics.md.
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/commands.h"
#include "common/json_output.h"
#include "common/output_folder.h"
#include "compare/compare_frames.h"
#include "compare/object_table.h"
#include "quality/heat_map.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray {

namespace {

struct CompareOptions {
  std::string test;
  std::string reference;
  std::string json_path;
  std::string heatmap_folder;
  std::string frames;
  ObjectSource objects;
};

/// A metric of one image.
struct Measure {
  const char* name;  ///< name in JSON
  double ImageMetrics::*value;
  bool radiance_only = false;
};
constexpr Measure kMeasures[] = {
    {"psnr", &ImageMetrics::psnr},
    {"ssim", &ImageMetrics::ssim},
    {"rel_mse", &ImageMetrics::rel_mse},
    {"flip", &ImageMetrics::flip},
    {"hdr_flip", &ImageMetrics::hdr_flip, true},
    {"brightness", &ImageMetrics::brightness},
    {"brightness_lowest", &ImageMetrics::brightness_lowest},
    {"brightness_highest", &ImageMetrics::brightness_highest},
    {"bright_specks", &ImageMetrics::bright_specks},
    {"dark_specks", &ImageMetrics::dark_specks},
    {"worst_share", &ImageMetrics::worst_share},
};

/// The metrics of one frame, or their means over frames.
struct Numbers {
  ImageMetrics metrics;
  std::optional<double> temporal_error;
  std::optional<LightChange> light_change;

  std::optional<double> LightChangeShare() const {
    return light_change ? std::optional<double>(light_change->Share()) : std::nullopt;
  }
};

/// Averages metrics over frames. A metric that is infinite in one frame has an infinite mean; NaN
/// values, as in frames without visible history, are excluded from the mean.
class Means {
 public:
  void Add(const Numbers& frame) {
    ++frames_;
    for (const Measure& measure : kMeasures) {
      sum_.*measure.value += frame.metrics.*measure.value;
    }
    sum_.non_finite += frame.metrics.non_finite;
    if (frame.temporal_error && !std::isnan(*frame.temporal_error)) {
      ++temporal_frames_;
      temporal_sum_ += *frame.temporal_error;
    }
    if (frame.light_change && !std::isnan(frame.light_change->Share())) {
      ++light_frames_;
      light_sum_.product += frame.light_change->product;
      light_sum_.square += frame.light_change->square;
    }
  }

  /// non_finite is a sum, all other values are means.
  Numbers Get() const {
    Numbers mean;
    mean.metrics = sum_;
    for (const Measure& measure : kMeasures) {
      mean.metrics.*measure.value /= frames_;
    }
    if (temporal_frames_ > 0) {
      mean.temporal_error = temporal_sum_ / temporal_frames_;
    }
    if (light_frames_ > 0) {
      mean.light_change = {light_sum_.product / light_frames_, light_sum_.square / light_frames_};
    }
    return mean;
  }

 private:
  int frames_ = 0;
  ImageMetrics sum_;
  int temporal_frames_ = 0;
  double temporal_sum_ = 0;
  int light_frames_ = 0;
  LightChange light_sum_;
};

Status Print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return Status::Io(fmt::format("standard output: could not be written: {}",
                                  std::generic_category().message(errno)));
  }
  return Status::Ok();
}

std::string TableHead() {
  return fmt::format("{:>7} {:>9} {:>8} {:>10} {:>8} {:>9} {:>11} {:>10} {:>11}\n", "frame",
                     "PSNR, dB", "SSIM", "relMSE", "FLIP", "HDR-FLIP", "brightness", "temporal",
                     "non-finite");
}

std::string OptionalText(const std::optional<double>& value) {
  return value && !std::isnan(*value) ? fmt::format("{:.5f}", *value) : std::string("-");
}

std::string TableRow(const std::string& name, const Numbers& numbers, bool display) {
  const ImageMetrics& m = numbers.metrics;
  return fmt::format("{:>7} {:>9.3f} {:>8.5f} {:>10.4g} {:>8.5f} {:>9} {:>11.5f} {:>10} {:>11}\n",
                     name, m.psnr, m.ssim, m.rel_mse, m.flip,
                     display ? "-" : fmt::format("{:.5f}", m.hdr_flip), m.brightness,
                     OptionalText(numbers.temporal_error), m.non_finite);
}

/// Header of the second table, with error distribution and temporal response. A single table would
/// be too wide.
std::string DetailsHead() {
  return fmt::format("\n{:>7} {:>13} {:>11} {:>10} {:>14} {:>16} {:>12}\n", "frame",
                     "bright specks", "dark specks", "worst 1 %", "darkest region",
                     "brightest region", "light change");
}

std::string DetailsRow(const std::string& name, const Numbers& numbers) {
  const ImageMetrics& m = numbers.metrics;
  return fmt::format("{:>7} {:>13.3f} {:>11.3f} {:>10.5f} {:>14.5f} {:>16.5f} {:>12}\n", name,
                     m.bright_specks, m.dark_specks, m.worst_share, m.brightness_lowest,
                     m.brightness_highest, OptionalText(numbers.LightChangeShare()));
}

void AddNumbers(const Numbers& numbers, bool display, nlohmann::ordered_json* json) {
  for (const Measure& measure : kMeasures) {
    if (!display || !measure.radiance_only) {
      (*json)[measure.name] = JsonNumber(numbers.metrics.*measure.value);
    }
  }
  if (numbers.temporal_error) {
    (*json)["temporal_error"] = JsonNumber(*numbers.temporal_error);
  }
  if (numbers.light_change) {
    (*json)["light_change"] = JsonNumber(numbers.light_change->Share());
  }
  (*json)["non_finite"] = numbers.metrics.non_finite;
}

nlohmann::ordered_json FrameJson(const ComparedFrame& frame) {
  nlohmann::ordered_json json;
  if (frame.files.number) {
    json["frame"] = *frame.files.number;
  }
  json["test"] = frame.files.test;
  json["reference"] = frame.files.reference;
  json["width"] = frame.test.width();
  json["height"] = frame.test.height();
  json["display"] = frame.display;
  AddNumbers({frame.metrics, frame.temporal_error, frame.light_change}, frame.display, &json);
  return json;
}

/// Writes NAME.png, or NAME.NUMBER.png for frames of a sequence.
Status WriteHeatMap(const ComparedFrame& frame, const std::string& folder, const char* name,
                    ErrorMap which, const report::HeatScale& scale) {
  const Result<Image1> errors = MakeErrorMap(frame.test, frame.reference, frame.display, which);
  if (!errors.ok()) {
    return errors.status();
  }
  const Result<std::string> png = report::EncodeHeatMap(*errors, scale);
  if (!png.ok()) {
    return png.status();
  }
  const std::string file =
      frame.files.number ? FrameFileName(fmt::format("{}.####.png", name), *frame.files.number)
                         : fmt::format("{}.png", name);
  return WriteFileAtomically((std::filesystem::path(folder) / file).string(), png->data(),
                             png->size());
}

Status WriteHeatMaps(const ComparedFrame& frame, const std::string& folder) {
  STILLRAY_RETURN_IF_ERROR(
      WriteHeatMap(frame, folder, "flip", ErrorMap::kFlip, report::kFlipScale));
  return WriteHeatMap(frame, folder, "rel_mse", ErrorMap::kRelativeSquaredError,
                      report::kRelativeSquaredErrorScale);
}

/// Compares all pairs, and prints each row of the first table as soon as it is computed.
class Comparison {
 public:
  explicit Comparison(const CompareOptions& options)
      : options_(options), comparer_(options.objects) {}

  Status Run() {
    std::optional<FrameRange> range;
    if (!options_.frames.empty()) {
      const Result<FrameRange> parsed = ParseFrameRange(options_.frames);
      if (!parsed.ok()) {
        return parsed.status();
      }
      range = *parsed;
    }
    const Result<std::vector<FramePair>> pairs =
        FindFramePairs(options_.test, options_.reference, range);
    if (!pairs.ok()) {
      return pairs.status();
    }
    if (!options_.heatmap_folder.empty()) {
      STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(options_.heatmap_folder));
    }
    STILLRAY_RETURN_IF_ERROR(CheckJsonOutput(options_.json_path));
    for (const FramePair& pair : *pairs) {
      STILLRAY_RETURN_IF_ERROR(CompareOne(pair));
    }
    return Finish(pairs->size());
  }

 private:
  bool prints_table() const { return options_.json_path != "-"; }

  Status CompareOne(const FramePair& pair) {
    const Result<const ComparedFrame*> compared = comparer_.Compare(pair);
    if (!compared.ok()) {
      return compared.status();
    }
    const ComparedFrame& frame = **compared;
    if (!options_.heatmap_folder.empty()) {
      STILLRAY_RETURN_IF_ERROR(WriteHeatMaps(frame, options_.heatmap_folder));
    }
    const Numbers numbers = {frame.metrics, frame.temporal_error, frame.light_change};
    means_.Add(numbers);
    objects_.Add(frame.objects);
    display_ = frame.display;
    const bool first = frames_json_.empty();
    frames_json_.push_back(FrameJson(frame));
    if (!prints_table()) {
      return Status::Ok();
    }
    const std::string name = pair.number ? fmt::format("{}", *pair.number) : "-";
    details_ += DetailsRow(name, numbers);
    return Print((first ? TableHead() : "") + TableRow(name, numbers, frame.display));
  }

  Status Finish(size_t frame_count) const {
    const std::vector<std::string> notes = comparer_.Notes();
    if (prints_table()) {
      const Numbers mean = means_.Get();
      std::string text = frame_count > 1 ? TableRow("mean", mean, display_) : "";
      text += DetailsHead() + details_ + (frame_count > 1 ? DetailsRow("mean", mean) : "");
      text += objects_.empty() ? "" : objects_.Text();
      for (const std::string& note : notes) {
        text += "note: " + note + "\n";
      }
      STILLRAY_RETURN_IF_ERROR(Print(text));
    }
    if (options_.json_path.empty()) {
      return Status::Ok();
    }
    nlohmann::ordered_json json;
    json["test"] = options_.test;
    json["reference"] = options_.reference;
    json["frames"] = frames_json_;
    AddNumbers(means_.Get(), display_, &json["mean"]);
    if (!objects_.empty()) {
      json["objects"] = objects_.Json();
    }
    json["notes"] = notes;
    const std::string text = JsonText(json, 2);
    return prints_table() ? WriteFileAtomically(options_.json_path, text.data(), text.size())
                          : Print(text);
  }

  const CompareOptions& options_;
  FrameComparer comparer_;
  Means means_;
  ObjectTable objects_;
  bool display_ = false;
  std::string details_;  ///< rows of the second table
  nlohmann::ordered_json frames_json_ = nlohmann::ordered_json::array();
};

}  // namespace

void AddCompareCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "compare", "Measure the differences of pictures or sequences from their references");
  auto options = std::make_shared<CompareOptions>();
  command
      ->add_option("TEST", options->test,
                   "Picture (EXR, HDR, PNG, JPEG), or frames of a sequence: 'NAME.####.exr', "
                   "'NAME.*.exr', or a folder")
      ->required();
  command->add_option("REFERENCE", options->reference, "The reference, likewise")->required();
  command->add_option("--json", options->json_path,
                      "Write all numbers as JSON to this file too; - for JSON alone on standard "
                      "output");
  command->add_option("--heatmap", options->heatmap_folder,
                      "Write error maps (flip.png, rel_mse.png) into this folder");
  command->add_option("--frames", options->frames, "Only these frames of a sequence: A-B or A");
  CLI::Option* objects = command->add_option(
      "--objects", options->objects.layer,
      "Errors of each object too, over all frames: by the numbers in this layer of the reference, "
      "else of TEST; auto: id.X or IndexOB.X");
  command
      ->add_option("--objects-of", options->objects.files,
                   "Take that layer from this picture, or this sequence, instead: the noisy frames "
                   "(NAME.####.exr)")
      ->needs(objects);
  command->footer(
      "Measures: PSNR, SSIM, relMSE, FLIP, HDR-FLIP, ratio of brightness, also of the darkest and\n"
      "the brightest region; specks per 10000 pixels; share of the error in the worst 1 % of the\n"
      "pixels. For sequences also, along motion.X, motion.Y of TEST, the temporal error and the\n"
      "share of the reference's change of light that TEST makes. Frames that only one sequence\n"
      "has are left out.\n"
      "Examples:\n"
      "  stillray compare denoised.0008.exr reference.0008.exr\n"
      "  stillray compare 'out/denoised.####.exr' 'out/reference.####.exr' --json "
      "out/quality.json\n"
      "  stillray compare a.png b.png --heatmap maps\n"
      "  stillray compare out/0008.exr reference.0008.exr --objects auto\n"
      "  stillray compare out.####.exr ref.####.exr --objects auto --objects-of noisy.####.exr");
  command->callback([options, exit_code] {
    const Status status = Comparison(*options).Run();
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
