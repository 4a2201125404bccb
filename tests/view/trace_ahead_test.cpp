// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/trace_ahead.h"

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

namespace stillray::trace_ahead_test {
namespace {

/// Traces until it is cancelled.
Status Endless(const RenderProgress& going_on) {
  while (going_on(0.25)) {
    std::this_thread::yield();
  }
  return Status::Cancelled();
}

TEST(TraceAhead, TracesOnAnotherThreadAndReturnsTheResult) {
  TraceAhead ahead;
  EXPECT_FALSE(ahead.under_way());
  std::thread::id thread;
  ahead.Start([&](const RenderProgress& going_on) {
    thread = std::this_thread::get_id();
    EXPECT_TRUE(going_on(1));
    return Status::Ok();
  });
  EXPECT_TRUE(ahead.under_way());
  EXPECT_TRUE(ahead.Take({}).ok());
  EXPECT_NE(thread, std::this_thread::get_id());
  EXPECT_FALSE(ahead.under_way());
  // One after the other; errors are those of the task.
  ahead.Start([](const RenderProgress&) { return Status::OutOfMemory("full"); });
  EXPECT_EQ(ahead.Take({}).code(), StatusCode::kOutOfMemory);
  ahead.Start([](const RenderProgress&) -> Status { throw std::runtime_error("broken"); });
  EXPECT_THROW(static_cast<void>(ahead.Take({})), std::runtime_error);
}

TEST(TraceAhead, ReportsProgressToTheThreadThatWaits) {
  TraceAhead ahead;
  std::atomic<bool> seen = false;
  ahead.Start([&](const RenderProgress& going_on) {
    while (!seen && going_on(0.5)) {
      std::this_thread::yield();
    }
    return Status::Ok();
  });
  const std::thread::id own = std::this_thread::get_id();
  EXPECT_TRUE(ahead
                  .Take([&](double fraction) {
                    EXPECT_EQ(std::this_thread::get_id(), own);
                    seen = seen || fraction == 0.5;
                    return true;
                  })
                  .ok());
  EXPECT_TRUE(seen);
}

TEST(TraceAhead, EndsWhenCancelled) {
  TraceAhead ahead;
  ahead.Start(Endless);
  int asked = 0;
  EXPECT_EQ(ahead.Take([&](double) { return ++asked < 3; }).code(), StatusCode::kCancelled);
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(ahead.under_way());
  ahead.Cancel();  // nothing is under way
  ahead.Start(Endless);
  ahead.Cancel();
  EXPECT_FALSE(ahead.under_way());
  const auto left = std::make_unique<TraceAhead>();
  left->Start(Endless);  // ends with its object
}

}  // namespace
}  // namespace stillray::trace_ahead_test
