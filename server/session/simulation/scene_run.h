// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "recording/tick_record.h"
#include "scene/scene.h"
#include "session/simulation/hand_controls.h"
#include "session/tick/tick_result.h"

namespace livegs {

// A scene and its hands, tick by tick. The same scenes and actions give the same bits, whether from clients
// or from a recording. One thread.
class SceneRun {
 public:
  explicit SceneRun(Scene scene);

  // Replaces the scene at the start of the next advance(). All ids are new; ticks and simulated time
  // continue.
  void replace(Scene scene);
  // Advances by one tick. The caller sets the RunStatus.
  TickResult advance(const TickActions& actions);

  Scene& scene() { return scene_; }
  const Scene& scene() const { return scene_; }
  uint64_t tick() const { return tick_; }  // including ticks of earlier scenes and paused ticks
  uint64_t shots() const { return controls_.shots(); }
  bool holding(SessionNumber session) const { return controls_.holding(session); }

 private:
  void apply(const TickActions& actions);
  void note_changes(TickResult& tick);

  Scene scene_;
  HandControls controls_;
  std::map<SessionNumber, uint64_t> applied_;  // newest sequence applied
  uint64_t tick_;
  int64_t simulated_before_ns_ = 0;  // simulated time of earlier scenes
  std::vector<uint32_t> replaced_;   // ids of the scene that was replaced in this tick
  bool scene_is_new_ = false;
  int64_t simulated_ns_ = 0;      // since the first scene, at the last tick
  std::set<uint32_t> known_ids_;  // objects announced by earlier ticks
};

}  // namespace livegs
