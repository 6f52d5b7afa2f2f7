// SPDX-License-Identifier: Apache-2.0
// Cost of rigid scenes on one and two threads, and of Bullet in the same run. Prints CSV:
// `rigid_bench > results/<machine>/rigid.csv`. Sleep is off; 90 frames of 1/60 s go before, in which things fall and
// settle, then 60 are timed. Bullet (single precision, 10 iterations) runs twice: one step a frame, as games use it, and
// four as ours do. `ratio` is processor time over that of Bullet with as many steps.
#include <cstdio>
#include <random>
#include <string>

#include "bench/time_of.h"
#include "core/parallel_for.h"
#include "geometry/convex_hull.h"
#include "geometry/mass_properties.h"
#include "study/rigid_solver.h"

using namespace livegs;
using namespace livegs::study;
using Eigen::Vector3d;

namespace {

std::vector<RigidPart> pyramid() {
  std::vector<RigidPart> parts;
  for (int row = 0; row < 30; ++row) {
    for (int i = 0; i < 30 - row; ++i) {
      RigidPart box;
      box.size_m.setConstant(0.1);
      box.friction = 0.6;
      box.world_from_part.position_m = {(i - 0.5 * (29 - row)) * 0.105, 0.05 + 0.1 * row, 0};
      parts.push_back(box);
    }
  }
  return parts;
}

double uniform(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

// Corners of a convex fragment about its centre of mass.
void make_fragment(RigidPart& part, std::mt19937& random) {
  std::vector<Vector3d> cloud;
  for (int i = 0; i < 12; ++i) {
    Vector3d p;
    for (int d = 0; d < 3; ++d) p[d] = uniform(random) - 0.5;
    cloud.push_back((0.04 + 0.03 * uniform(random)) * p.normalized());
  }
  const TriangleMesh mesh = convex_hull(cloud);
  const MassProperties properties = solid_mass_properties(mesh);
  for (const Vector3d& corner : mesh.vertices_m) part.corners_m.push_back(corner - properties.centre_of_mass_m);
  part.moments_kg_m2 = part.mass_kg * properties.inertia_m2.diagonal();
}

// Things over a square, layer upon layer: every `balls`-th a ball, half of the others boxes, half fragments.
std::vector<RigidPart> pile(int count, int across, int balls) {
  std::vector<RigidPart> parts;
  std::mt19937 random(7);
  for (int i = 0; i < count; ++i) {
    RigidPart part;
    part.mass_kg = 0.3;
    if (balls > 0 && i % balls == 0) part.radius_m = 0.04;
    else if (i % 2) part.size_m = Vector3d(0.06 + 0.05 * uniform(random), 0.05, 0.08);
    else make_fragment(part, random);
    const int layer = i / (across * across), place = i % (across * across);
    part.world_from_part.position_m = {0.13 * (place % across - 0.5 * across) + 0.02 * uniform(random),
                                       0.1 + 0.13 * layer,
                                       0.13 * (place / across - 0.5 * across) + 0.02 * uniform(random)};
    part.world_from_part.orientation =
        Eigen::AngleAxisd(6.0 * uniform(random), Vector3d(uniform(random), 1, uniform(random)).normalized());
    parts.push_back(part);
  }
  return parts;
}

bench::Times run(const std::vector<RigidPart>& parts, RigidEngine engine, int substeps, int threads) {
  set_thread_count(threads);
  RigidSetup setup;
  setup.engine = engine;
  setup.substeps = substeps;
  auto solver = make_rigid_solver(setup, {});
  if (!solver) std::fprintf(stderr, "%s\n", solver.error().message.c_str());
  (*solver)->add_floor({}, 0.6);
  for (const RigidPart& part : parts) {
    if (auto added = (*solver)->add(part); !added) std::fprintf(stderr, "%s\n", added.error().message.c_str());
  }
  return bench::time_of(90, 60, [&] { (*solver)->frame(); });
}

void report(const char* scene, const std::vector<RigidPart>& parts) {
  const auto row = [&](const char* engine, int substeps, int threads, const bench::Times& times, double ratio) {
    std::printf("%s,%zu,%s,%d,%d,%.3f,%.3f,%.3f,%.2f\n", scene, parts.size(), engine, substeps, threads,
                times.median_ms, times.p99_ms, times.cpu_ms, ratio);
    std::fflush(stdout);
  };
  const bench::Times bullet1 = run(parts, RigidEngine::Bullet, 1, 1), bullet4 = run(parts, RigidEngine::Bullet, 4, 1);
  row("bullet", 1, 1, bullet1, 1.0);
  row("bullet", 4, 1, bullet4, 1.0);
  for (const int threads : {1, 2}) {
    const bench::Times ours = run(parts, RigidEngine::Livegs, 4, threads);
    row("livegs", 4, threads, ours, ours.cpu_ms / bullet4.cpu_ms);
  }
}

}  // namespace

int main() {
  std::printf("scene,bodies,engine,substeps,threads,median_ms,p99_ms,cpu_ms,ratio\n");
  report("pyramid", pyramid());
  report("pile of boxes and fragments", pile(200, 5, 0));
  report("mixed objects", pile(50, 4, 3));
}
