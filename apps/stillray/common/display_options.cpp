// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/display_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace stillray {

void AddDisplayOptions(CLI::App* command, DisplayArguments* arguments) {
  command->add_option("--exposure", arguments->exposure, "Stops, for display pictures");
  command->add_option("--tonemap", arguments->tonemap,
                      "Curve of display pictures: linear, reinhard, filmic, aces");
}

Status SetDisplay(const DisplayArguments& arguments, Settings* settings) {
  if (arguments.exposure) {
    const Status set = SetParameter(settings, "exposure", fmt::format("{}", *arguments.exposure));
    if (!set.ok()) {
      return Status::InvalidArgument("--exposure: " + set.message());
    }
  }
  if (arguments.tonemap) {
    const Status set = SetParameter(settings, "tonemap", *arguments.tonemap);
    if (!set.ok()) {
      return Status::InvalidArgument("--tonemap: " + set.message());
    }
  }
  return Status::Ok();
}

}  // namespace stillray
