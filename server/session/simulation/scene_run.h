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

// A scene and the hands that touch it, tick by tick: from the same scenes, the same actions give the same
// bits, whether they come from clients or from a recording. One thread.
class SceneRun {
 public:
  explicit SceneRun(Scene scene);

  // This scene takes the place of the one that runs, at the beginning of the next advance(). Its ids are all
  // new; ticks and the clients' simulated time go on.
  void replace(Scene scene);
  // One tick. The caller fills in the RunStatus.
  TickResult advance(const TickActions& actions);

  Scene& scene() { return scene_; }
  const Scene& scene() const { return scene_; }
  uint64_t tick() const {
    return tick_;
  }  // as clients know it: those of scenes before, and halted ones, count
  uint64_t shots() const { return controls_.shots(); }
  bool holding(SessionNumber session) const { return controls_.holding(session); }

 private:
  void apply(const TickActions& actions);
  void note_changes(TickResult& tick);

  Scene scene_;
  HandControls controls_;
  std::map<SessionNumber, uint64_t> applied_;  // newest sequence applied
  uint64_t tick_;
  int64_t simulated_before_ns_ = 0;  // in scenes before
  std::vector<uint32_t> replaced_;   // ids of the scene whose place was taken in this tick
  bool scene_is_new_ = false;
  int64_t simulated_ns_ = 0;      // since the first scene, of the last tick
  std::set<uint32_t> known_ids_;  // objects that ticks so far have announced
};

}  // namespace livegs
