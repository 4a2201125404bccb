// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One row of a table of settings: Parameters() of the denoiser, RenderParameters() of the path
/// tracer. Command line, settings files, viewer, logs and docs are generated from the rows.
#pragma once

#include <cstdint>
#include <vector>

namespace stillray {

enum class ParameterType : uint8_t {
  kFloat,
  kInt,
  kFlag,    ///< on or off
  kChoice,  ///< one of Parameter::choices
  kSteps,   ///< a list of integers, such as 1,2,4
  kSeed,    ///< an unsigned 64-bit integer
  kText,    ///< text with a syntax of its own: Parameter::choices lists its forms
  kRate,    ///< per pixel and frame: an integer, or 1/n for one in n frames
};

struct Parameter {
  const char* name = "";
  ParameterType type = ParameterType::kFloat;
  const char* group = "";   ///< the stage that uses it
  const char* help = "";    ///< one sentence
  const char* unit = "";    ///< "" if it has none
  const char* symbol = "";  ///< in the papers; "" if it has none
  double min = 0;           ///< inclusive; for kSteps, of each step
  double max = 1;           ///< inclusive; ignored for kSeed, which accepts all 64-bit values
  std::vector<const char*> choices =
      {};  ///< names of the values of a kChoice, in order; forms of a kText
  /// The changes on which Denoiser::SetSettings restarts the history, as text; "": none.
  const char* resets_history = "";
};

}  // namespace stillray
