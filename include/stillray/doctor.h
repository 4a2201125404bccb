// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The input doctor: examines a sequence of another renderer's frames and reports faults, their
/// frames, and the cure. docs/check.md lists every finding.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/aov.h"
#include "stillray/io.h"
#include "stillray/status.h"

namespace stillray {

/// One fault of a sequence.
struct Finding {
  std::string name;             ///< one of FindingTable(), "motion_y_flipped"
  std::vector<int64_t> frames;  ///< where it was found, sorted
  /// one line: fault, location, measured value, expected value
  std::string what;
  std::string cure;     ///< one line: the option, or the renderer's setting
  double measured = 0;  ///< the measured value of `what`
  double expected = 0;  ///< the limit of `measured`
  std::string aov;      ///< value of --aov that corrects the fault; empty if there is none
};

/// A measurement behind a finding, reported whether or not its limit is exceeded.
struct Measure {
  std::string name;
  double value = 0;
  double limit = 0;
  bool broken = false;
  int64_t judged = 0;  ///< number of frames or pairs of frames measured; never 0
};

struct DoctorReport {
  std::vector<Finding> findings;
  std::vector<Measure> measures;
  std::vector<int64_t> frames;  ///< all examined frames
  AovLayout layout;             ///< of the first frame
};

struct FindingInfo {
  std::string_view name;
  std::string_view meaning;
};
/// All possible findings, in the order of a report.
std::span<const FindingInfo> FindingTable();

/// "frames 1-4, 9": consecutive numbers as ranges.
std::string FrameRanges(const std::vector<int64_t>& frames);

/// Examines frames in sequence; two frames are held in memory. Not thread-safe; the same frames
/// give the same report for any number of threads.
class Doctor {
 public:
  /// \param options  interpretation of the first frame's layers, which applies to all frames
  static std::unique_ptr<Doctor> Create(const AovOptions& options);
  virtual ~Doctor() = default;

  /// \param number  frame number; must increase from call to call
  /// \param name    of the file, for messages
  /// \return errors of UnderstandAovs and ImportFrame for the first frame; kInvalidArgument if
  ///     numbers do not increase. Later frames that differ in size or lack layers are findings.
  virtual Status Add(int64_t number, const std::string& name, const ExrImage& image) = 0;
  /// Reports on all frames added so far. \return kInvalidArgument if no frame was added
  virtual Result<DoctorReport> Report() = 0;
  /// The layout of the first frame; nullptr before the first Add().
  virtual const AovLayout* layout() const = 0;
};

/// A file of a sequence and its number.
struct NumberedFile {
  int64_t number = 0;
  std::string path;
};

/// Reads the files in sequence and reports on them, as `stillray check` does.
/// \param files    in the order of their numbers; the first few of a sequence are enough for most
///     findings
/// \param go_on    called before each file; false ends the examination with kCancelled. May be
///     empty
/// \return errors of Doctor::Add and DecodeExr for the first unusable file
Result<DoctorReport> ExamineFiles(std::span<const NumberedFile> files, const AovOptions& options,
                                  const std::function<bool()>& go_on = {});

/// "name: fault; cure: remedy", one line.
std::string FindingLine(const Finding& finding);

}  // namespace stillray
