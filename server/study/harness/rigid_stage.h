// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// A solver with a rigid scene's clock. Counts the processor time of stepping on the calling thread, and
// nothing else: for costs that can be compared, set_thread_count(1) first. Watches for bodies that are no
// numbers or fly off.
class RigidStage {
 public:
  // Fails where the engine cannot run the scene, with its reason.
  static Result<RigidStage> make(const RigidSetup& setup, const RigidConditions& conditions = {});

  RigidSolver& solver() { return *solver_; }
  // Adds a part; what the solver refuses ends the run as NonFinite does.
  void add(const RigidPart& part);

  double time_s() const { return static_cast<double>(frames_) / rate_hz_; }
  double frame_s() const { return 1.0 / rate_hz_; }
  const std::vector<RigidMotion>& motions() const { return motions_; }

  // The whole frames that `seconds` rounds to, `after` called behind each; stops early when something went
  // wrong.
  void run(double seconds, const std::function<void()>& after = nullptr);
  void mark(RunEnd end) { end_ = end; }
  bool ok() const { return end_ == RunEnd::Ok; }

  // Adds another run's cost and end: of scenes that are several runs.
  void include(const RigidStage& other);
  RigidOutcome finish(std::vector<Measurement> measurements) const;

 private:
  RigidStage() = default;
  void check_motions();

  std::unique_ptr<RigidSolver> solver_;
  std::vector<RigidMotion> motions_;
  double rate_hz_ = 60.0;
  int substeps_ = 4;
  uint64_t frames_ = 0;
  RunEnd end_ = RunEnd::Ok;
  Cost cost_;
};

}  // namespace livegs::study
