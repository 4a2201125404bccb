// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoises the EXR files of a sequence with past and future frames, and every light layer
/// separately: `stillray denoise INPUT -o FOLDER --passes`.
///   denoise_files 'shot.####.exr' clean/
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include <stillray/sequence.h>

namespace {

int Fail(const stillray::Status& status) {
  std::fprintf(stderr, "error: %s\n", status.message().c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: denoise_files INPUT FOLDER\n");
    return 2;
  }
  auto files = stillray::ListSequence({argv[1]}, argv[2], "");
  if (!files.ok()) {
    return Fail(files.status());
  }
  std::filesystem::create_directories(argv[2]);
  stillray::SequenceOptions options;
  options.files = std::move(files.value());
  options.settings = stillray::PresetSettings("default").value();
  options.window = stillray::Window::kBoth;
  options.passes = true;

  stillray::SequenceHooks hooks;
  hooks.note = [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
  hooks.finished = [](const stillray::FrameReport& report) {
    std::printf("%s %.0f ms\n", report.output.c_str(), report.elapsed_ms);
  };
  auto sequence = stillray::SequenceDenoiser::Create(options, stillray::Device(), hooks);
  if (!sequence.ok()) {
    return Fail(sequence.status());
  }
  const stillray::SequenceEnd end = sequence->Run();
  return end.status.ok() ? 0 : Fail(end.status);
}
