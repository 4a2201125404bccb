// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/sequence_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

namespace stillray {

void AddSequenceOptions(CLI::App* command, std::vector<std::string>* inputs, std::string* frames,
                        AovOptions* aovs) {
  command
      ->add_option(
          "input", *inputs,
          "A pattern in quotes ('in.####.exr', 'in.%04d.exr', 'in.*.exr'), a folder with one "
          "sequence, or files")
      ->required()
      ->take_all();
  command->add_option("--frames", *frames, "FIRST-LAST, or one frame; default: all");
  command
      ->add_option(
          "--renderer", aovs->renderer,
          fmt::format("Renderer whose layer names to use: {}", fmt::join(RendererNames(), ", ")))
      ->capture_default_str();
  command->add_option("--view-layer", aovs->view_layer,
                      "View layer (the prefix of the passes, ViewLayer in ViewLayer.DiffCol); "
                      "default: the one with most passes");
  command
      ->add_option("--aov", aovs->mappings,
                   "A layer by name, as normal=LAYER[,WORD...]; NAME=none for none; repeatable")
      ->allow_extra_args(false)
      ->take_all();
}

}  // namespace stillray
