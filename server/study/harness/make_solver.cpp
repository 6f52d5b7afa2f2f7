// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/make_solver.h"

#include "baseline/elastic_solvers.h"
#include "study/peers/bullet_body.h"
#include "study/peers/bullet_rigid.h"
#include "study/peers/livegs_rigid.h"
#include "study/peers/ode_rigid.h"

namespace livegs::study {

Result<std::unique_ptr<ElasticBody>> make_study_body(const Setup& setup,
                                                     const ElasticBodyDescription& description) {
  switch (setup.engine) {
    case Engine::Cells:
      return make_elastic_body(description, setup.rate_hz, setup.substeps, false);
    case Engine::LivegsV1:
      return make_livegs_v1_body(description, setup.rate_hz, setup.substeps, false);
    case Engine::LivegsV1Steady:
      return make_livegs_v1_steady_body(description, setup.rate_hz, setup.substeps, false);
    case Engine::Bullet:
      break;
  }
  return make_bullet_body(description, setup.rate_hz, setup.substeps);
}

Result<std::unique_ptr<RigidSolver>> make_rigid_solver(const RigidSetup& setup,
                                                       const RigidConditions& conditions) {
  switch (setup.engine) {
    case RigidEngine::Livegs:
      return make_livegs_rigid(setup, conditions);
    case RigidEngine::Bullet:
      return make_bullet_rigid(setup, conditions);
    case RigidEngine::OdeQuick:
    case RigidEngine::Ode:
      break;
  }
  return make_ode_rigid(setup, conditions);
}

}  // namespace livegs::study
