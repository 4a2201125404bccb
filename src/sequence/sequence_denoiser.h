// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The implementation of SequenceDenoiser: the Job of its FrameLoop, and the state on disk.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sequence/filter.h"
#include "sequence/finished_files.h"
#include "sequence/frame_loop.h"
#include "sequence/reader.h"
#include "sequence/resume_state.h"
#include "stillray/sequence.h"

namespace stillray {

/// A frame from reading its file until its output is written.
struct SequencePicture {
  const SequenceFile* names = nullptr;
  FrameReport report;
  std::string bytes;    ///< of the input
  StoredPixels stored;  ///< of the input
  Image3 colour;
  std::vector<NewLayer> layers;
};

/// A frame that an earlier run filtered but could not write.
struct WaitingFrame {
  UnwrittenFrame frame;
  FrameReport report;
};

struct SequenceDenoiser::Impl {
  Impl(const SequenceOptions& chosen, const SequenceHooks& calls);

  Status Prepare(const OpenDevice& open);
  SequenceEnd Run();
  void RemoveState();

  // Interface of FrameLoop.
  using Picture = SequencePicture;
  Status Make(size_t at, Picture* picture);
  Status Write(Picture* picture);
  Status Finish(Picture* picture, const WriteResult& written);
  bool CanSave() const;
  Status Save(std::span<Picture* const> unwritten);

  Status ApplyEffects(const SequenceFile& file, const SequenceFrame& frame, Picture* picture) const;

  // Steps of Prepare.
  void TakeWindowOfResumedRun();
  Status ReadFirstFile();
  Status ChooseMotion(const ExrImage& first);
  void ChooseOverlap();
  Status ChooseFutures(size_t* held);
  std::string Fingerprint(const Device& device) const;
  Status Resume();
  Status CheckFormerInputs(const ResumeState& saved) const;
  Status Restore(ResumeState saved);

  Status LookAhead(const SequenceFile& file);
  void TakeFirstWaiting(Picture* picture);
  std::vector<FrameReport> AllReports(std::span<Picture* const> unwritten) const;
  void NarrowWindow(const std::string& why);
  void Note(const std::string& text) const;
  void ReportFallBack();
  void NoteDerivedMotion(const FrameReport& report);
  void NoteMissingImages(const FrameReport& report);
  void NoteAntialiasing(const ExrImage& first) const;
  SequenceView View() { return {options, layout, motion, cache ? &*cache : nullptr}; }
  std::string StatePath() const { return ResumePath(folder, key); }

  SequenceOptions options;
  SequenceHooks hooks;
  AovLayout layout;
  MotionPlan motion;
  std::optional<MotionCache> cache;
  Settings settings;
  ExrExtent extent;
  std::optional<SequenceFilter> filter;
  size_t futures_held = 0;
  std::optional<FrameReader> reader;
  FrameLoop<Impl>* loop = nullptr;  ///< during Run()
  bool fell_back = false;
  bool noted_motion = false;  ///< the user was informed that motion of the files is not used
  bool noted_images = false;  ///< the user was informed that virtual images lack guides or motion
  size_t most_memory = 0;
  Clock::time_point last_end;  ///< when the previous frame was finished

  std::string folder;
  std::string key;  ///< of the state
  std::string fingerprint;
  bool has_old_state = false;  ///< a state of the same options exists and is not resumed
  bool resumed = false;
  std::optional<size_t> saved_at;  ///< finished frames when the state on disk was saved
  size_t finished = 0;
  size_t made = 0;  ///< number of frames that are filtered, or come from `waiting`
  std::vector<WaitingFrame> waiting;
  std::vector<FrameReport> reports;   ///< of finished frames
  std::vector<FinishedFile> inputs;   ///< of frames in the history
  std::vector<FinishedFile> outputs;  ///< of finished frames
  size_t synced = 0;                  ///< outputs flushed to the disk
};

}  // namespace stillray
