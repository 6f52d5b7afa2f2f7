// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/clock.h"
#include "study/harness/make_solver.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

// Cost of reading the clock. It is about a tenth of a small body's substep, so it is subtracted.
double cost_of_asking_s() {
  static const double cost_s = [] {
    constexpr int kTimes = 2000;
    const double start = thread_cpu_s();
    for (int i = 0; i < kTimes; ++i) thread_cpu_s();
    return (thread_cpu_s() - start) / kTimes;
  }();
  return cost_s;
}

}  // namespace

Result<Stage> Stage::make(const Setup& setup, ElasticBodyDescription description) {
  description.cells = setup.cells;
  auto body = make_study_body(setup, description);
  if (!body) return body.error();
  Stage stage;
  stage.body_ = std::move(*body);
  stage.rest_ = std::move(description.particles);
  stage.rate_hz_ = setup.rate_hz;
  stage.scene_substeps_ = setup.substeps;
  stage.start_ns_ = now_ns();
  return stage;
}

void Stage::step() {
  SubstepContext context;
  context.start_s = time_s();
  context.duration_s = substep_s();
  context.gravity_m_s2 = gravity_m_s2;
  context.colliders = colliders;
  context.forces = forces;
  body_->substep(context);
  ++substeps_;
}

void Stage::frame() {
  const double start = thread_cpu_s();
  for (int i = 0; i < scene_substeps_; ++i) step();
  body_->end_frame(frame_s());
  cpu_s_ += thread_cpu_s() - start;
  ++frames_;
}

void Stage::run(double seconds) {
  for (long i = std::lround(seconds * rate_hz_); i > 0; --i) frame();
}

void Stage::run(double seconds, const std::function<void()>& before, const std::function<void()>& after,
                int every) {
  const double asking_s = cost_of_asking_s();
  for (long i = std::max(1L, std::lround(seconds * rate_hz_)); i > 0; --i) {
    for (int k = 0; k < scene_substeps_; ++k) {
      if (before) before();
      const double start = thread_cpu_s();
      step();
      if (k + 1 == scene_substeps_) body_->end_frame(frame_s());
      cpu_s_ += std::max(0.0, thread_cpu_s() - start - asking_s);
      if (after && substeps_ % static_cast<uint64_t>(every) == 0) after();
    }
    ++frames_;
  }
}

int Stage::sampling_interval(double period_s) const {
  return std::max(1, static_cast<int>(period_s / (60.0 * substep_s())));
}

void Stage::measure_unforced_cost() {
  constexpr double kMinTiming_s = 0.005;
  const uint64_t frames = frames_;
  const double simulated_s = time_s();
  forces.clear();
  cpu_s_ = 0.0;
  int timed = 0;
  for (; timed < 8 || (cpu_s_ < kMinTiming_s && timed < 500); ++timed) frame();
  cpu_s_ *= static_cast<double>(frames) / timed;
  frames_ = frames;
  substeps_ = static_cast<uint64_t>(std::llround(simulated_s / substep_s()));
}

bool Stage::finite() const {
  for (const ParticleState& particle : body_->particles()) {
    if (!particle.position_m.allFinite()) return false;
  }
  return true;
}

Cost Stage::cost() const {
  Cost cost;
  cost.cpu_s = cpu_s_;
  cost.wall_s = seconds_from_ns(now_ns() - start_ns_);
  cost.simulated_s = static_cast<double>(frames_) * frame_s();
  cost.substeps = frames_ * static_cast<uint64_t>(body_->accuracy().substeps);
  cost.frames = frames_;
  return cost;
}

Outcome Stage::finish(std::vector<Measurement> measurements) const {
  Outcome outcome;
  outcome.measurements = std::move(measurements);
  outcome.cost = cost();
  outcome.accuracy = body_->accuracy();
  outcome.finite = finite();
  if (!outcome.finite) {
    for (Measurement& m : outcome.measurements) m.error = std::numeric_limits<double>::infinity();
  }
  return outcome;
}

void add_traction(std::vector<PointForce>& forces, double x_m, double width_m, const Vector3d& traction_pa,
                  int across) {
  const Vector3d force_n = traction_pa * (width_m * width_m / (across * across));
  for (int j = 0; j < across; ++j) {
    for (int k = 0; k < across; ++k) {
      forces.push_back(
          {{x_m, ((j + 0.5) / across - 0.5) * width_m, ((k + 0.5) / across - 0.5) * width_m}, force_n});
    }
  }
}

int points_across(const Setup& setup, const ElasticBody& body, double width_m) {
  const bool cells = setup.engine == Engine::Cells || setup.engine == Engine::Bullet;
  const double width = cells ? body.accuracy().cell_width_m : setup.spacing_m;
  return std::max(1, static_cast<int>(std::lround(width_m / width)));
}

}  // namespace livegs::study
