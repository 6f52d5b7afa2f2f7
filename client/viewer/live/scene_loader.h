// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/result.h"
#include "viewer/live/connected_scene.h"

namespace livegs {

// Joins a server and loads its scene, completely or until each object has a first picture (JoinOptions), on
// an internal thread. The caller can show the progress and cancel. Use on the thread that created it.
class SceneLoader {
 public:
  using MakeRenderer = std::function<Result<std::unique_ptr<SplatRenderer>>()>;
  // Checks whether the scene can be shown, before anything is fetched.
  using Check = std::function<Result<void>(const JoinedScene& scene)>;
  // `make_renderer` and `check` are called on the internal thread.
  SceneLoader(JoinOptions options, MakeRenderer make_renderer, Check check = {});
  ~SceneLoader();  // cancels; waits at most for the decoding of one asset

  // Waits up to `seconds`; returns whether loading is done.
  bool wait(double seconds);
  struct Progress {
    std::string text;  // "cup: 3.1 of 12.4 MB"
    double share = 0;  // fraction of all bytes, 0..1
  };
  Progress progress() const;
  // Waits until loading is done. Call once.
  Result<std::unique_ptr<ConnectedScene>> take();

 private:
  Result<std::unique_ptr<ConnectedScene>> load();
  Result<void> show_scene(ConnectedScene& live) const;

  const JoinOptions options_;
  const MakeRenderer make_renderer_;
  const Check check_;
  std::stop_source stop_;

  mutable std::mutex mutex_;  // guards the next three
  std::condition_variable changed_;
  const ConnectedScene* loading_ = nullptr;  // while its assets load
  std::optional<Result<std::unique_ptr<ConnectedScene>>> done_;
  std::thread thread_;
};

}  // namespace livegs
