// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Lowers the priority of background work, so that it does not delay the interface.
#pragma once

#include <memory>

namespace stillray::view {

/// During its lifetime, the constructing thread runs at a lower priority than the rest of the
/// program, and so do, from then on, the pool threads that help it: the interface and the threads
/// of its OpenGL driver get a processor as soon as they need one. Does nothing on systems without
/// thread priorities.
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
