// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// One body with what acts on it and the scene's clock. Counts the processor time of stepping, and nothing
// else.
class Stage {
 public:
  // Fails where the engine cannot make the body, with its reason.
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
  // The whole frames that `seconds` rounds to.
  void run(double seconds);
  // Frames until `seconds` have passed, with `before` called ahead of every substep of the scene and `after`
  // behind each that completes a multiple of `every`.
  void run(double seconds, const std::function<void()>& before, const std::function<void()>& after,
           int every = 1);
  // Substeps of the scene between two looks at something that swings with `period_s`: 60 looks a period, or
  // all.
  int sampling_interval(double period_s) const;
  // Charges the whole run at the price of frames without the point forces, which are the study's own and
  // dear: each is found in the lattice again every substep. Runs some such frames, so measure first. Not for
  // Bullet, whose iterations depend on what acts.
  void measure_unforced_cost();

  bool finite() const;
  Cost cost() const;
  // What every scene ends with. Errors become infinite when the body is not finite.
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

// Equal forces on a regular grid of points over a face: a uniform traction. `across` points a side; as many
// as cells is exact for eight-node cells. The face is square with the edge `width_m`, normal to x, at `x_m`.
void add_traction(std::vector<PointForce>& forces, double x_m, double width_m,
                  const Eigen::Vector3d& traction_pa, int across);
// Points a side for the body as it was made.
int points_across(const Setup& setup, const ElasticBody& body, double width_m);

}  // namespace livegs::study
