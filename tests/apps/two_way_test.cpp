// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames in memory, denoised through the C++ engine and through the C API, have the bits of the
// files that `stillray denoise --window both` writes.
#include "stillray/two_way.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "capi/capi_frames.h"
#include "program.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray {
namespace {

constexpr int kFrames = 36;  // three blocks, of which two look ahead as far as they can

void RunWell(const std::vector<std::string>& arguments) {
  const ProgramRun run = RunProgram(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
}

/// A rendered sequence, and the program's result for it.
struct Sequence {
  std::vector<Frame> frames;
  std::vector<Image3> denoised;
};

Image3 ColourOf(const std::string& path) {
  const Result<ExrImage> image = ReadExr(path);
  Image3 colour;
  const char* kNames[] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    colour[c] = image->Find(kNames[c])->values;
  }
  return colour;
}

void MakeSequence(Sequence* sequence) {
  const TemporaryFolder folder;
  RunWell({"render", "builtin:spheres", "-o", folder / "in", "--size", "48x32", "--frames",
           "1-" + std::to_string(kFrames), "--format", "exr", "--save-inputs", "--float"});
  const std::string inputs = folder / "in/noisy.####.exr";
  RunWell({"denoise", inputs, "-o", folder / "out/f.####.exr", "--window", "both"});
  AovLayout layout;
  for (int i = 1; i <= kFrames; ++i) {
    const std::string path = FrameFileName(inputs, i);
    const Result<ExrImage> image = ReadExr(path);
    ASSERT_TRUE(image.ok()) << image.status().message();
    if (i == 1) {
      const Result<AovLayout> found = UnderstandAovs(*image, AovOptions(), path);
      ASSERT_TRUE(found.ok()) << found.status().message();
      layout = *found;
    }
    Result<Frame> frame = ImportFrame(*image, layout, {0, 0}, path);
    ASSERT_TRUE(frame.ok()) << frame.status().message();
    frame->index = i;
    sequence->frames.push_back(std::move(frame.value()));
    sequence->denoised.push_back(ColourOf(FrameFileName(folder / "out/f.####.exr", i)));
  }
}

const Sequence& Rendered() {
  static const Sequence sequence = [] {
    Sequence made;
    MakeSequence(&made);
    return made;
  }();
  return sequence;
}

TEST(TwoWayOfFiles, TheEngineGivesTheBitsOfTheCommandLine) {
  const Sequence& sequence = Rendered();
  ASSERT_EQ(sequence.frames.size(), static_cast<size_t>(kFrames));
  Result<TwoWayDenoiser> denoiser = TwoWayDenoiser::Create(PresetSettings("default").value());
  ASSERT_TRUE(denoiser.ok());
  size_t done = 0;
  for (size_t i = 0; i <= sequence.frames.size(); ++i) {
    if (i < sequence.frames.size()) {
      const Status pushed = denoiser->Push(sequence.frames[i]);
      ASSERT_TRUE(pushed.ok()) << pushed.message();
    } else {
      denoiser->Finish();
    }
    for (DenoisedFrame out; denoiser->Pull(&out).value(); ++done) {
      EXPECT_TRUE(test::SameBits(out.colour, sequence.denoised[done])) << "frame " << done + 1;
    }
  }
  EXPECT_EQ(done, sequence.frames.size());
}

/// Pulls all frames that are ready and compares them.
void PullReady(stillray_denoiser* denoiser, size_t* done) {
  const Sequence& sequence = Rendered();
  Image3 colour(48, 32);
  test::Buffer buffer(48, 32, 3, STILLRAY_FORMAT_FLOAT, test::Layout::kInterleaved);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser, "colour", &buffer.image), STILLRAY_OK);
  for (;;) {
    int32_t pulled = 0;
    ASSERT_EQ(stillray_denoiser_pull(denoiser, &pulled), STILLRAY_OK)
        << stillray_error_message(denoiser);
    if (pulled == 0) {
      return;
    }
    test::FillImage<3>(&colour, [&](int x, int y, int c) { return buffer.Get(x, y, c); });
    EXPECT_TRUE(test::SameBits(colour, sequence.denoised[*done])) << "frame " << *done + 1;
    ++*done;
  }
}

TEST(TwoWayOfFiles, TheCApiGivesTheBitsOfTheCommandLine) {
  const Sequence& sequence = Rendered();
  ASSERT_EQ(sequence.frames.size(), static_cast<size_t>(kFrames));
  const test::DenoiserHandle denoiser = test::MakeDenoiser();
  ASSERT_EQ(stillray_denoiser_set_frame_index(denoiser.get(), 1), STILLRAY_OK);
  size_t done = 0;
  for (const Frame& frame : sequence.frames) {
    test::CallerFrame caller(frame);
    caller.Give(denoiser.get());
    ASSERT_EQ(stillray_denoiser_push(denoiser.get(), STILLRAY_CUT_FIND), STILLRAY_OK)
        << stillray_error_message(denoiser.get());
    PullReady(denoiser.get(), &done);
  }
  ASSERT_EQ(stillray_denoiser_finish(denoiser.get()), STILLRAY_OK);
  PullReady(denoiser.get(), &done);
  EXPECT_EQ(done, sequence.frames.size());
}

}  // namespace
}  // namespace stillray
