// SPDX-License-Identifier: Apache-2.0
// Cost of rigid scenes on one and two threads, compared with Bullet in the same run. Prints CSV: `rigid_bench
// > results/<machine>/rigid.csv`. Sleep is disabled. After 90 frames of 1/60 s for settling, 60 frames are
// timed. Bullet (single precision, 10 iterations) runs with one step per frame, as in games, and with four,
// as in this project. `ratio` is processor time relative to Bullet with the same number of steps.
//   pyramid            465 boxes
//   pile of fragments  eight cups of 25 separate pieces each, in a bin. Bullet uses convex hulls, which are
//                      cheaper.
//   mixed objects      balls, boxes, pieces of a cup and soft blocks, in a bin. Bullet uses rigid boxes for
//                      soft blocks, so this ratio includes the cost of deformation.
#include <Eigen/Eigenvalues>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>

#include "bench/support/time_of.h"
#include "core/log.h"
#include "core/parallel_for.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/world.h"
#include "prepare/prepare_pieces.h"
#include "server/geometry/fracture/fracture_shapes.h"
#include "study/harness/make_solver.h"
#include "study/harness/rigid_solver.h"

using namespace livegs;
using namespace livegs::study;
using Eigen::Vector3d;

namespace {

constexpr double kRate_hz = 60.0, kFriction = 0.6, kCup_kg = 0.3, kBin_m = 0.6;
constexpr int kWarmUp = 90, kTimed = 60;

struct Cup {
  Pose world_from_object;
  std::shared_ptr<const BreakablePieces> pieces;
};

struct BenchScene {
  const char* name = "";
  bool bin = false;              // walls around a square of kBin_m
  std::vector<RigidPart> parts;  // balls and boxes
  std::vector<RigidPart> soft;   // soft blocks in our World, rigid boxes in Bullet
  std::vector<Cup> cups;

  size_t bodies() const {
    size_t count = parts.size() + soft.size();
    for (const Cup& cup : cups) count += cup.pieces->pieces.size();
    return count;
  }
};

template <typename T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "%s\n", result.error().message.c_str());
  std::exit(1);
}
void must(const Result<void>& result) {
  if (result) return;
  std::fprintf(stderr, "%s\n", result.error().message.c_str());
  std::exit(1);
}

BenchScene pyramid() {
  BenchScene scene;
  scene.name = "pyramid";
  for (int row = 0; row < 30; ++row) {
    for (int i = 0; i < 30 - row; ++i) {
      RigidPart box;
      box.size_m.setConstant(0.1);
      box.friction = kFriction;
      box.world_from_part.position_m = {(i - 0.5 * (29 - row)) * 0.105, 0.05 + 0.1 * row, 0};
      scene.parts.push_back(box);
    }
  }
  return scene;
}

std::shared_ptr<const BreakablePieces> cut_cup(size_t pieces) {
  BreakableOptions options;
  options.piece_count = pieces;
  return must(prepare_pieces(livegs::testing::cup_mesh(32, 8), Fill::Solid, options));
}

double uniform(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

Eigen::Quaterniond any_turn(std::mt19937& random) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(
      6.0 * uniform(random), Vector3d(uniform(random) - 0.5, 1, uniform(random) - 0.5).normalized()));
}

// Two by two in layers.
BenchScene pile_of_fragments() {
  BenchScene scene;
  scene.name = "pile of fragments";
  scene.bin = true;
  std::mt19937 random(7);
  const auto pieces = cut_cup(25);
  for (int i = 0; i < 8; ++i) {
    Cup cup{{}, pieces};
    cup.world_from_object.position_m = {0.15 * (i % 2) - 0.075, 0.15 + 0.16 * (i / 4),
                                        0.15 * (i / 2 % 2) - 0.075};
    cup.world_from_object.orientation = any_turn(random);
    scene.cups.push_back(cup);
  }
  return scene;
}

// 12 balls, 14 boxes, 12 soft blocks and a cup of 12 pieces. Their cost depends on how they come to lie.
BenchScene mixed_objects(unsigned seed) {
  BenchScene scene;
  scene.name = "mixed objects";
  scene.bin = true;
  std::mt19937 random(seed);
  for (int i = 0; i < 38; ++i) {
    RigidPart part;
    part.mass_kg = 0.3;
    part.friction = kFriction;
    const int layer = i / 9, place = i % 9;
    part.world_from_part.position_m = {0.15 * (place % 3 - 1) + 0.02 * uniform(random), 0.08 + 0.14 * layer,
                                       0.15 * (place / 3 - 1) + 0.02 * uniform(random)};
    if (i % 3 == 0 && i < 36) {
      part.radius_m = 0.04;
    } else {
      part.size_m = Vector3d(0.06 + 0.04 * uniform(random), 0.05, 0.08);
      part.world_from_part.orientation = any_turn(random);
    }
    const bool soft = i % 3 == 1 && i < 36;
    (soft ? scene.soft : scene.parts).push_back(part);
  }
  Cup cup{{}, cut_cup(12)};
  cup.world_from_object.position_m = {0, 0.85, 0};
  scene.cups.push_back(cup);
  return scene;
}

// The floor and the walls of a bin, as half-spaces.
std::vector<Pose> planes_of(const BenchScene& scene) {
  std::vector<Pose> planes{Pose{}};
  for (int side = 0; scene.bin && side < 4; ++side) {
    const Vector3d inwards = Eigen::AngleAxisd(0.5 * M_PI * side, Vector3d::UnitY()) * Vector3d::UnitX();
    planes.push_back(
        {-0.5 * kBin_m * inwards, Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitY(), inwards)});
  }
  return planes;
}

void add_box_or_ball(World& world, uint32_t id, const RigidPart& part) {
  if (part.radius_m > 0.0) {
    BallDescription ball;
    ball.object_id = id;
    ball.position_m = part.world_from_part.position_m;
    ball.velocity_m_s.setZero();
    ball.radius_m = part.radius_m;
    ball.mass_kg = part.mass_kg;
    ball.friction = part.friction;
    ball.restitution = 0.0;
    return must(world.add_ball(ball));
  }
  RigidBodyDescription box;
  box.object_id = id;
  box.mesh = box_mesh(part.size_m);
  box.properties = solid_mass_properties(box.mesh);
  box.material.behavior = Behavior::Rigid;
  box.material.mass_kg = part.mass_kg;
  box.material.friction = part.friction;
  box.material.restitution = 0.0;
  box.world_from_object = part.world_from_part;
  must(world.add_rigid(box));
}

void add_soft_block(World& world, uint32_t id, const RigidPart& part) {
  ElasticBodyDescription block;
  block.object_id = id;
  block.particles = sample_particles(box_mesh(part.size_m), 6);
  block.material.behavior = Behavior::Elastic;
  block.material.mass_kg = part.mass_kg;
  block.material.youngs_modulus_pa = 5e4;
  block.material.poisson_ratio = 0.3;
  block.material.loss_factor = 0.3;
  block.material.friction = part.friction;
  block.world_from_object = part.world_from_part;
  must(world.add_elastic(block));
}

// Breaks a cup in place until all of its pieces are separate.
void add_fragments(World& world, uint32_t id, const Cup& cup) {
  RigidBodyDescription whole;
  whole.object_id = id;
  whole.mesh = livegs::testing::cup_mesh(32, 8);
  whole.properties = solid_mass_properties(whole.mesh);
  whole.material.behavior = Behavior::Rigid;
  whole.material.mass_kg = kCup_kg;
  whole.material.friction = kFriction;
  whole.material.restitution = 0.0;
  whole.material.fragile = true;
  whole.material.break_impulse_n_s = 0.1;
  whole.world_from_object = cup.world_from_object;
  must(world.add_rigid(whole));
  must(world.set_pieces(id, cup.pieces));
  for (int round = 0; round < 4; ++round) {
    for (const VoronoiPiece& piece : cup.pieces->cut.pieces) {
      // Fails if nothing is left to break.
      (void)world.break_object(id, piece.mesh.vertices_m[0] * 0.999 + piece.mass.centre_of_mass_m * 0.001);
    }
  }
}

World our_world(const BenchScene& scene) {
  WorldSettings settings;
  settings.rate_hz = kRate_hz;
  settings.substeps = 4;
  settings.sleep = false;
  World world(settings);
  for (const Pose& plane : planes_of(scene)) world.add_collider({PlaneShape{}, plane, kFriction, 0.0});
  uint32_t id = 1;
  for (const RigidPart& part : scene.parts) add_box_or_ball(world, id++, part);
  for (const RigidPart& part : scene.soft) add_soft_block(world, id++, part);
  for (const Cup& cup : scene.cups) add_fragments(world, id++, cup);
  return world;
}

// A piece as the convex hull of its vertices, in its principal axes.
RigidPart hull_of(const Cup& cup, size_t index) {
  const BreakablePiece& piece = cup.pieces->pieces[index];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(piece.mass.inertia_m2);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  RigidPart part;
  part.mass_kg = kCup_kg * piece.mass_share;
  part.moments_kg_m2 = part.mass_kg * principal.eigenvalues();
  part.friction = kFriction;
  part.world_from_part = cup.world_from_object * Pose{piece.mass.centre_of_mass_m, Eigen::Quaterniond(axes)};
  for (const Vector3d& corner : cup.pieces->cut.pieces[index].mesh.vertices_m) {
    part.corners_m.push_back(axes.transpose() * (corner - piece.mass.centre_of_mass_m));
  }
  return part;
}

std::unique_ptr<RigidSolver> bullet(const BenchScene& scene, int substeps) {
  RigidSetup setup;
  setup.engine = RigidEngine::Bullet;
  setup.rate_hz = kRate_hz;
  setup.substeps = substeps;
  auto solver = must(make_rigid_solver(setup, {}));
  for (const Pose& plane : planes_of(scene)) solver->add_floor(plane, kFriction);
  for (const std::vector<RigidPart>* parts : {&scene.parts, &scene.soft}) {
    for (const RigidPart& part : *parts) must(solver->add(part));
  }
  for (const Cup& cup : scene.cups) {
    for (size_t i = 0; i < cup.pieces->pieces.size(); ++i) must(solver->add(hull_of(cup, i)));
  }
  return solver;
}

// Means over the variants of a scene.
void report(const std::vector<BenchScene>& variants) {
  const BenchScene& first = variants.front();
  const auto mean_of = [&](const auto& times_of) {
    bench::Times mean{};
    const auto count = static_cast<double>(variants.size());
    for (const BenchScene& scene : variants) {
      const bench::Times one = times_of(scene);
      mean.median_ms += one.median_ms / count;
      mean.p99_ms += one.p99_ms / count;
      mean.cpu_ms += one.cpu_ms / count;
    }
    return mean;
  };
  const auto row = [&](const char* engine, int substeps, int threads, const bench::Times& times,
                       double ratio) {
    std::printf("%s,%zu,%s,%d,%d,%.3f,%.3f,%.3f,%.2f\n", first.name, first.bodies(), engine, substeps,
                threads, times.median_ms, times.p99_ms, times.cpu_ms, ratio);
    std::fflush(stdout);
  };
  set_thread_count(1);
  double bullet_ms = 0.0;
  for (const int substeps : {1, 4}) {
    const bench::Times times = mean_of([&](const BenchScene& scene) {
      const auto solver = bullet(scene, substeps);
      return bench::time_of(kWarmUp, kTimed, [&] { solver->frame(); });
    });
    row("bullet", substeps, 1, times, 1.0);
    bullet_ms = times.cpu_ms;
  }
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    const bench::Times ours = mean_of([&](const BenchScene& scene) {
      World world = our_world(scene);
      if (const size_t made = world.bodies().size(); made != scene.bodies()) {
        std::fprintf(stderr, "%s: %zu bodies, expected %zu\n", scene.name, made, scene.bodies());
      }
      return bench::time_of(kWarmUp, kTimed, [&] { world.step(); });
    });
    row("livegs", 4, threads, ours, ours.cpu_ms / bullet_ms);
  }
}

}  // namespace

int main() {
  set_log_level(LogLevel::Warn);
  std::printf("scene,bodies,engine,substeps,threads,median_ms,p99_ms,cpu_ms,ratio\n");
  report({pyramid()});
  report({pile_of_fragments()});
  report({mixed_objects(7), mixed_objects(8), mixed_objects(9), mixed_objects(10), mixed_objects(11)});
}
