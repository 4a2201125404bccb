// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of a sequence of EXR files: shot cuts, light of past and future frames, light passes,
/// reading and writing in the background, and a state on disk from which a run can be resumed. The
/// implementation of `stillray denoise`.
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

/// The frames whose radiance is accumulated for a frame, in addition to the frame itself.
enum class Window : uint8_t {
  kPast,  ///< earlier frames
  kBoth,  ///< earlier and later frames
};
/// "past", "both".
const char* WindowName(Window window);

/// The source of a sequence's motion vectors.
enum class MotionSource : uint8_t {
  /// The files; if they have no motion, or zeros although the guides move: the cameras if known,
  /// with estimation for moving objects, else estimation alone.
  kAuto,
  kFile,      ///< the motion layer; without one, cameras in the files and depth
  kCamera,    ///< depth and the cameras alone: all objects are assumed static
  kEstimate,  ///< estimation from the guides, starting from the cameras if known
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

/// The default window: kBoth for a sequence without gaps; kPast for one frame, or for a sequence
/// with gaps, whose missing frames may be added later.
/// \param note  set to the reason if it is kPast for several frames
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
  /// Lines "name value" of settings that affect the output and are not in SequenceOptions. A state
  /// with other options or another fingerprint is not resumed.
  std::string fingerprint;
};

/// All settings that affect the bits of a run, and its memory limit.
struct SequenceOptions {
  /// One or more, with increasing frames; all outputs in one folder, which must exist.
  std::vector<SequenceFile> files;
  AovOptions aovs;
  Settings settings;
  /// Names of parameters of `settings` that keep their value. Others may be adapted to the files:
  /// history tests with soft guides, antialiasing of frames without jitter.
  std::vector<std::string> fixed_parameters;
  Window window = Window::kPast;
  /// Use kPast instead of kBoth if memory is too small for both.
  bool window_may_narrow = false;
  MotionSource motion = MotionSource::kAuto;
  /// A JSON file with the camera of every frame (docs/files.md), which overrides cameras in the
  /// files; or empty.
  std::string cameras = {};
  /// Samples per pixel of files without a layer of sample counts; 0: the number in the metadata of
  /// the first file, else 1.
  int spp = 0;
  bool passes = false;         ///< also write the denoised radiance of every light layer
  bool denoise_alpha = false;  ///< else alpha is copied
  MemoryLimit memory;
  /// Read the next file and write the previous one while a frame is filtered, if memory allows.
  /// Results do not depend on it.
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
  double future_ms = 0;   ///< accumulating later frames backward, if needed
  double denoise_ms = 0;  ///< of the run that filtered the frame
  double write_ms = 0;
  /// From the end of the previous frame, or the run's start, to the end of this frame. Less than
  /// the sum of the other times if they overlap.
  double elapsed_ms = 0;
  /// Fraction of the surface pixels without history, 0..1; 1 in the first frame.
  double without_history = 1;
  bool restarted = false;      ///< history was dropped before this frame
  int64_t missing_light = 0;   ///< number of NaN, infinite or negative values
  int64_t negative_light = 0;  ///< number of negative values among missing_light
  int64_t bad_guides = 0;      ///< number of pixels with invalid guides, not filtered
  int64_t written_bytes = 0;   ///< of the output
  std::vector<LoggedStage> stages;
  /// The source of the motion towards the previous frame: "file", "camera", "estimate", or empty if
  /// there is no motion.
  std::string motion;
  /// Fractions of the surface pixels, 0..1: with estimated motion, and with guides that match no
  /// motion.
  double motion_estimated = 0;
  double motion_unknown = 0;
  /// Why virtual images in mirrors, glass or convex surfaces lack guides or motion, and the remedy;
  /// empty if they have both, or if there are no virtual images.
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
  /// A frame will be accumulated for the future of earlier frames.
  std::function<void(const SequenceFile& file)> looks_ahead;
  /// The frame's file is complete on disk.
  std::function<void(const FrameReport& report)> finished;
  /// May change the denoised image, using the frame's guides, before it is written; an error stops
  /// the run. Not called again for images that a resumed run reads from the state.
  /// \param focal_pixels  vertical focal length in pixels, of the camera in the file or in
  ///     SequenceOptions::cameras; 0: unknown, or without perspective
  std::function<Status(const SequenceFile& file, const Frame& frame, double focal_pixels,
                       Image3* colour)>
      effects;
  /// The denoised image before its file is written; an error stops the run. Called on the writer's
  /// thread, one frame at a time, in order.
  std::function<Status(const SequenceFile& file, const Image3& colour)> picture;
  /// The text to store in the state: reports of finished frames, followed by filtered frames that
  /// are not yet written.
  std::function<std::string(std::span<const FrameReport> frames)> save_log;
  /// Parses a text of save_log. If empty, reports() lacks the frames of an earlier run.
  std::function<Result<std::vector<FrameReport>>(const std::string& log)> restore_log;
};

/// How a run ended.
struct SequenceEnd {
  /// kCancelled if keep_going ended it; errors of reading, denoising and writing, naming the file.
  Status status;
  /// The result of saving the state, if the run stopped before its last frame.
  Status save_status;
  /// Whether there is a state on disk, saved now or earlier.
  bool can_resume = false;
  size_t resumes_at = 0;  ///< first file that a resumed run writes
};

/// Denoises one sequence. Not thread-safe; runs on all threads of the pool.
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
  /// As above, with a device that is opened after the first file was read: opening a device can
  /// take seconds, and errors of the file are reported first.
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
  /// Number of frames with complete files; before Run(), of the resumed run.
  size_t finished() const;
  /// Number of frames that Run() accumulates backward, counting repetitions.
  size_t look_ahead_steps() const;

  /// Denoises and writes the unfinished frames. Call it once.
  SequenceEnd Run();
  /// Removes the state, if it exists. Run() leaves the removal to the caller, whose work after the
  /// last frame can fail too.
  void RemoveState();

  const std::vector<FrameReport>& reports() const;  ///< of finished frames
  /// Whether motion missing in the files is derived from cameras or guides.
  bool derives_motion() const;
  /// Whether a frame had motion other than zero.
  bool motion_was_seen() const;
  size_t memory_bytes() const;         ///< of the denoisers, at most
  DeviceMemory device_memory() const;  ///< the part of memory_bytes() on a device

  struct Impl;  ///< of the module sequence

 private:
  explicit SequenceDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
