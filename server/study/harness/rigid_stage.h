// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// A solver with the clock of a rigid scene. Counts only the processor time of steps on the calling thread;
// for comparable costs, call set_thread_count(1) first. Detects bodies that are NaN or fly away.
class RigidStage {
 public:
  // Creates a stage. An error with the reason if the engine does not support the scene.
  static Result<RigidStage> make(const RigidSetup& setup, const RigidConditions& conditions = {});

  RigidSolver& solver() { return *solver_; }
  // Adds a part. A part that the solver rejects ends the run with NonFinite.
  void add(const RigidPart& part);

  double time_s() const { return static_cast<double>(frames_) / rate_hz_; }
  double frame_s() const { return 1.0 / rate_hz_; }
  const std::vector<RigidMotion>& motions() const { return motions_; }

  // Runs `seconds`, rounded to whole frames, and calls `after` after each. Stops early after a failure.
  void run(double seconds, const std::function<void()>& after = nullptr);
  void mark(RunEnd end) { end_ = end; }
  bool ok() const { return end_ == RunEnd::Ok; }

  // Adds the cost and the end of another run, for scenes with several runs.
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
