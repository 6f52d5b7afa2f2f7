// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// One body with its loads and the clock of the scene. Counts only the processor time of steps.
class Stage {
 public:
  // Creates a stage. An error with the reason if the engine cannot create the body.
  static Result<Stage> make(const Setup& setup, ElasticBodyDescription description);

  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  std::vector<Collider> colliders;
  std::vector<PointForce> forces;

  ElasticBody& body() { return *body_; }
  const ElasticBody& body() const { return *body_; }
  const ParticleSet& rest() const { return rest_; }

  double time_s() const { return static_cast<double>(substeps_) * substep_s(); }
  double substep_s() const { return 1.0 / (rate_hz_ * scene_substeps_); }
  double frame_s() const { return 1.0 / rate_hz_; }

  void frame();
  // Runs `seconds`, rounded to whole frames.
  void run(double seconds);
  // Runs whole frames for at least `seconds`. Calls `before` before each substep of the scene, and `after`
  // after each that completes a multiple of `every`.
  void run(double seconds, const std::function<void()>& before, const std::function<void()>& after,
           int every = 1);
  // Substeps between samples of an oscillation of `period_s`: 60 samples per period, or every substep.
  int sampling_interval(double period_s) const;
  // Replaces the cost of the run by that of frames without point forces, which belong to the study and are
  // expensive: each is located in the lattice again in every substep. Runs such frames, so measure first. Not
  // for Bullet, whose iterations depend on the loads.
  void measure_unforced_cost();

  bool finite() const;
  Cost cost() const;
  // Ends a scene. Errors become infinite if the body is not finite.
  Outcome finish(std::vector<Measurement> measurements) const;

 private:
  Stage() = default;
  void step();

  std::unique_ptr<ElasticBody> body_;
  ParticleSet rest_;
  double rate_hz_ = 60.0;
  int scene_substeps_ = 4;
  uint64_t substeps_ = 0, frames_ = 0;
  double cpu_s_ = 0.0;
  int64_t start_ns_ = 0;
};

// Adds equal forces on a regular grid of points over a face: a uniform traction. `across` is the points per
// side; for eight-node cells, the number of cells is exact. The face is square with edge `width_m`, normal to
// x, at `x_m`.
void add_traction(std::vector<PointForce>& forces, double x_m, double width_m,
                  const Eigen::Vector3d& traction_pa, int across);
// Points per side for the body as created.
int points_across(const Setup& setup, const ElasticBody& body, double width_m);

}  // namespace livegs::study
