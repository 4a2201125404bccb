// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_writer.h"

#include <utility>

#include "stillray/io.h"

namespace stillray {
namespace {

Status Write(FrameToWrite frame, const AovLayout& layout, Preview* preview, int64_t* size) {
  const Result<std::string> bytes = ReplaceLight(
      frame.bytes, layout, frame.colour, frame.names.input, frame.layers, std::move(frame.stored));
  if (!bytes.ok()) {
    return bytes.status();
  }
  *size = static_cast<int64_t>(bytes->size());
  // The file last: once it is there, its frame is complete.
  if (preview != nullptr) {
    STILLRAY_RETURN_IF_ERROR(preview->Write(frame.names, frame.colour));
  }
  return WriteFileAtomically(frame.names.output, bytes->data(), bytes->size());
}

}  // namespace

void FrameWriter::Start(FrameToWrite frame) {
  writing_.Start(beside_, [this, work = std::move(frame)]() mutable {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    WrittenFrame written;
    written.status = Write(std::move(work), layout_, preview_, &written.bytes);
    written.end = Clock::now();
    written.milliseconds = std::chrono::duration<double, std::milli>(written.end - start).count();
    return written;
  });
}

}  // namespace stillray
