// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of `stillray denoise`, checked before any work begins.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/display_options.h"
#include "common/filter_options.h"
#include "common/post_options.h"
#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/sequence.h"

namespace stillray {

/// Unparsed option values.
struct DenoiseArguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string frames;
  AovOptions aovs;
  FilterArguments filter;
  std::string window = "auto";
  std::string motion = "auto";
  std::string cameras;
  int threads = 0;
  std::string memory_limit;
  int spp = 0;
  bool passes = false;
  std::string alpha = "keep";
  bool resume = false;
  bool timings = false;
  bool no_check = false;
  std::string preview;
  DisplayArguments display;
  PostArguments post;
  std::string aperture;
  std::string focus;
  std::optional<double> fov;
  double fps = 24;
  bool fps_given = false;
  std::string device = "auto";
  bool verbose = false;
  std::string json_path;
};

/// Parsed and validated options.
struct DenoiseOptions {
  DenoiseArguments text;
  std::string preset;  ///< base preset of the settings
  SequenceOptions sequence;
  PostEffects post;
  Lens lens;                ///< lens of the depth of field effect
  std::string window_note;  ///< reason for the size of the window, or empty
};

/// \return kInvalidArgument naming the option, its value and the expected ones; kNotFound
Result<DenoiseOptions> ParseDenoiseArguments(const DenoiseArguments& arguments);

}  // namespace stillray
