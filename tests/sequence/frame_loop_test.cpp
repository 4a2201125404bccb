// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/frame_loop.h"

#include <atomic>
#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::frame_loop_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Counts instead of pictures, with injected failures.
class FakeJob {
 public:
  struct Picture {
    int frame = -1;
  };

  Status Make(size_t at, Picture* picture) {
    const int frame = static_cast<int>(at);
    if (frame == make_fails) {
      return Status::BadData("make");
    }
    if (poll) {
      STILLRAY_RETURN_IF_ERROR(poll());
    }
    // The picture of the frame before last has been written, or is the first of its place.
    EXPECT_TRUE(picture->frame == -1 || finished.count(picture->frame) == 1);
    if (meets_writer && frame > 0) {
      Wait(&writing);  // the frame before is being written now
      made_beside = true;
    }
    picture->frame = frame;
    made.push_back(frame);
    history = frame + 1;
    return Status::Ok();
  }

  Status Write(Picture* picture) {
    writer = std::this_thread::get_id();
    if (meets_writer && picture->frame == 0) {
      writing = true;
      Wait(&made_beside);
    }
    if (picture->frame == write_fails) {
      return Status::Io("write");
    }
    written.push_back(picture->frame);
    return Status::Ok();
  }

  Status Finish(Picture* picture, const WriteResult& result) {
    STILLRAY_RETURN_IF_ERROR(result.status);
    if (picture->frame == finish_fails) {
      return Status::Io("finish");
    }
    EXPECT_GE(result.milliseconds, 0);
    finished.insert(picture->frame);
    order.push_back(picture->frame);
    return Status::Ok();
  }

  bool CanSave() const { return can_save; }

  Status Save(std::span<Picture* const> unwritten) {
    ++saves;
    saved_unwritten.clear();
    for (const Picture* picture : unwritten) {
      saved_unwritten.push_back(picture->frame);
    }
    saved_history = history;
    return save_fails ? Status::Io("save") : Status::Ok();
  }

  int make_fails = -1;
  int write_fails = -1;
  int finish_fails = -1;
  bool save_fails = false;
  bool can_save = true;
  bool meets_writer = false;
  std::function<Status()> poll;

  std::vector<int> made;
  std::vector<int> written;
  std::vector<int> order;
  std::set<int> finished;
  std::thread::id writer;
  int history = 0;
  int saves = 0;
  int saved_history = -1;
  std::vector<int> saved_unwritten;
  std::atomic<bool> writing{false};
  std::atomic<bool> made_beside{false};

 private:
  static void Wait(const std::atomic<bool>* flag) {
    const Clock::time_point limit = Clock::now() + std::chrono::seconds(20);
    while (!*flag) {
      ASSERT_LT(Clock::now(), limit) << "making and writing do not overlap";
      std::this_thread::yield();
    }
  }
};

LoopOptions Frames(size_t begin, size_t end, bool overlap) {
  LoopOptions options;
  options.begin = begin;
  options.end = end;
  options.overlap = overlap;
  return options;
}

LoopEnd RunLoop(FakeJob* job, LoopOptions options) {
  return FrameLoop<FakeJob>(job, std::move(options)).Run();
}

class FrameLoops : public ::testing::TestWithParam<bool> {};

TEST_P(FrameLoops, MakesWritesAndFinishesEveryFrameInOrder) {
  FakeJob job;
  const LoopEnd end = RunLoop(&job, Frames(2, 7, GetParam()));
  EXPECT_TRUE(end.status.ok());
  EXPECT_FALSE(end.saved);
  EXPECT_THAT(job.made, ElementsAre(2, 3, 4, 5, 6));
  EXPECT_EQ(job.written, job.made);
  EXPECT_EQ(job.order, job.made);
  EXPECT_EQ(job.saves, 0);
  EXPECT_EQ(job.writer == std::this_thread::get_id(), !GetParam());
}

TEST_P(FrameLoops, NoFramesAreNoError) {
  FakeJob job;
  EXPECT_TRUE(RunLoop(&job, Frames(3, 3, GetParam())).status.ok());
  EXPECT_THAT(job.made, IsEmpty());
}

TEST_P(FrameLoops, AFrameThatCannotBeMadeLeavesTheOnesBeforeItFinished) {
  FakeJob job;
  job.make_fails = 3;
  const LoopEnd end = RunLoop(&job, Frames(0, 6, GetParam()));
  EXPECT_EQ(end.status.message(), "make");
  EXPECT_THAT(job.order, ElementsAre(0, 1, 2));
  EXPECT_TRUE(end.saved);
  EXPECT_THAT(job.saved_unwritten, IsEmpty());
  EXPECT_EQ(job.saved_history, 3);
}

// With overlap the next frame is in the history too when the error is seen.
TEST_P(FrameLoops, FramesThatCannotBeWrittenAreHandedToTheState) {
  FakeJob job;
  job.write_fails = 2;
  const LoopEnd end = RunLoop(&job, Frames(0, 6, GetParam()));
  EXPECT_EQ(end.status.message(), "write");
  EXPECT_THAT(job.order, ElementsAre(0, 1));
  EXPECT_TRUE(end.saved);
  if (GetParam()) {
    EXPECT_THAT(job.saved_unwritten, ElementsAre(2, 3));
  } else {
    EXPECT_THAT(job.saved_unwritten, ElementsAre(2));
  }
  EXPECT_EQ(job.saved_history, job.saved_unwritten.back() + 1);
}

TEST_P(FrameLoops, TheLastFrameThatCannotBeWrittenIsHandedToTheState) {
  FakeJob job;
  job.write_fails = 3;
  const LoopEnd end = RunLoop(&job, Frames(0, 4, GetParam()));
  EXPECT_EQ(end.status.message(), "write");
  EXPECT_THAT(job.saved_unwritten, ElementsAre(3));
}

TEST_P(FrameLoops, AFrameThatIsNotFinishedCountsAsUnwritten) {
  FakeJob job;
  job.finish_fails = 1;
  const LoopEnd end = RunLoop(&job, Frames(0, 2, GetParam()));
  EXPECT_EQ(end.status.message(), "finish");
  EXPECT_THAT(job.saved_unwritten, ElementsAre(1));
}

// Both fail; the frame that comes first is named.
TEST_P(FrameLoops, TheErrorOfTheEarlierFrameComesFirst) {
  FakeJob job;
  job.write_fails = 1;
  job.make_fails = 2;
  EXPECT_EQ(RunLoop(&job, Frames(0, 6, GetParam())).status.message(), "write");
}

TEST_P(FrameLoops, AStateThatCannotBeSavedIsReported) {
  FakeJob job;
  job.make_fails = 1;
  job.save_fails = true;
  const LoopEnd end = RunLoop(&job, Frames(0, 6, GetParam()));
  EXPECT_EQ(end.status.message(), "make");
  EXPECT_FALSE(end.saved);
  EXPECT_EQ(end.save_status.message(), "save");
}

TEST_P(FrameLoops, AHistoryThatIsNotWholeIsNotSaved) {
  FakeJob job;
  job.make_fails = 1;
  job.can_save = false;
  const LoopEnd end = RunLoop(&job, Frames(0, 6, GetParam()));
  EXPECT_FALSE(end.saved);
  EXPECT_TRUE(end.save_status.ok());
  EXPECT_EQ(job.saves, 0);
}

TEST_P(FrameLoops, StopsBetweenFramesAndFinishesTheOneThatIsWritten) {
  FakeJob job;
  LoopOptions options = Frames(0, 100, GetParam());
  options.keep_going = [&job] { return job.made.size() < 3; };
  const LoopEnd end = RunLoop(&job, std::move(options));
  EXPECT_EQ(end.status.code(), StatusCode::kCancelled);
  EXPECT_THAT(job.made, ElementsAre(0, 1, 2));
  EXPECT_THAT(job.order, ElementsAre(0, 1, 2));
  EXPECT_TRUE(end.saved);
  EXPECT_THAT(job.saved_unwritten, IsEmpty());
}

// Ten seconds a frame: the state is saved behind the fourth frame, and 31 s after that.
TEST_P(FrameLoops, SavesTheStateEveryThirtySeconds) {
  FakeJob job;
  Clock::time_point time;
  std::vector<size_t> saved_at;
  LoopOptions options = Frames(0, 12, GetParam());
  options.now = [&] { return time; };
  options.keep_going = [&] {
    time += std::chrono::seconds(10);
    if (job.saves > static_cast<int>(saved_at.size())) {
      EXPECT_THAT(job.saved_unwritten, IsEmpty()) << "all frames are written by then";
      saved_at.push_back(job.order.size());
    }
    return true;
  };
  EXPECT_TRUE(RunLoop(&job, std::move(options)).status.ok());
  EXPECT_THAT(saved_at, ElementsAre(4, 8));
}

TEST_P(FrameLoops, AnAutosaveThatFailsStopsTheRun) {
  FakeJob job;
  job.save_fails = true;
  LoopOptions options = Frames(0, 12, GetParam());
  options.save_interval = std::chrono::seconds(-1);  // behind every frame
  const LoopEnd end = RunLoop(&job, std::move(options));
  EXPECT_EQ(end.status.message(), "save");
  EXPECT_THAT(job.order, ElementsAre(0));
}

INSTANTIATE_TEST_SUITE_P(Overlap, FrameLoops, ::testing::Bool(), [](const auto& info) {
  return info.param ? "OnTwoThreads" : "OnOneThread";
});

TEST(FrameLoop, WritesAFrameWhileTheNextIsMade) {
  FakeJob job;
  job.meets_writer = true;
  EXPECT_TRUE(RunLoop(&job, Frames(0, 2, true)).status.ok());
  EXPECT_THAT(job.order, ElementsAre(0, 1));
}

// A frame that takes long need not hold back the report of the one before.
TEST(FrameLoop, PollFinishesAFrameThatIsReady) {
  FakeJob job;
  FrameLoop<FakeJob> loop(&job, Frames(0, 2, true));
  job.poll = [&] {
    const Clock::time_point limit = Clock::now() + std::chrono::seconds(20);
    while (job.made.size() == 1 && job.order.empty() && Clock::now() < limit) {
      STILLRAY_RETURN_IF_ERROR(loop.Poll());
    }
    EXPECT_EQ(job.order.size(), job.made.size());
    return Status::Ok();
  };
  EXPECT_TRUE(loop.Run().status.ok());
  EXPECT_THAT(job.order, ElementsAre(0, 1));
}

}  // namespace
}  // namespace stillray::frame_loop_test
