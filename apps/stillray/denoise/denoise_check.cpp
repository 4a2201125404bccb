// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_check.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "sequence/frames.h"

namespace stillray {
namespace {

/// Findings that denoising reports at the frame where they occur.
constexpr std::string_view kSaidElsewhere[] = {"frames_missing", "size_changes", "layers_change"};

/// The guides whose absence is both a note of the layout and a finding.
constexpr Aov kGuides[] = {Aov::kMotion, Aov::kDepth, Aov::kNormal, Aov::kAlbedo};

std::string MissingName(Aov aov) {
  return std::string(AovName(aov)) + "_missing";
}

bool LeftAwayByUser(const DenoiseOptions& options, Aov aov) {
  const std::vector<std::string>& mappings = options.text.aovs.mappings;
  return std::find(mappings.begin(), mappings.end(), std::string(AovName(aov)) + "=none") !=
         mappings.end();
}

bool IsSaidElsewhere(const Finding& finding, const DenoiseOptions& options, bool derives_motion) {
  if (std::find(std::begin(kSaidElsewhere), std::end(kSaidElsewhere), finding.name) !=
      std::end(kSaidElsewhere)) {
    return true;
  }
  // A note of the layout reports it.
  if (derives_motion &&
      (finding.name == MissingName(Aov::kMotion) || finding.name == "motion_zero")) {
    return true;
  }
  return std::any_of(std::begin(kGuides), std::end(kGuides), [&](Aov aov) {
    return finding.name == MissingName(aov) && LeftAwayByUser(options, aov);
  });
}

}  // namespace

Result<std::vector<Finding>> CheckFirstFrames(const DenoiseOptions& options, bool derives_motion) {
  const std::unique_ptr<Doctor> doctor = Doctor::Create(options.text.aovs);
  const size_t count = std::min(options.sequence.files.size(), kCheckedFrames);
  size_t looked_at = 0;
  for (; looked_at < count; ++looked_at) {
    if (Interrupted()) {
      return Status::Cancelled();
    }
    const SequenceFile& file = options.sequence.files[looked_at];
    const Result<LoadedFile> loaded = LoadFile(file.input, options.sequence, false);
    if (!loaded.ok() || !doctor->Add(file.frame, file.input, loaded->image).ok()) {
      break;
    }
  }
  if (looked_at == 0) {
    return std::vector<Finding>();
  }
  Result<DoctorReport> report = doctor->Report();
  if (!report.ok()) {
    return report.status();
  }
  std::vector<Finding> findings = std::move(report->findings);
  std::erase_if(findings, [&](const Finding& finding) {
    return IsSaidElsewhere(finding, options, derives_motion);
  });
  return findings;
}

std::vector<std::string> NotesBeside(const std::vector<Finding>& findings,
                                     const AovLayout& layout) {
  std::vector<std::string> notes = layout.notes;
  for (const Aov aov : kGuides) {
    if (HasFinding(findings, MissingName(aov))) {
      std::erase_if(notes, [&](const std::string& note) {
        return note.starts_with(fmt::format("no {}: ", AovName(aov)));
      });
    }
  }
  return notes;
}

bool HasFinding(const std::vector<Finding>& findings, std::string_view name) {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.name == name; });
}

}  // namespace stillray
