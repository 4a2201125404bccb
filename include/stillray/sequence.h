// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of a sequence of EXR files: shot cuts, light of past and future frames, light passes,
/// reading and writing in the background, and a state on disk from which a run can be resumed.
/// `stillray denoise` without its options and output.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
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

/// The frames whose light is accumulated for a frame, besides its own.
enum class Window : uint8_t {
  kPast,  ///< earlier frames
  kBoth,  ///< earlier and later frames
};
/// "past", "both".
const char* WindowName(Window window);

/// Where the motion of a sequence comes from.
enum class MotionSource : uint8_t {
  /// The files, and what follows below where they have none or zeros although guides move: the
  /// cameras if they are known, with estimation of what moves by itself; else estimation.
  kAuto,
  kFile,      ///< the motion layer; without one, cameras in the files and depth
  kCamera,    ///< depth and the cameras alone: nothing moves by itself
  kEstimate,  ///< the guides, beginning with the cameras if they are known
};
/// "auto", "file", "camera", "estimate".
const char* MotionSourceName(MotionSource source);
std::optional<MotionSource> MotionSourceOf(std::string_view name);

/// The files of a sequence in the order of their frames, by the names of `stillray denoise`.
/// \param inputs  one name: a pattern ("in.####.exr", "in.%04d.exr"), wild cards ("in.*.exr"), or a
///     folder that holds one sequence; or files
/// \param output  a pattern, a folder, or for one frame a file
/// \param frames  "FIRST-LAST", one number, or empty for all
/// \return kNotFound, kInvalidArgument (a folder with several sequences, frames that do not exist,
///     outputs that would overwrite inputs or each other)
Result<std::vector<SequenceFile>> ListSequence(const std::vector<std::string>& inputs,
                                               const std::string& output,
                                               const std::string& frames);

/// The default window: both sides of a sequence without gaps; the past of one frame, or of a
/// sequence with gaps, whose missing frames may still come.
/// \param note  set to the reason if it is the past of several frames
Window ChooseWindow(const std::vector<SequenceFile>& files, std::string* note);

/// Limit on the memory of a run.
struct MemoryLimit {
  int64_t bytes = 0;  ///< 0: none
  /// Text before the number in messages.
  std::string name = "the limit is";
};

/// The state from which a run can be resumed, in the folder of the outputs: written every 30 s and
/// when a run stops.
struct StateOptions {
  bool keep = false;
  bool resume = false;  ///< continue from the state of an earlier run with the same options
  /// Lines "name value" of settings besides SequenceOptions that affect the pictures. A state with
  /// other options or another fingerprint is not resumed.
  std::string fingerprint;
};

/// All settings that affect the bits of a run, and its memory limit.
struct SequenceOptions {
  /// One or more, with increasing frames; all outputs in one folder, which must exist.
  std::vector<SequenceFile> files;
  AovOptions aovs;
  Settings settings;
  /// Names of parameters of `settings` that are kept even if the files call for another value:
  /// tests of the history with soft guides, antialiasing of frames without jitter.
  std::vector<std::string> fixed_parameters;
  Window window = Window::kPast;
  /// Use kPast instead of kBoth if memory is too small for both.
  bool window_may_narrow = false;
  MotionSource motion = MotionSource::kAuto;
  /// A JSON file with the camera of every frame (docs/files.md), which counts in place of cameras
  /// in the files; or empty.
  std::string cameras = {};
  /// Samples per pixel of files without a layer of them; 0: as many as the first file states,
  /// else 1.
  int spp = 0;
  bool passes = false;         ///< also write the denoised light of every light layer
  bool denoise_alpha = false;  ///< else alpha is copied
  MemoryLimit memory;
  /// Read the next file and write the last one while a frame is filtered, if memory allows. The
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

/// The result of one frame.
struct FrameReport {
  int64_t frame = 0;
  std::string input;
  std::string output;
  double read_ms = 0;
  double future_ms = 0;   ///< accumulating later frames backward, if necessary
  double denoise_ms = 0;  ///< of the run that filtered it
  double write_ms = 0;
  /// From the end of the previous frame, or the run's start, to its own end. Less than the sum of
  /// the others if they overlap.
  double elapsed_ms = 0;
  /// Fraction of the pixels with a surface that had no history, 0..1; 1 in the first frame.
  double without_history = 1;
  bool restarted = false;      ///< history was dropped before this frame
  int64_t missing_light = 0;   ///< values that were NaN, infinite or negative, ...
  int64_t negative_light = 0;  ///< ... of these negative
  int64_t bad_guides = 0;      ///< pixels that were passed through
  int64_t written_bytes = 0;   ///< of the output
  std::vector<LoggedStage> stages;
  /// The origin of its motion towards the previous frame: "file", "camera", "estimate", or empty
  /// where there is none.
  std::string motion;
  /// Fractions of the pixels with a surface whose motion was estimated, and whose guides no motion
  /// explains.
  double motion_estimated = 0;
  double motion_unknown = 0;
  /// Why images in mirrors, glass or convex surfaces do not have their own guides or motion, and
  /// the cure; empty if they do, or if there are none.
  std::string images_missing;
  std::string note;     ///< why history was dropped, or empty
  std::string warning;  ///< of the denoiser, or empty
};

/// Callbacks of a run. All may be empty, and all but `picture` are called on the caller's thread,
/// in the order of the frames.
struct SequenceHooks {
  /// Polled before every frame; false stops the run.
  std::function<bool()> keep_going;
  /// A line of text for the user.
  std::function<void(const std::string& text)> note;
  /// The denoiser falls back to the CPU, for this reason. Called once.
  std::function<void(const std::string& reason)> fell_back;
  /// A frame will be accumulated for the future of earlier ones.
  std::function<void(const SequenceFile& file)> looks_ahead;
  /// The frame's file is complete on disk.
  std::function<void(const FrameReport& report)> finished;
  /// May change a denoised picture, from the frame's guides, before it is written; an error stops
  /// the run. Not called again for pictures that a resumed run takes from the state.
  /// \param focal_pixels  height of the picture over that in tangents of the angle of view, by the
  ///     camera in the file or in SequenceOptions::cameras; 0: unknown, or without perspective
  std::function<Status(const SequenceFile& file, const Frame& frame, double focal_pixels,
                       Image3* colour)>
      effects;
  /// A denoised picture before its file is written; an error stops the run. Called on the writer's
  /// thread, one frame at a time, in order.
  std::function<Status(const SequenceFile& file, const Image3& colour)> picture;
  /// Text to store in the state: of finished frames, followed by those that are filtered but not
  /// written.
  std::function<std::string(std::span<const FrameReport> frames)> save_log;
  /// Parses such a text. Without, reports() lacks the frames of an earlier run.
  std::function<Result<std::vector<FrameReport>>(const std::string& log)> restore_log;
};

/// How a run ended.
struct SequenceEnd {
  /// kCancelled if keep_going ended it; errors of reading, denoising and writing, naming the file.
  Status status;
  /// Of saving the state when a run stops before its last frame.
  Status save_status;
  /// Whether there is a state on disk, from this end or earlier.
  bool can_resume = false;
  size_t resumes_at = 0;  ///< first file that a resumed run writes
};

/// Denoises one sequence. Not thread-safe; its work uses all threads of the pool.
class SequenceDenoiser {
 public:
  /// Reads the first file, assigns roles to its layers, creates the denoisers, and restores the
  /// state if options.state requests it. Writes nothing.
  /// \return kNotFound, kBadData (a file or a state is damaged), kInvalidArgument (layers or
  ///     settings that contradict each other; a state of other options, or inputs that have changed
  ///     since), kOutOfMemory (a frame does not fit into the limit, naming need and limit),
  ///     kUnsupported
  static Result<SequenceDenoiser> Create(const SequenceOptions& options, const Device& device,
                                         const SequenceHooks& hooks = SequenceHooks());
  /// The same with a device that is opened after the first file was read: opening one can take
  /// seconds, and a wrong file is found before.
  using OpenDevice = std::function<Result<Device>()>;
  static Result<SequenceDenoiser> Create(const SequenceOptions& options, const OpenDevice& open,
                                         const SequenceHooks& hooks = SequenceHooks());
  SequenceDenoiser(SequenceDenoiser&&) noexcept;
  SequenceDenoiser& operator=(SequenceDenoiser&&) noexcept;
  ~SequenceDenoiser();

  const SequenceOptions& options() const;  ///< with the window in use
  const AovLayout& layout() const;
  const Settings& settings() const;  ///< the settings in use; see SequenceOptions
  const ExrExtent& extent() const;   ///< of the first file

  /// Whether this run continues from the state of an earlier one.
  bool resumed() const;
  /// Number of frames with complete files; before Run() those of the resumed run.
  size_t finished() const;
  /// Number of frames that Run() accumulates backward, counting repetitions.
  size_t look_ahead_steps() const;

  /// Denoises and writes the unfinished frames. Call it once.
  SequenceEnd Run();
  /// Removes the state, if there is one. Run() leaves it to the caller, whose work after the last
  /// frame can fail too.
  void RemoveState();

  const std::vector<FrameReport>& reports() const;  ///< of finished frames
  /// Whether motion that the files lack is derived from cameras or guides.
  bool derives_motion() const;
  /// Whether a frame had motion other than zero.
  bool motion_was_seen() const;
  size_t memory_bytes() const;         ///< of the denoisers, at most
  DeviceMemory device_memory() const;  ///< the part of it on a device

  struct Impl;  ///< of the module sequence

 private:
  explicit SequenceDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
