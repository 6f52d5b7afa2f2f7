// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_stage.h"

#include <cmath>
#include <limits>

#include "core/clock.h"
#include "core/log.h"
#include "study/harness/make_solver.h"

namespace livegs::study {
namespace {

// Limits beyond any regular motion of the scenes; a run that exceeds them has exploded.
constexpr double kMaxDistance_m = 1e3, kMaxSpeed_m_s = 100.0;

}  // namespace

Result<RigidStage> RigidStage::make(const RigidSetup& setup, const RigidConditions& conditions) {
  auto solver = make_rigid_solver(setup, conditions);
  if (!solver) return solver.error();
  RigidStage stage;
  stage.solver_ = std::move(*solver);
  stage.rate_hz_ = setup.rate_hz;
  stage.substeps_ = setup.substeps;
  return stage;
}

void RigidStage::add(const RigidPart& part) {
  if (auto added = solver_->add(part); !added) {
    log_error("rigid scene: %s", added.error().message.c_str());
    end_ = RunEnd::NonFinite;
  }
  motions_ = solver_->motions();
}

void RigidStage::check_motions() {
  motions_ = solver_->motions();
  for (const RigidMotion& motion : motions_) {
    const Eigen::Vector3d& at = motion.world_from_part.position_m;
    if (!at.allFinite() || !motion.velocity_m_s.allFinite() || !motion.angular_velocity_rad_s.allFinite()) {
      end_ = RunEnd::NonFinite;
    } else if (at.norm() > kMaxDistance_m || motion.velocity_m_s.norm() > kMaxSpeed_m_s) {
      if (end_ == RunEnd::Ok) end_ = RunEnd::Exploded;
    }
  }
}

void RigidStage::run(double seconds, const std::function<void()>& after) {
  const int64_t start_ns = now_ns();
  for (long i = std::lround(seconds * rate_hz_); i > 0 && ok(); --i) {
    const double start = thread_cpu_s();
    solver_->frame();
    cost_.cpu_s += thread_cpu_s() - start;
    ++frames_;
    ++cost_.frames;
    cost_.substeps += static_cast<uint64_t>(substeps_);
    cost_.simulated_s += frame_s();
    check_motions();
    if (after && ok()) after();
  }
  cost_.wall_s += seconds_from_ns(now_ns() - start_ns);
}

void RigidStage::include(const RigidStage& other) {
  cost_.cpu_s += other.cost_.cpu_s;
  cost_.wall_s += other.cost_.wall_s;
  cost_.simulated_s += other.cost_.simulated_s;
  cost_.substeps += other.cost_.substeps;
  cost_.frames += other.cost_.frames;
  if (ok()) end_ = other.end_;
}

RigidOutcome RigidStage::finish(std::vector<Measurement> measurements) const {
  if (!ok()) {
    for (Measurement& measurement : measurements) measurement.error = std::numeric_limits<double>::infinity();
  }
  return {std::move(measurements), cost_, motions_.size(), end_};
}

}  // namespace livegs::study
