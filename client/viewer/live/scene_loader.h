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

// Joins a server and loads what its scene shows, whole or until there is a first picture of each object
// (JoinOptions), on a thread of its own, so that whoever waits can show how far it is and give up. The
// functions are for the thread that made it.
class SceneLoader {
 public:
  using MakeRenderer = std::function<Result<std::unique_ptr<SplatRenderer>>()>;
  // Whether the scene is one that can be shown; asked before anything is fetched.
  using Check = std::function<Result<void>(const JoinedScene& scene)>;
  // `make_renderer` and `check` are called on that thread.
  SceneLoader(JoinOptions options, MakeRenderer make_renderer, Check check = {});
  ~SceneLoader();  // gives up what is not done yet, and waits no longer than an asset takes to be decoded

  // Waits so long at most; whether it is done.
  bool wait(double seconds);
  struct Progress {
    std::string text;  // "cup: 3.1 of 12.4 MB"
    double share = 0;  // of all bytes, 0..1
  };
  Progress progress() const;
  // Waits until it is done. Once.
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
  const ConnectedScene* loading_ = nullptr;  // while its assets come
  std::optional<Result<std::unique_ptr<ConnectedScene>>> done_;
  std::thread thread_;
};

}  // namespace livegs
