// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

// What clients may do to the physics of a running scene. Any thread; no call waits for the simulation or for
// a model.
class AnalysisControl {
 public:
  virtual ~AnalysisControl() = default;

  // `progress` is called from the analysis's thread, one at a time, and returns false when nobody listens any
  // more; `ended` once, last, unless this fails. No names: every object whose behaviour is AUTO. A requested
  // `stop` ends it, whether it has begun or waits: nothing more is asked, and what was accepted before stays.
  using Progress = std::function<bool(const v1::AnalysisProgress&)>;
  virtual Result<void> analyze(std::vector<std::string> objects, Progress progress,
                               std::function<void()> ended, std::stop_token stop = {}) = 0;

  // `name`: what a person calls it; empty: that stays.
  virtual Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics,
                                               const std::string& name = "") = 0;
  virtual Result<v1::PhysicsReply> accept_proposal(const std::string& object) = 0;
  virtual Result<v1::PhysicsReply> decline_proposal(const std::string& object) = 0;
  virtual Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo) = 0;

  // Told of every answer that waits for a person, now and from now on, and with nullptr when it waits no
  // longer: one call at a time, from any thread, which calls nothing of this. Empty: nobody is told any more
  // once this returns. Of the file its physics and analysis count.
  using Proposed = std::function<void(const std::string& object, const v1::PhysicsFile* proposal)>;
  virtual void watch_proposals(Proposed proposed) = 0;
};

}  // namespace livegs
