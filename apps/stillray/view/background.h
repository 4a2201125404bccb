// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Lowers the priority of background work, so that it does not delay the interface.
#pragma once

#include <memory>

namespace stillray::view {

/// During its lifetime, the constructing thread and, from then on, the pool threads that help it
/// run at a lower priority than all other threads, so that the interface and its OpenGL driver are
/// scheduled immediately. No effect on systems without thread priorities.
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
