// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of a sequence of EXR files: shot cuts, light of past and future frames, light passes,
/// reading and writing beside the filter, and a state on disk from which a run can be resumed. What
/// `stillray denoise` does, without its options and its output.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/status.h"

namespace stillray {

/// One frame of a sequence: the EXR file that is read, and the one that is written.
struct SequenceFile {
  int64_t frame = 0;
  std::string input;
  std::string output;
};

/// Frames whose light a frame gets, besides its own.
enum class Window : uint8_t {
  kPast,  ///< those before it
  kBoth,  ///< those after it too
};
/// "past", "both".
const char* WindowName(Window window);

/// The files of a sequence in the order of their frames, by the names that `stillray denoise`
/// takes. \param inputs  one name: a pattern ("in.####.exr", "in.%04d.exr"), wild cards
/// ("in.*.exr"), or a
///        folder that holds one sequence; or files
/// \param output  a pattern, a folder, or for one frame a file
/// \param frames  "FIRST-LAST", one number, or empty for all
/// \return kNotFound, kInvalidArgument (a folder with several sequences, frames that are not there,
///         outputs that would overwrite inputs or each other)
Result<std::vector<SequenceFile>> ListSequence(const std::vector<std::string>& inputs,
                                               const std::string& output,
                                               const std::string& frames);

/// The window where a user leaves the choice: both sides of a sequence without gaps; the past of
/// one frame, or of a sequence with gaps, whose missing frames may still come. \param note  set to
/// the reason where it is the past of several frames
Window ChooseWindow(const std::vector<SequenceFile>& files, std::string* note);

struct MemoryLimit {
  int64_t bytes = 0;  ///< 0: none
  /// What stands before the number in messages.
  std::string name = "the limit is";
};

/// The state from which a run can be resumed, in the folder of the outputs: written every 30 s and
/// when a run stops.
struct StateOptions {
  bool keep = false;
  bool resume = false;  ///< go on with the state of an earlier run of the same options
  /// Lines "name value" of what decides the pictures besides SequenceOptions. A state of other
  /// options or another fingerprint is not resumed.
  std::string fingerprint;
};

/// Everything that decides the bits of a run, and the memory that it may take.
struct SequenceOptions {
  std::vector<SequenceFile> files;  ///< one or more, their frames rising, all outputs in one folder
  AovOptions aovs;
  Settings settings;
  /// Names of parameters of `settings` that stay as they are, where the files would choose another
  /// value: tests of the history with soft guides, antialiasing of frames without jitter.
  std::vector<std::string> fixed_parameters;
  Window window = Window::kPast;
  /// Takes kPast in place of kBoth where memory is too little for both.
  bool window_may_narrow = false;
  bool passes = false;  ///< write the denoised light of every light layer too
  MemoryLimit memory;
  /// Read the next file and write the last one while a frame is filtered, where memory allows. The
  /// bits are the same.
  bool overlap = true;
  StateOptions state;

  bool IsFixed(std::string_view parameter) const;
};

/// Milliseconds of one stage of a frame.
struct LoggedStage {
  std::string name;
  double milliseconds = 0;
};

inline std::vector<LoggedStage> LoggedStages(const std::vector<StageTime>& timings) {
  std::vector<LoggedStage> stages;
  for (const StageTime& stage : timings) {
    stages.push_back({std::string(stage.name), stage.milliseconds});
  }
  return stages;
}

/// What happened to one frame.
struct FrameReport {
  int64_t frame = 0;
  std::string input;
  std::string output;
  double read_ms = 0;
  double future_ms = 0;   ///< accumulating later frames backward, where that was due
  double denoise_ms = 0;  ///< 0 for a frame that an earlier run filtered and could not write
  double write_ms = 0;
  /// From the end of the frame before, or the run's start, to its own end. Less than the sum of the
  /// others where they overlap.
  double elapsed_ms = 0;
  /// Fraction of the pixels with a surface that had no history, 0..1; 1 in the first frame.
  double without_history = 1;
  bool restarted = false;      ///< history was dropped before this frame
  int64_t missing_light = 0;   ///< values that were NaN, infinite or negative, ...
  int64_t negative_light = 0;  ///< ... of these negative
  int64_t bad_guides = 0;      ///< pixels that were passed through
  int64_t written_bytes = 0;   ///< of the output
  std::vector<LoggedStage> stages;
  std::string note;     ///< why history was dropped, or empty
  std::string warning;  ///< of the denoiser, or empty
};

/// Calls to the owner of a run. All may be empty, and all but `picture` come from the thread of the
/// caller, in the order of the frames.
struct SequenceHooks {
  /// Polled before every frame; false stops the run.
  std::function<bool()> keep_going;
  /// A line of text for the user.
  std::function<void(const std::string& text)> note;
  /// The denoiser goes on on the CPU, for this reason. Called once.
  std::function<void(const std::string& reason)> fell_back;
  /// A frame is about to be accumulated for the future of earlier ones.
  std::function<void(const SequenceFile& file)> looks_ahead;
  /// The frame's file is complete on disk.
  std::function<void(const FrameReport& report)> finished;
  /// A denoised picture whose file is about to be written; an error stops the run. From a thread
  /// that writes, one frame at a time, in their order.
  std::function<Status(const SequenceFile& file, const Image3& colour)> picture;
  /// Text that the state for resuming keeps: finished frames, and behind them those that are
  /// filtered and not written.
  std::function<std::string(std::span<const FrameReport> frames)> save_log;
  /// The frames of such a text. Without, reports() lacks those of an earlier run.
  std::function<Result<std::vector<FrameReport>>(const std::string& log)> restore_log;
};

/// How a run ended.
struct SequenceEnd {
  /// kCancelled if keep_going ended it; what reading, denoising and writing return, naming the
  /// file.
  Status status;
  /// Of the state for resuming that a run saves when it stops before its last frame.
  Status save_status;
  /// Whether there is a state on disk, of this end or an earlier moment.
  bool can_resume = false;
  size_t resumes_at = 0;  ///< first file that is written when it is resumed
};

/// Denoises one sequence. Not thread-safe; its work uses all threads of the pool.
class SequenceDenoiser {
 public:
  /// Reads the first file, finds out what its layers are, makes the denoisers, and takes up the
  /// state that options.state asks for. Writes nothing.
  /// \return kNotFound, kBadData (a file or a state is damaged), kInvalidArgument (layers or
  ///         settings that do not fit together; a state of other options, or inputs that have
  ///         changed since), kOutOfMemory (a frame does not fit into the limit, naming need and
  ///         limit), kUnsupported
  static Result<SequenceDenoiser> Create(const SequenceOptions& options, const Device& device,
                                         const SequenceHooks& hooks);
  /// The same with a device that is opened after the first file was read: opening one can take
  /// seconds, and a wrong file is found before.
  using OpenDevice = std::function<Result<Device>()>;
  static Result<SequenceDenoiser> Create(const SequenceOptions& options, const OpenDevice& open,
                                         const SequenceHooks& hooks);
  SequenceDenoiser(SequenceDenoiser&&) noexcept;
  SequenceDenoiser& operator=(SequenceDenoiser&&) noexcept;
  ~SequenceDenoiser();

  const SequenceOptions& options() const;  ///< with the window that is used
  const AovLayout& layout() const;
  const Settings& settings() const;  ///< the ones that are used; see SequenceOptions
  const ExrExtent& extent() const;   ///< of the first file

  /// Whether this run goes on with the state of an earlier one.
  bool resumed() const;
  /// Frames whose files are complete; before Run() those of the run that is resumed.
  size_t finished() const;
  /// Frames that are accumulated backward by Run(), each as often as it is.
  size_t look_ahead_steps() const;

  /// Denoises and writes the frames that are not finished. To be called once.
  SequenceEnd Run();
  /// Removes the state for resuming, if there is one. Run() leaves it to the caller, as its
  /// own work behind the last frame can fail too.
  void RemoveState();

  const std::vector<FrameReport>& reports() const;  ///< of finished frames
  /// Whether a frame had motion other than zero.
  bool motion_was_seen() const;
  size_t memory_bytes() const;         ///< of the denoisers, at most
  DeviceMemory device_memory() const;  ///< of that what lies on a device

  struct Impl;  ///< of the module sequence

 private:
  explicit SequenceDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
