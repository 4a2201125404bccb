// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One row of a table that declares settings: Parameters() of the denoiser, RenderParameters() of
/// the path tracer. Command line, settings files, viewer, logs and docs are made from the rows.
#pragma once

#include <cstdint>
#include <vector>

namespace stillray {

enum class ParameterType : uint8_t {
  kFloat,
  kInt,
  kFlag,    ///< on or off
  kChoice,  ///< one of Parameter::choices
  kSteps,   ///< a list of whole numbers, such as 1,2,4
  kSeed,    ///< an unsigned whole number of 64 bits
  kText,    ///< a notation of its own: Parameter::choices has its forms
  kRate,    ///< per pixel and frame: a whole number, or 1/n for one in n frames
};

struct Parameter {
  const char* name = "";
  ParameterType type = ParameterType::kFloat;
  const char* group = "";   ///< the stage that reads it
  const char* help = "";    ///< one sentence
  const char* unit = "";    ///< "" if it has none
  const char* symbol = "";  ///< in the papers; "" if it has none
  double min = 0;           ///< inclusive; of each step for kSteps
  double max = 1;           ///< inclusive; without meaning for kSeed, which takes all of 64 bits
  std::vector<const char*> choices =
      {};  ///< names of the values of a kChoice, in order; forms of a kText
  /// When a change makes Denoiser::SetSettings begin the history anew; "": never.
  const char* resets_history = "";
};

}  // namespace stillray
