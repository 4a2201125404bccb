// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Work that must not be in the way of the interface.
#pragma once

#include <memory>

namespace stillray::view {

/// While one lives, the thread that made it and the threads of the pool that help it run at a lower
/// priority than the rest of the program, from then on: the interface and the threads of its OpenGL
/// driver get a processor as soon as they want one, whatever is being traced. Pool threads keep the
/// lower priority. Does nothing where the system has no priorities of threads.
class BackgroundWork {
 public:
  BackgroundWork();
  ~BackgroundWork();
  BackgroundWork(const BackgroundWork&) = delete;
  BackgroundWork& operator=(const BackgroundWork&) = delete;

 private:
  struct Observer;
  std::unique_ptr<Observer> observer_;
};

}  // namespace stillray::view
