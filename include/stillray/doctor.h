// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The input doctor: measures a sequence of another renderer's frames and says what is wrong with
/// it, where, and what to do about it. docs/check.md lists every finding.
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

/// One thing that is wrong with a sequence.
struct Finding {
  std::string name;             ///< one of FindingTable(), "motion_y_flipped"
  std::vector<int64_t> frames;  ///< where it was measured, sorted
  std::string what;             ///< one line: what, where, the figure and what was expected
  std::string cure;             ///< one line: the option, or the renderer's setting
  double measured = 0;          ///< the figure in `what`, ...
  double expected = 0;          ///< ... and the limit that it broke
  std::string aov;              ///< value of --aov that cures it; empty where none does
};

/// A figure that decides on a finding, told whether or not it was broken.
struct Measure {
  std::string name;
  double value = 0;
  double limit = 0;
  bool broken = false;
  int64_t judged = 0;  ///< frames or pairs of frames that it is taken of; never 0
};

struct DoctorReport {
  std::vector<Finding> findings;
  std::vector<Measure> measures;
  std::vector<int64_t> frames;  ///< all that were looked at
  AovLayout layout;             ///< as understood in the first frame
};

struct FindingInfo {
  std::string_view name;
  std::string_view meaning;
};
/// Every finding there is, in the order of a report.
std::span<const FindingInfo> FindingTable();

/// "frames 1-4, 9": numbers that follow each other as ranges.
std::string FrameRanges(const std::vector<int64_t>& frames);

/// Looks at one frame after the other; keeps two of them. Not thread-safe; the same frames give the
/// same report for any number of threads.
class Doctor {
 public:
  /// \param options  how the layers of the first frame, and with it of all, are to be understood
  static std::unique_ptr<Doctor> Create(const AovOptions& options);
  virtual ~Doctor() = default;

  /// \param number  frame number; must rise from call to call
  /// \param name    stands for the file in messages
  /// \return what UnderstandAovs and ImportFrame return of the first frame; kInvalidArgument if
  ///         numbers do not rise. Later frames that differ in size or lack layers are findings.
  virtual Status Add(int64_t number, const std::string& name, const ExrImage& image) = 0;
  /// Of all frames so far. \return kInvalidArgument if there were none
  virtual Result<DoctorReport> Report() = 0;
  /// As understood in the first frame; nullptr before it.
  virtual const AovLayout* layout() const = 0;
};

/// A file of a sequence and its number.
struct NumberedFile {
  int64_t number = 0;
  std::string path;
};

/// Reads the files one after the other and reports on them, as `stillray check` does.
/// \param files    in the order of their numbers; the first few of a sequence are enough for most
///                 findings
/// \param go_on    called before each file; false ends the examination with kCancelled. May be
/// empty \return what Doctor::Add and DecodeExr return of the first file that cannot be used
Result<DoctorReport> ExamineFiles(std::span<const NumberedFile> files, const AovOptions& options,
                                  const std::function<bool()>& go_on = {});

/// "name: what; cure: what to do", one line.
std::string FindingLine(const Finding& finding);

}  // namespace stillray
