// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The radiance kinds that form each signal, and the albedos in its divisor.
#pragma once

#include <span>
#include <vector>

#include "core/guides.h"
#include "stillray/denoise.hpp"

namespace stillray {

struct SignalGroup {
  const char* name;
  std::vector<SignalKind> kinds;
  bool diffuse_albedo = false;       ///< the divisor is the sum of the selected albedos: albedo,
  bool specular_albedo = false;      ///< specular albedo,
  bool transmission_albedo = false;  ///< and transmission albedo
  /// Channel of the radiance: 0 red, 1 green, 2 blue; the signal is then grey. -1: all three.
  int channel = -1;
};

/// The largest number of signals of GroupsOf.
inline constexpr size_t kMostGroups = 4;

inline std::vector<SignalGroup> MakeGroups(SignalGrouping grouping, bool with_transmission) {
  using enum SignalKind;
  const bool t = with_transmission;
  std::vector<SignalGroup> groups;
  switch (grouping) {
    case SignalGrouping::kDirectIndirect:
      return {{"direct", {kDirectDiffuse, kDirectSpecular, kDirectTransmission}, true, true, t},
              {"indirect",
               {kIndirectDiffuse, kIndirectSpecular, kIndirectTransmission},
               true,
               true,
               t}};
    case SignalGrouping::kSingle:
      return {{"light",
               {kDirectDiffuse, kIndirectDiffuse, kDirectSpecular, kIndirectSpecular,
                kDirectTransmission, kIndirectTransmission},
               true,
               true,
               t}};
    case SignalGrouping::kChannels:
      groups = MakeGroups(SignalGrouping::kSingle, t);
      groups.resize(3, groups.front());
      for (int c = 0; c < 3; ++c) {
        constexpr const char* kNames[3] = {"red", "green", "blue"};
        groups[static_cast<size_t>(c)].name = kNames[c];
        groups[static_cast<size_t>(c)].channel = c;
      }
      return groups;
    case SignalGrouping::kDiffuseSpecular:
      groups = {{"diffuse", {kDirectDiffuse, kIndirectDiffuse}, true, false, false}};
      break;
    case SignalGrouping::kSplit:
      groups = {{"direct", {kDirectDiffuse}, true, false, false},
                {"indirect", {kIndirectDiffuse}, true, false, false}};
      break;
  }
  groups.push_back({"specular", {kDirectSpecular, kIndirectSpecular}, false, true, false});
  if (with_transmission) {
    groups.push_back(
        {"transmission", {kDirectTransmission, kIndirectTransmission}, false, false, true});
  }
  return groups;
}

/// \param with_transmission  whether frames have transmission signals
/// \return a table with static storage
inline std::span<const SignalGroup> GroupsOf(SignalGrouping grouping, bool with_transmission) {
  using enum SignalGrouping;
  static const std::vector<SignalGroup> groups[5][2] = {
      {MakeGroups(kSplit, false), MakeGroups(kSplit, true)},
      {MakeGroups(kDirectIndirect, false), MakeGroups(kDirectIndirect, true)},
      {MakeGroups(kDiffuseSpecular, false), MakeGroups(kDiffuseSpecular, true)},
      {MakeGroups(kSingle, false), MakeGroups(kSingle, true)},
      {MakeGroups(kChannels, false), MakeGroups(kChannels, true)}};
  static_assert(static_cast<int>(kSingle) == 3 && static_cast<int>(kChannels) == 4);
  return groups[static_cast<int>(grouping)][with_transmission ? 1 : 0];
}

/// Whether radiance of this kind is reflected specularly or refracted at the first surface.
inline bool IsSharpAtMirrors(SignalKind kind) {
  return kind == SignalKind::kDirectSpecular || kind == SignalKind::kIndirectSpecular ||
         kind == SignalKind::kDirectTransmission || kind == SignalKind::kIndirectTransmission;
}

inline bool HasTransmission(const Frame& frame) {
  return frame.Find(SignalKind::kDirectTransmission) != nullptr ||
         frame.Find(SignalKind::kIndirectTransmission) != nullptr;
}

}  // namespace stillray
