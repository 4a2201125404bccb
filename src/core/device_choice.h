// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The error for a choice of a device that does not exist anywhere.
#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

#include "core/nearest_names.h"
#include "stillray/status.h"

namespace stillray {

inline Status UnknownDeviceChoice(const std::string& choice) {
  constexpr std::string_view kChoices[] = {"auto", "cpu", "vulkan"};
  // One letter away from "cpu", but no misspelling of it.
  const bool gpu = choice == "gpu" || choice == "GPU";
  return Status::InvalidArgument(
      fmt::format("device is '{}', expected auto, cpu, vulkan or vulkan:N{}", choice,
                  gpu ? ", did you mean vulkan?" : DidYouMeanOneOf(choice, kChoices)));
}

}  // namespace stillray
