// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

// Physics operations of clients on a running scene. Any thread; no call blocks on the simulation or on a
// model.
class AnalysisControl {
 public:
  virtual ~AnalysisControl() = default;

  // Starts an analysis of the named objects, or of every object whose behaviour is AUTO. `progress` is called
  // on the analysis thread, one call at a time; it returns false when it needs no further calls. `ended` is
  // called once, after the last progress, unless this call fails. A requested `stop` ends a running or
  // waiting analysis: no further question is sent, and accepted answers stay.
  using Progress = std::function<bool(const v1::AnalysisProgress&)>;
  virtual Result<void> analyze(std::vector<std::string> objects, Progress progress,
                               std::function<void()> ended, std::stop_token stop = {}) = 0;

  // `name`: a name given by the user; empty keeps the current one.
  virtual Result<v1::PhysicsReply> set_physics(const std::string& object, const v1::Physics& physics,
                                               const std::string& name = "") = 0;
  virtual Result<v1::PhysicsReply> accept_proposal(const std::string& object) = 0;
  virtual Result<v1::PhysicsReply> decline_proposal(const std::string& object) = 0;
  virtual Result<v1::PhysicsReply> undo_physics(const std::string& object, bool redo) = 0;

  // Registers a callback for proposals that wait for a decision, current and future; nullptr when one no
  // longer waits. One call at a time, from any thread; the callback must not call this interface. An empty
  // function unregisters: no call is made after this returns. Only the physics and the analysis of the file
  // are set.
  using Proposed = std::function<void(const std::string& object, const v1::PhysicsFile* proposal)>;
  virtual void watch_proposals(Proposed proposed) = 0;
};

}  // namespace livegs
