// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The state on disk from which a SequenceDenoiser resumes.
#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sequence/sequence_denoiser.h"

namespace stillray {
namespace {

std::string FileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// Number of planes: alpha has one, radiance three.
int ComponentsOf(const NewLayer& layer) {
  return layer.aov == Aov::kAlpha ? 1 : 3;
}

/// Stores the layers of a frame as images named by their roles.
UnwrittenFrame ToUnwritten(const SequencePicture& picture) {
  UnwrittenFrame kept;
  kept.frame = picture.report.frame;
  kept.colour = picture.colour;
  for (const NewLayer& layer : picture.layers) {
    NamedImage& image = kept.images.emplace_back();
    image.name = AovName(layer.aov);
    for (int c = 0; c < ComponentsOf(layer); ++c) {
      image.channels.push_back(layer.values[c]);
    }
  }
  return kept;
}

std::vector<NewLayer> LayersOf(std::vector<NamedImage> images) {
  std::vector<NewLayer> layers;
  for (NamedImage& image : images) {
    for (int i = 0; i < kAovCount; ++i) {
      const auto aov = static_cast<Aov>(i);
      if (image.name == AovName(aov) && !image.channels.empty() && image.channels.size() <= 3) {
        NewLayer& layer = layers.emplace_back();
        layer.aov = aov;
        for (size_t c = 0; c < image.channels.size(); ++c) {
          layer.values[static_cast<int>(c)] = std::move(image.channels[c]);
        }
      }
    }
  }
  return layers;
}

}  // namespace

using Impl = SequenceDenoiser::Impl;

/// One "name value" a line; two runs with equal text produce equal bits.
std::string Impl::Fingerprint(const Device& device) const {
  std::string text = options.state.fingerprint;
  text += fmt::format(
      "first {}\nrenderer {}\naov {}\nview layer {}\nwindow {}\npasses {}\nalpha {}\n",
      options.files.front().input, options.aovs.renderer, fmt::join(options.aovs.mappings, " "),
      options.aovs.view_layer, WindowName(options.window), options.passes,
      options.denoise_alpha ? "denoise" : "keep");
  if (options.window == Window::kBoth) {
    text += fmt::format("last frame (--frames) {}\n", options.files.back().input);
  }
  text += fmt::format("spp {}\n", options.spp);
  text += fmt::format("motion {}\n", MotionSourceName(options.motion));
  if (motion.cameras) {
    text += fmt::format("cameras {} {:016x}\n", options.cameras, motion.cameras->checksum);
  }
  for (const Parameter& p : Parameters()) {
    text += fmt::format("{} {}\n", p.name, GetParameter(options.settings, p.name).value());
  }
  std::vector<std::string> set = options.fixed_parameters;
  std::sort(set.begin(), set.end());
  set.erase(std::unique(set.begin(), set.end()), set.end());
  return text + fmt::format("set {}\non {}\n", fmt::join(set, " "), device.description());
}

/// A resumed run keeps its window, even if the files would now allow another.
void Impl::TakeWindowOfResumedRun() {
  if (!options.state.resume || !options.window_may_narrow) {
    return;
  }
  const Result<ResumeState> state = LoadResumeState(folder, key);
  if (!state.ok()) {
    return;
  }
  for (const Window window : {Window::kPast, Window::kBoth}) {
    if (state->fingerprint.find(fmt::format("\nwindow {}\n", WindowName(window))) !=
        std::string::npos) {
      options.window = window;
    }
  }
}

/// Inputs of finished frames must be unchanged, since later frames continue their history.
Status Impl::CheckFormerInputs(const ResumeState& saved) const {
  for (size_t i = 0; i < saved.inputs.size() && i < options.files.size(); ++i) {
    const std::string& path = options.files[i].input;
    if (FileName(path) != FileName(saved.inputs[i].name)) {
      return Status::InvalidArgument(
          fmt::format("cannot resume {}: {} stands where {} was read there before; remove the "
                      "former to start again",
                      StatePath(), path, FileName(saved.inputs[i].name)));
    }
    const Result<FinishedFile> input = LookAtFile("", path);
    STILLRAY_RETURN_IF_ERROR(input.status());
    if (input->bytes != saved.inputs[i].bytes || input->checksum != saved.inputs[i].checksum) {
      return Status::InvalidArgument(
          fmt::format("cannot resume {}: {} has changed since; remove the former to start again",
                      StatePath(), path));
    }
  }
  return Status::Ok();
}

Status Impl::Resume() {
  Result<ResumeState> saved = LoadResumeState(folder, key);
  const bool ours = saved.ok() && saved->fingerprint == fingerprint;
  if (!options.state.resume) {
    has_old_state = ours;
    return Status::Ok();
  }
  const int64_t first = options.files.front().frame;
  if (saved.status().code() == StatusCode::kNotFound) {
    Note(fmt::format("nothing to resume in {}, starting with frame {}",
                     folder.empty() ? "." : folder, first));
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(saved.status());
  if (!ours) {
    return Status::InvalidArgument(
        fmt::format("cannot resume {}: {}", StatePath(),
                    FingerprintDifference(saved->fingerprint, fingerprint)));
  }
  STILLRAY_RETURN_IF_ERROR(CheckFormerInputs(*saved));
  const std::string changed = FirstChanged(folder, saved->files);
  if (!changed.empty()) {
    Note(fmt::format("starting again with frame {}: {}", first, changed));
    return Status::Ok();
  }
  return Restore(std::move(saved.value()));
}

Status Impl::Restore(ResumeState saved) {
  while (finished < options.files.size() && options.files[finished].frame <= saved.last_frame) {
    ++finished;
  }
  STILLRAY_RETURN_IF_ERROR(
      filter->RestoreHistory(saved.history, finished + saved.unwritten.size(), StatePath()));
  for (UnwrittenFrame& frame : saved.unwritten) {
    waiting.push_back({std::move(frame), FrameReport()});
  }
  if (hooks.restore_log) {
    Result<std::vector<FrameReport>> all = hooks.restore_log(saved.log);
    STILLRAY_RETURN_IF_ERROR(all.status());
    for (FrameReport& report : *all) {
      const auto own = std::find_if(waiting.begin(), waiting.end(), [&](const WaitingFrame& w) {
        return w.frame.frame == report.frame;
      });
      (own == waiting.end() ? reports.emplace_back() : own->report) = std::move(report);
    }
  }
  inputs = std::move(saved.inputs);
  outputs = std::move(saved.files);
  synced = outputs.size();
  resumed = true;
  saved_at = made = finished;
  if (finished == 0 || finished == options.files.size()) {
    return Status::Ok();
  }
  Result<SequenceFrame> before = LoadFrame(options.files[finished - 1], View(), false);
  STILLRAY_RETURN_IF_ERROR(before.status());
  filter->Skip(std::move(before.value()));
  return Status::Ok();
}

/// The history already includes the frame's radiance.
void Impl::TakeFirstWaiting(Picture* picture) {
  WaitingFrame& first = waiting.front();
  picture->report = std::move(first.report);
  picture->colour = std::move(first.frame.colour);
  picture->layers = LayersOf(std::move(first.frame.images));
  waiting.erase(waiting.begin());
}

bool Impl::CanSave() const {
  return options.state.keep && filter->frames() > 0 && filter->frames() == made + waiting.size();
}

/// Of finished frames, followed by those in the history whose files are missing.
std::vector<FrameReport> Impl::AllReports(std::span<Picture* const> unwritten) const {
  std::vector<FrameReport> all = reports;
  for (const Picture* picture : unwritten) {
    all.push_back(picture->report);
  }
  for (const WaitingFrame& frame : waiting) {
    all.push_back(frame.report);
  }
  return all;
}

Status Impl::Save(std::span<Picture* const> unwritten) {
  ResumeState state;
  state.key = key;
  state.fingerprint = fingerprint;
  state.inputs = inputs;
  state.files = outputs;
  if (hooks.save_log) {
    state.log = hooks.save_log(AllReports(unwritten));
  }
  state.last_frame =
      finished > 0 ? options.files[finished - 1].frame : options.files.front().frame - 1;
  for (const Picture* picture : unwritten) {
    state.unwritten.push_back(ToUnwritten(*picture));
  }
  for (const WaitingFrame& frame : waiting) {
    state.unwritten.push_back(frame.frame);
  }
  Result<std::vector<uint8_t>> history = filter->SaveHistory();
  STILLRAY_RETURN_IF_ERROR(history.status());
  state.history = std::move(history.value());
  STILLRAY_RETURN_IF_ERROR(SaveResumeState(folder, state, &synced));
  saved_at = finished;
  return Status::Ok();
}

void Impl::RemoveState() {
  if (saved_at) {
    RemoveResumeState(folder, key);
  }
}

}  // namespace stillray
