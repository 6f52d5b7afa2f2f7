// SPDX-License-Identifier: Apache-2.0
// The frame in which a cup of 20 480 triangles breaks, with its pieces and kernels prepared. Prints CSV:
// `break_bench > results/<machine>/break.csv`. `step` is a tick of four substeps of the whole cup in free fall, `break`
// the tick in which a blow of 20 times the break impulse takes it apart, both as World::step; `bind` is what is left to
// do for 300 000 kernels: saying which runs of them go with which body. Median of eleven runs; `cpu_ms` is processor
// time, which says what the work costs on a machine that is shared. 11 ms are allowed for break and bind together.
#include <cstdio>

#include "bench/time_of.h"
#include "core/parallel_for.h"
#include "physics/breakable_pieces.h"
#include "physics/world.h"
#include "scene/fragile_object.h"
#include "server/geometry/fracture_shapes.h"

using namespace livegs;

namespace {

constexpr uint32_t kKernels = 300000;

World falling_cup(const TriangleMesh& mesh, const std::shared_ptr<const BreakablePieces>& pieces) {
  World world{WorldSettings{}};
  RigidBodyDescription cup;
  cup.object_id = 1;
  cup.mesh = mesh;
  cup.properties = solid_mass_properties(mesh);
  cup.material.mass_kg = 0.3;
  cup.material.fragile = true;
  cup.material.break_impulse_n_s = 0.9;
  (void)world.add_rigid(cup);
  (void)world.set_pieces(1, pieces);
  world.step();
  return world;
}

void bench_cup(size_t piece_count, int threads) {
  set_thread_count(threads);
  const TriangleMesh mesh = testing::cup_mesh(128, 39);
  BreakableOptions options;
  options.piece_count = piece_count;
  const auto pieces = prepare_pieces(mesh, Fill::Solid, options).value();
  BrokenAsset broken;
  broken.piece_kernels.assign(pieces->pieces.size(), kKernels / static_cast<uint32_t>(pieces->pieces.size()));
  const double blow_n = 20 * 0.9 * WorldSettings{}.rate_hz;

  constexpr int kRuns = 11;
  std::vector<World> worlds;
  for (int i = 0; i < kRuns; ++i) worlds.push_back(falling_cup(mesh, pieces));
  size_t run = 0;
  const auto report = [&](const char* stage, const bench::Times& times) {
    std::printf("%zu,%zu,%d,%s,%.3f,%.3f\n", pieces->pieces.size(), worlds[0].bodies().size(), threads, stage,
                times.median_ms, times.cpu_ms);
  };
  report("step", bench::time_of(0, kRuns, [&] { worlds[run++].step(); }));
  for (World& world : worlds) world.set_force(1, 1, {{0.04, 0.05, 0}, {-blow_n, 0, 0}});
  run = 0;
  report("break", bench::time_of(0, kRuns, [&] { worlds[run++].step(); }));
  report("bind", bench::time_of(0, kRuns, [&] {
           RestBody rest = worlds[0].rest_body(1);
           rest.kernel_runs = kernel_runs(broken, worlds[0].piece_bodies(1));
         }));
}

}  // namespace

int main() {
  std::printf("pieces,bodies,threads,stage,median_ms,cpu_ms\n");
  for (const int threads : {1, 0}) {
    for (const size_t pieces : {size_t{16}, size_t{64}}) bench_cup(pieces, threads);
  }
}
