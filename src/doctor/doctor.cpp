// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Runs the checks in order, and checks whole files: numbers, copies, sizes, layers.
#include "stillray/doctor.h"

#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/colour.h"
#include "core/guides.h"
#include "core/parallel.h"
#include "doctor/check.h"
#include "io/text.h"

namespace stillray {
namespace {

using doctor::Check;
using doctor::Exhibit;
using doctor::Verdict;

constexpr FindingInfo kFindings[] = {
    {"frames_missing", "frame numbers are missing"},
    {"frames_repeated", "a frame has the same bits as an earlier one"},
    {"size_changes", "a frame has another size than the first"},
    {"layers_change", "a frame lacks layers that the first one has"},
    {"not_finite", "NaN or infinite values"},
    {"negative_light", "light below zero"},
    {"confidence_range", "confidence outside 0 to 1"},
    {"lossy_compression", "light or guides are compressed with loss"},
    {"single_layer", "the files hold only the picture, without passes"},
    {"view_layer_left", "another view layer stays noisy"},
    {"motion_missing", "no layer of motion"},
    {"depth_missing", "no layer of depth"},
    {"normal_missing", "no layer of normals"},
    {"albedo_missing", "no layer of albedo"},
    {"motion_zero", "motion is zero, but the picture moves"},
    {"motion_direction", "motion points to the next frame, or from the previous one"},
    {"motion_y_flipped", "y of motion has the wrong sign"},
    {"motion_x_flipped", "x of motion has the wrong sign"},
    {"motion_swapped", "x and y of motion are swapped"},
    {"motion_fraction", "motion is in fractions of the picture, not in pixels"},
    {"motion_ndc", "motion is in coordinates from -1 to 1, not in pixels"},
    {"motion_pixels", "motion is in pixels, not in the assumed unit"},
    {"motion_scaled", "motion is half or twice as long as the movement"},
    {"motion_zoom", "the focal length changes, and motion does not include it"},
    {"motion_wrong", "motion does not lead to the previous positions"},
    {"depth_constant", "depth is the same everywhere"},
    {"depth_negative", "depth is zero or negative"},
    {"depth_normalised", "depth runs from 0 to 1"},
    {"depth_projected", "a rasteriser's depth, 0 near and 1 far"},
    {"depth_reversed", "a rasteriser's depth, 1 near and 0 far, or 1 / depth"},
    {"depth_ray", "depth is the length of the ray"},
    {"depth_not_linear", "depth bends where surfaces are flat"},
    {"background_finite", "depth is finite where there is no surface"},
    {"normal_encoded", "normals are stored in 0 to 1"},
    {"normal_not_encoded", "normals are read as encoded, but are not"},
    {"normal_length", "normals are not of unit length"},
    {"normal_zero", "normals are zero on surfaces"},
    {"normal_camera_space", "normals turn with the camera"},
    {"albedo_above_one", "albedo above 1"},
    {"albedo_black", "albedo is black where there is diffuse light"},
    {"albedo_encoded", "albedo is encoded as sRGB"},
    {"light_encoded", "the colour is encoded as sRGB"},
    {"light_tone_mapped", "light is tone mapped to below 1"},
    {"light_clamped", "light is clamped at a maximum"},
    {"passes_missing", "the colour holds light that no pass has"},
    {"passes_do_not_add_up", "the passes do not add up to the colour"},
    {"exposure_changes", "all light changes by one factor from frame to frame"},
    {"fixed_seed", "the noise is the same in every frame"},
    {"first_hits_random", "first hits are random in parts of the picture"},
    {"albedo_noisy", "albedo is noisy"},
    {"normal_noisy", "normals are noisy"},
    {"depth_noisy", "depth is noisy"},
    {"id_unstable", "ids of surfaces change from frame to frame"},
    {"image_depth_nearer", "what mirrors and glass show is nearer than they are"},
    {"image_motion_wrong", "what mirrors and glass show is not where its motion leads"},
    {"hit_distance_zero", "no pixel has a hit distance above 0"},
    {"seen_zero", "a layer of Denoising Data is zero everywhere"},
    {"seen_depth_differs", "Denoising Depth contradicts the depth of plain surfaces"},
    {"seen_normal_differs", "Denoising Normal contradicts the normals of plain surfaces"},
    {"seen_albedo_differs", "Denoising Albedo contradicts the albedo of plain surfaces"},
};

uint64_t HashOf(const void* data, size_t size, uint64_t hash) {
  // FNV-1a over words; accidental collisions of 64 bits are negligible.
  const auto* bytes = static_cast<const uint8_t*>(data);
  for (size_t i = 0; i + 4 <= size; i += 4) {
    uint32_t word = 0;
    std::memcpy(&word, bytes + i, 4);
    hash = (hash ^ word) * 0x100000001b3ull;
    hash ^= hash >> 29;
  }
  return hash;
}

/// Hash of the bits of all channels except motion: a copied frame may have new motion, and only
/// equal radiance proves a copy.
uint64_t HashOf(const ExrImage& image, const AovLayout& layout) {
  uint64_t hash = 0xcbf29ce484222325ull;
  for (const AovSource& source : layout.sources) {
    if (source.aov == Aov::kMotion || source.aov == Aov::kResult) {
      continue;
    }
    for (const std::string& name : source.channels) {
      const Channel* channel = image.Find(name);
      for (int y = 0; channel != nullptr && y < image.height; ++y) {
        const auto bytes = static_cast<size_t>(image.width) * 4;
        hash = channel->type == PixelType::kUint32 ? HashOf(channel->integers.Row(y), bytes, hash)
                                                   : HashOf(channel->values.Row(y), bytes, hash);
      }
    }
  }
  return hash;
}

Image1 LightOf(const Frame& frame) {
  Image1 light(frame.width, frame.height);
  ParallelRows(frame.height, kRowsPerTask, [&](int y0, int y1) {
    for (const Signal& signal : frame.signals) {
      const Image3& albedo = AlbedoOf(frame.guides, signal.kind);
      for (int y = y0; y < y1; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          float rgb[3];
          for (int c = 0; c < 3; ++c) {
            const float a = albedo.empty() ? 1.0f : albedo[c](x, y);
            rgb[c] = Demodulate(signal.radiance[c](x, y), std::isfinite(a) ? a : 1.0f);
          }
          const float value = Luminance709(rgb[0], rgb[1], rgb[2]);
          light(x, y) += std::isfinite(value) && value > 0 ? value : 0.0f;
        }
      }
    }
  });
  return light;
}

class DoctorImpl : public Doctor {
 public:
  explicit DoctorImpl(const AovOptions& options);

  Status Add(int64_t number, const std::string& name, const ExrImage& image) override;
  Result<DoctorReport> Report() override;
  const AovLayout* layout() const override { return layout_ ? &*layout_ : nullptr; }

 private:
  Status Understand(const std::string& name, const ExrImage& image);
  bool FitsFirst(int64_t number, const ExrImage& image);
  void LookAt(int64_t number, const std::string& name, const ExrImage& image, Frame frame,
              bool repeated);
  void ConcludeFiles(Verdict* verdict) const;
  void ConcludeRepeated(Verdict* verdict) const;

  AovOptions options_;
  std::optional<AovLayout> layout_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::unique_ptr<Check>> checks_;
  std::optional<Exhibit> before_;
  bool before_is_copy_ = false;
  std::vector<int64_t> numbers_;
  std::map<uint64_t, int64_t> first_with_;  ///< hash to number
  std::vector<int64_t> repeated_;
  int64_t original_ = 0;  ///< of the first repeated frame
  std::vector<int64_t> other_size_;
  std::string size_text_;
  std::vector<int64_t> other_layers_;
  std::string missing_channel_;
};

DoctorImpl::DoctorImpl(const AovOptions& options) : options_(options) {
  using namespace doctor;  // NOLINT: its factories
  // In the order of the report; later checks depend on earlier findings.
  checks_.push_back(MakeDamageCheck());
  checks_.push_back(MakeLossyCheck());
  checks_.push_back(MakeMissingLayersCheck());
  checks_.push_back(MakeMotionCheck());
  checks_.push_back(MakeStillMotionCheck());
  checks_.push_back(MakeDepthPlanesCheck());
  checks_.push_back(MakeDepthValuesCheck());
  checks_.push_back(MakeNormalCheck());
  checks_.push_back(MakeCameraSpaceCheck());
  checks_.push_back(MakeFirstHitCheck());
  checks_.push_back(MakeAlbedoCheck());
  checks_.push_back(MakeSumCheck());
  checks_.push_back(MakeRangeCheck());
  checks_.push_back(MakeExposureCheck());
  checks_.push_back(MakeSeedCheck());
  checks_.push_back(MakeGuideNoiseCheck());
  checks_.push_back(MakeIdCheck());
  checks_.push_back(MakeVirtualGuidesCheck());
  checks_.push_back(MakeSeenGuidesCheck());
}

Status DoctorImpl::Understand(const std::string& name, const ExrImage& image) {
  Result<AovLayout> layout = UnderstandAovs(image, options_, name);
  if (!layout.ok()) {
    return layout.status();
  }
  layout_ = std::move(layout.value());
  width_ = image.width;
  height_ = image.height;
  return Status::Ok();
}

/// Frames that differ in size are counted and otherwise ignored.
bool DoctorImpl::FitsFirst(int64_t number, const ExrImage& image) {
  if (image.width != width_ || image.height != height_) {
    if (other_size_.empty()) {
      size_text_ = fmt::format("{} x {}", image.width, image.height);
    }
    other_size_.push_back(number);
    return false;
  }
  for (const AovSource& source : layout_->sources) {
    for (const std::string& channel : source.channels) {
      if (image.Find(channel) == nullptr) {
        if (other_layers_.empty()) {
          missing_channel_ = channel;
        }
        other_layers_.push_back(number);
        return false;
      }
    }
  }
  return true;
}

Status DoctorImpl::Add(int64_t number, const std::string& name, const ExrImage& image) {
  if (!numbers_.empty() && number <= numbers_.back()) {
    return Status::InvalidArgument(
        fmt::format("{}: is frame {}, expected one after {}", name, number, numbers_.back()));
  }
  if (!layout_) {
    STILLRAY_RETURN_IF_ERROR(Understand(name, image));
  }
  if (!FitsFirst(number, image)) {
    numbers_.push_back(number);
    before_.reset();
    return Status::Ok();
  }
  const std::array<float, 2> jitter =
      before_ ? std::array<float, 2>{before_->frame.jitter_x, before_->frame.jitter_y}
              : std::array<float, 2>{0, 0};
  Result<Frame> frame = ImportFrame(image, *layout_, jitter, name);
  if (!frame.ok()) {
    return frame.status();
  }
  numbers_.push_back(number);
  const auto [first, is_new] = first_with_.emplace(HashOf(image, *layout_), number);
  if (!is_new) {
    original_ = repeated_.empty() ? first->second : original_;
    repeated_.push_back(number);
  }
  LookAt(number, name, image, std::move(*frame), !is_new);
  return Status::Ok();
}

void DoctorImpl::LookAt(int64_t number, const std::string& name, const ExrImage& image, Frame frame,
                        bool repeated) {
  Exhibit now;
  now.number = number;
  now.name = name;
  now.image = &image;
  now.layout = &*layout_;
  now.light = LightOf(frame);
  now.frame = std::move(frame);
  // A copied frame replaces a missing frame, and the motion of adjacent frames points to the
  // missing frame.
  const bool paired = before_ && before_->number + 1 == number && !repeated && !before_is_copy_;
  for (const std::unique_ptr<Check>& check : checks_) {
    check->Look(now, paired ? &*before_ : nullptr);
  }
  before_ = std::move(now);
  before_->image = nullptr;
  before_is_copy_ = repeated;
}

/// Isolated copies replace missing frames; in a static scene without noise, equal frames are no
/// copies.
void DoctorImpl::ConcludeRepeated(Verdict* verdict) const {
  if (repeated_.empty()) {
    return;
  }
  const auto count = static_cast<double>(repeated_.size());
  constexpr double kNearlyAll = 0.8;
  if (repeated_.size() >= 2 && count >= kNearlyAll * static_cast<double>(numbers_.size() - 1)) {
    verdict->Add(Finding{
        "fixed_seed", repeated_,
        fmt::format(
            "the noise is the same in every frame: {} have the same bits as an earlier frame; "
            "accumulating them gains nothing",
            FrameRanges(repeated_)),
        layout_->renderer == "blender"
            ? "press the clock beside Render Properties > Sampling > Advanced > Seed, and render "
              "again"
            : "give every frame another seed, and render again",
        count, 0, ""});
    return;
  }
  verdict->Add(Finding{
      "frames_repeated", repeated_,
      fmt::format("{} {} the same bits as an earlier frame (frame {} those of frame {}); expected "
                  "new noise in every frame",
                  FrameRanges(repeated_), repeated_.size() == 1 ? "has" : "have", repeated_.front(),
                  original_),
      "render these frames again; a still picture needs a new seed in every frame too", count, 0,
      ""});
}

void DoctorImpl::ConcludeFiles(Verdict* verdict) const {
  std::vector<int64_t> missing;
  for (size_t i = 1; i < numbers_.size(); ++i) {
    constexpr size_t kMost = 10000;  // numbers that are steps of a thousand
    for (int64_t n = numbers_[i - 1] + 1; n < numbers_[i] && missing.size() < kMost; ++n) {
      missing.push_back(n);
    }
  }
  if (!missing.empty()) {
    verdict->Add(Finding{
        "frames_missing", missing,
        fmt::format("{} {} not there, between {} and {}; history would restart behind every gap",
                    FrameRanges(missing), missing.size() == 1 ? "is" : "are", numbers_.front(),
                    numbers_.back()),
        "render the missing frames, or name a range without gaps with --frames",
        static_cast<double>(missing.size()), 0, ""});
  }
  ConcludeRepeated(verdict);
  if (!other_size_.empty()) {
    verdict->Add(
        Finding{"size_changes", other_size_,
                fmt::format("{} {} {} pixels, expected {} x {} as in frame {}",
                            FrameRanges(other_size_), other_size_.size() == 1 ? "has" : "have",
                            size_text_, width_, height_, numbers_.front()),
                "render all frames at one resolution, or denoise the parts with --frames",
                static_cast<double>(other_size_.size()), 0, ""});
  }
  if (!other_layers_.empty()) {
    verdict->Add(
        Finding{"layers_change", other_layers_,
                fmt::format("{} {} channel {}, which frame {} has", FrameRanges(other_layers_),
                            other_layers_.size() == 1 ? "lacks" : "lack",
                            io::OneLine(missing_channel_), numbers_.front()),
                "render all frames with the same passes", static_cast<double>(other_layers_.size()),
                0, ""});
  }
}

Result<DoctorReport> DoctorImpl::Report() {
  if (numbers_.empty()) {
    return Status::InvalidArgument("no frame was looked at, expected at least one");
  }
  DoctorReport report;
  Verdict verdict(&report);
  ConcludeFiles(&verdict);
  for (const std::unique_ptr<Check>& check : checks_) {
    check->Conclude(&verdict);
  }
  report.frames = numbers_;
  report.layout = *layout_;
  return report;
}

}  // namespace

std::span<const FindingInfo> FindingTable() {
  return kFindings;
}

std::string FrameRanges(const std::vector<int64_t>& frames) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < frames.size();) {
    size_t end = i + 1;
    while (end < frames.size() && frames[end] == frames[end - 1] + 1) {
      ++end;
    }
    ranges.push_back(end - i == 1 ? fmt::format("{}", frames[i])
                                  : fmt::format("{}-{}", frames[i], frames[end - 1]));
    i = end;
  }
  constexpr size_t kMost = 8;
  const size_t more = ranges.size() > kMost ? ranges.size() - kMost : 0;
  ranges.resize(ranges.size() - more);
  return fmt::format("{} {}{}", frames.size() == 1 ? "frame" : "frames", fmt::join(ranges, ", "),
                     more > 0 ? fmt::format(" and {} more ranges", more) : "");
}

std::unique_ptr<Doctor> Doctor::Create(const AovOptions& options) {
  return std::make_unique<DoctorImpl>(options);
}

}  // namespace stillray
