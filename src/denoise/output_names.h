// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Short names of outputs: "variance" for "variance.direct_diffuse", "variance.specular", ...
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace stillray {

/// Appends the output with this name, or, for a short name, the outputs of all signals.
/// \param known  Denoiser::OutputNames
/// \return false if there is none; `outputs` is then unchanged
inline bool AddOutputs(const std::vector<std::string>& known, std::string_view name,
                       std::vector<std::string>* outputs) {
  const size_t before = outputs->size();
  for (const std::string& candidate : known) {
    if (candidate == name || candidate.substr(0, candidate.find('.')) == name) {
      outputs->push_back(candidate);
    }
  }
  return outputs->size() > before;
}

}  // namespace stillray
