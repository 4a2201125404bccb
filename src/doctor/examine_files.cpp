// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Runs the doctor on the files of a sequence.
#include <fmt/format.h>

#include "stillray/doctor.h"

namespace stillray {
namespace {

constexpr size_t kMaxFileBytes = size_t{4} << 30;

Status AddFile(const NumberedFile& file, Doctor* doctor) {
  const Result<std::string> bytes = ReadWholeFile(file.path, kMaxFileBytes);
  if (!bytes.ok()) {
    return bytes.status();
  }
  const Result<ExrImage> image =
      DecodeExr(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), file.path);
  if (!image.ok()) {
    return image.status();
  }
  return doctor->Add(file.number, file.path, *image);
}

}  // namespace

Result<DoctorReport> ExamineFiles(std::span<const NumberedFile> files, const AovOptions& options,
                                  const std::function<bool()>& go_on) {
  const std::unique_ptr<Doctor> doctor = Doctor::Create(options);
  for (const NumberedFile& file : files) {
    if (go_on && !go_on()) {
      return Status::Cancelled();
    }
    STILLRAY_RETURN_IF_ERROR(AddFile(file, doctor.get()));
  }
  return doctor->Report();
}

std::string FindingLine(const Finding& finding) {
  return fmt::format("{}: {}; cure: {}", finding.name, finding.what, finding.cure);
}

}  // namespace stillray
