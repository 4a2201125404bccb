// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/scene_loader.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "core/clock.h"
#include "view/background.h"

namespace stillray::view {
namespace {

std::atomic<int> g_abandoned = 0;

SceneLoader::Outcome LoadNow(const SceneRequest& request, const ViewSettings& settings,
                             const Device& device, const LoadReport& report) {
  try {
    Result<LoadedScene> loaded = LoadForView(request, settings, report, device);
    if (!loaded.ok()) {
      return {loaded.status(), nullptr};
    }
    return {Status::Ok(), std::make_unique<LoadedScene>(std::move(loaded.value()))};
  } catch (const std::bad_alloc&) {
    return {Status::OutOfMemory("loading a scene: out of memory"), nullptr};
  } catch (const std::exception& error) {
    return {Status::Internal(fmt::format("loading a scene: {}", error.what())), nullptr};
  }
}

}  // namespace

/// State shared with the thread; outlives the loader if the thread does.
struct SceneLoader::Shared {
  struct Request {
    SceneRequest scene;
    ViewSettings settings;
    Device device;
  };

  mutable std::mutex mutex;
  std::condition_variable work;
  bool stop = false;
  bool busy = false;
  uint64_t requested = 0;  ///< number of the last request
  std::unique_ptr<Request> request;
  std::optional<Outcome> outcome;
  LoadState state;
  double began = 0;
  /// called with the mutex held, and never after the loader's end
  std::function<void(bool)> changed;
};

SceneLoader::SceneLoader(std::function<void(bool)> changed) : shared_(std::make_shared<Shared>()) {
  shared_->changed = std::move(changed);
  thread_ = std::thread([shared = shared_] { Run(shared); });
}

SceneLoader::~SceneLoader() {
  bool busy = false;
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->stop = true;
    shared_->changed = nullptr;
    busy = shared_->busy;
    g_abandoned += busy ? 1 : 0;
  }
  shared_->work.notify_all();
  if (busy) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void SceneLoader::Load(const SceneRequest& request, const ViewSettings& settings,
                       const Device& device) {
  auto wanted = std::make_unique<Shared::Request>(Shared::Request{request, settings, device});
  std::optional<Outcome> dropped;
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->request.swap(wanted);
    shared_->outcome.swap(dropped);
    ++shared_->requested;
    shared_->state = {true, {"waiting for the file before", 0, 1, -1}, 0};
    shared_->began = SecondsNow();
  }
  shared_->work.notify_all();
}

LoadState SceneLoader::state() const {
  const std::lock_guard lock(shared_->mutex);
  LoadState state = shared_->state;
  state.seconds = state.loading ? SecondsNow() - shared_->began : 0;
  return state;
}

std::optional<SceneLoader::Outcome> SceneLoader::Take() {
  const std::lock_guard lock(shared_->mutex);
  return std::exchange(shared_->outcome, std::nullopt);
}

int SceneLoader::abandoned() {
  return g_abandoned;
}

void SceneLoader::WaitForAbandoned() {
  for (int left = g_abandoned; left > 0; left = g_abandoned) {
    g_abandoned.wait(left);
  }
}

void SceneLoader::Run(const std::shared_ptr<Shared>& shared) {
  const BackgroundWork background;
  std::unique_lock lock(shared->mutex);
  while (true) {
    shared->work.wait(lock, [&] { return shared->stop || shared->request; });
    if (shared->stop) {
      return;
    }
    const std::unique_ptr<Shared::Request> request = std::move(shared->request);
    const uint64_t number = shared->requested;
    shared->busy = true;
    lock.unlock();
    // A later request or shutdown cancels loading at the next phase.
    const LoadReport report = [&](const LoadPhase& phase) {
      const std::lock_guard told(shared->mutex);
      const bool wanted = !shared->stop && number == shared->requested;
      if (wanted) {
        shared->state.phase = phase;
        shared->changed(false);
      }
      return wanted;
    };
    Outcome outcome = LoadNow(request->scene, request->settings, request->device, report);
    lock.lock();
    shared->busy = false;
    if (shared->stop) {
      lock.unlock();
      outcome = {};  // frees the scene before completion is signalled
      --g_abandoned;
      g_abandoned.notify_all();
      return;
    }
    if (number == shared->requested) {
      shared->state = {};
      shared->outcome = std::move(outcome);
      shared->changed(true);
    }
  }
}

}  // namespace stillray::view
