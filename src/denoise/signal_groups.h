// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Which lights of a frame make up which signal, and by what they are divided.
#pragma once

#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

struct SignalGroup {
  const char* name;
  std::vector<SignalKind> kinds;
  bool diffuse_albedo = false;   ///< divided by albedo
  bool specular_albedo = false;  ///< ... plus specular albedo
};

inline std::vector<SignalGroup> GroupsOf(SignalGrouping grouping) {
  using enum SignalKind;
  switch (grouping) {
    case SignalGrouping::kDirectIndirect:
      return {{"direct", {kDirectDiffuse, kDirectSpecular}, true, true},
              {"indirect", {kIndirectDiffuse, kIndirectSpecular}, true, true}};
    case SignalGrouping::kDiffuseSpecular:
      return {{"diffuse", {kDirectDiffuse, kIndirectDiffuse}, true, false},
              {"specular", {kDirectSpecular, kIndirectSpecular}, false, true}};
    case SignalGrouping::kSingle:
      return {{"light",
               {kDirectDiffuse, kIndirectDiffuse, kDirectSpecular, kIndirectSpecular},
               true,
               true}};
    case SignalGrouping::kSplit:
      break;
  }
  return {{"direct", {kDirectDiffuse}, true, false},
          {"indirect", {kIndirectDiffuse}, true, false},
          {"specular", {kDirectSpecular, kIndirectSpecular}, false, true}};
}

inline bool IsSpecular(SignalKind kind) {
  return kind == SignalKind::kDirectSpecular || kind == SignalKind::kIndirectSpecular;
}

}  // namespace stillray
