// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of `stillray denoise`, checked before any work begins.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/display_options.h"
#include "denoise/denoise_inputs.h"
#include "stillray/aov.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Text as the user gave it.
struct DenoiseArguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string frames;
  AovOptions aovs;
  std::string preset = "default";
  std::string settings_file;
  std::vector<std::string> set;
  std::string window = "auto";
  int threads = 0;
  std::string memory_limit;
  bool passes = false;
  bool resume = false;
  bool timings = false;
  bool no_check = false;
  std::string preview;
  DisplayArguments display;
  double fps = 24;
  bool fps_given = false;
  std::string device = "auto";
  bool verbose = false;
  std::string json_path;
};

/// Which frames a frame gets light of, beside its own.
enum class Window { kPast, kBoth };
inline const char* WindowName(Window window) {
  return window == Window::kBoth ? "both" : "past";
}

/// The same, understood.
struct DenoiseOptions {
  DenoiseArguments text;
  std::vector<SequenceFile> files;
  Settings settings;
  Window window = Window::kPast;
  bool window_is_chosen = false;       ///< by what the files and the machine allow, not by the user
  std::string window_note;             ///< why `window` is what it is, or empty
  std::vector<std::string> set_names;  ///< parameters that --set gave
  int64_t memory_limit = 0;            ///< bytes; the machine's memory by default

  bool IsSet(std::string_view parameter) const;
};

/// \return kInvalidArgument naming the option, what it is and what was expected; kNotFound
Result<DenoiseOptions> ParseDenoiseArguments(const DenoiseArguments& arguments);

/// The window where the user leaves the choice: both sides of a sequence without gaps, the past of
/// one frame, or of a sequence with gaps, whose missing frames may still come.
/// \param note  set to why it is the past, where that is worth a word
Window ChooseWindow(const std::vector<SequenceFile>& files, std::string* note);

/// Everything that decides what the pictures look like, one "name value" a line: runs with the same
/// text make the same bits.
std::string DenoiseFingerprint(const DenoiseOptions& options);

/// Fails if a frame of this size does not fit into the memory limit.
Status CheckMemory(const ExrExtent& extent, const DenoiseOptions& options, const std::string& name);

/// Whether one frame may be read and another written while a third of this size is filtered, and
/// all that within the memory limit. \return kOutOfMemory saying what it takes and what there is
Status OverlapFits(const ExrExtent& extent, const DenoiseOptions& options);

/// Of how many frames of this size the future fits into the memory limit beside everything else;
/// 1..kFutureBlock. \return kOutOfMemory if not even one does
Result<size_t> FuturesThatFit(const ExrExtent& extent, const DenoiseOptions& options,
                              const std::string& name);

}  // namespace stillray
