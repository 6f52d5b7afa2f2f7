// SPDX-License-Identifier: Apache-2.0
// Time to bind and to skin, by kind of driver. Prints CSV: `skin_bench > results/<machine>/skin.csv`.
// The body is a ball of cells, twisted and bent; 10 % of the kernels are haze outside it. Five runs warm up,
// 50 count; `stage` bind is timed over 1 + 3 runs. `crushed` is the lattice pressed flat, where every kernel
// needs its singular values.
#include <cstdio>

#include "bench/support/time_of.h"
#include "common/skin/kernels/rest_bodies.h"
#include "core/parallel_for.h"

using namespace livegs;
using namespace livegs::testing;

namespace {

RestBody ball_of_cells(int across) {
  const double radius = 0.5 * across;
  RestBody rest = lattice_body(across, across, across, 0.5 / across, [=](int x, int y, int z) {
    return (Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) - Eigen::Vector3d::Constant(radius)).norm() < radius;
  });
  place(rest, 1);
  return rest;
}

Eigen::Vector3d twisted(const Eigen::Vector3d& x) {
  const Eigen::AngleAxisd twist(1.5 * x[1], Eigen::Vector3d::UnitY());
  return twist * x + Eigen::Vector3d(0.05 * std::sin(6.0 * x[1]), 0.2 * x[0] * x[0], 0.0);
}

Eigen::Vector3d flattened(const Eigen::Vector3d& x) { return {x[0], 0.0, x[2]}; }

void report(size_t kernels, size_t drivers, const char* kind, const char* stage, int threads,
            const bench::Times& times) {
  std::printf("%zu,%zu,%s,%s,%d,%.3f,%.3f,%.3f,%.1f\n", kernels, drivers, kind, stage, threads,
              times.median_ms, times.p99_ms, times.cpu_ms, times.cpu_ms * 1e6 / static_cast<double>(kernels));
  std::fflush(stdout);
}

}  // namespace

int main() {
  std::printf("kernels,drivers,kind,stage,threads,median_ms,p99_ms,cpu_ms,cpu_ns_per_kernel\n");
  for (const size_t count : {10000u, 100000u, 300000u}) {
    for (const int across : {8, 24}) {
      RestBody lattice = ball_of_cells(across);
      std::vector<Eigen::Vector3d> points = points_inside(lattice, count - count / 10, 2);
      std::mt19937_64 random(3);
      while (points.size() < count) points.push_back(node_rest_m(lattice, 0) + uniform3(random, -1.0, 1.0));
      const GaussianAsset asset = kernels_at(lattice, points, 4);

      RestBody particles = lattice, rigid = lattice;
      particles.kind = DriverKind::Particles;
      for (size_t n = 0; n < lattice.node_coordinates.size(); ++n) {
        particles.particles_m.push_back(node_rest_m(lattice, n).cast<float>());
      }
      rigid.kind = DriverKind::Rigid;
      rigid.bodies = {Pose{}};
      ObjectDrivers turned;
      turned.poses = {Pose{{0.1, 0.2, 0.3}, random_rotation(random)}};
      ObjectDrivers particle_drivers = moved_drivers(particles, twisted);
      for (size_t p = 0; p < particles.particles_m.size(); ++p) {
        particle_drivers.rotations[p] = Eigen::Quaternionf(
            Eigen::AngleAxisf(1.5f * particles.particles_m[p][1], Eigen::Vector3f::UnitY()));
      }

      struct Case {
        const char* kind;
        const RestBody* rest;
        ObjectDrivers drivers;
      };
      const std::vector<Case> cases = {{"lattice", &lattice, moved_drivers(lattice, twisted)},
                                       {"crushed", &lattice, moved_drivers(lattice, flattened)},
                                       {"livegs-v1", &particles, particle_drivers},
                                       {"rigid", &rigid, turned}};
      for (const Case& one : cases) {
        const bool is_rigid = one.rest->kind == DriverKind::Rigid;
        if (is_rigid && across != 8) continue;
        const size_t drivers = is_rigid ? 1 : lattice.node_coordinates.size();
        for (const int threads : {1, 2}) {
          set_thread_count(threads);
          const Result<KernelBindings> bindings = bind_kernels(asset, *one.rest);
          if (!bindings) return std::fprintf(stderr, "%s\n", bindings.error().message.c_str()), 1;
          PosedKernels kernels;
          report(count, drivers, one.kind, "skin", threads, bench::time_of(5, 50, [&] {
                   skin_kernels(asset, *one.rest, *bindings, one.drivers, kernels);
                 }));
          report(count, drivers, one.kind, "bind", threads,
                 bench::time_of(1, 3, [&] { (void)bind_kernels(asset, *one.rest); }));
        }
      }
    }
  }
  return 0;
}
