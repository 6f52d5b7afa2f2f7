// SPDX-License-Identifier: Apache-2.0
// Cost of preparing a body for fracture at load, and cost left for the tick of the break. Prints CSV:
// `fracture_bench > results/<machine>/fracture.csv`.
// A ball and a cup of 20 480 triangles each, 16 and 64 pieces, 300 000 kernels on the surface. Median of five
// runs after one warm-up, on one core and on all. `cpu_ms` is processor time, which hardly depends on other
// load. Stages `seeds` to `graph` run in the background at load. `blow` selects the bonds that an impact of
// twice the threshold breaks; only this runs in the tick of the break (bound: 11 ms). `items`: seeds, pieces,
// kernels, bonds, broken bonds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "bench/support/time_of.h"
#include "core/parallel_for.h"
#include "geometry/fracture/fracture_seeds.h"
#include "geometry/fracture/piece_kernels.h"
#include "geometry/fracture/voronoi_pieces.h"
#include "physics/fracture/bond_graph.h"
#include "server/geometry/fracture/fracture_shapes.h"

using namespace livegs;

namespace {

constexpr size_t kKernels = 300000;

double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1.0p-53; }

// Discs distributed over the surface by area, just wide enough to cover it, with a thickness of a twentieth.
GaussianAsset kernels_on(const TriangleMesh& mesh, size_t count) {
  std::vector<double> areas;
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices_m;
    areas.push_back(area += 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).norm());
  }
  const double spacing_m = std::sqrt(area / static_cast<double>(count));
  std::mt19937_64 engine(7);
  GaussianAsset asset;
  asset.resize(count);
  for (size_t k = 0; k < count; ++k) {
    const double at = area * uniform(engine);
    const auto t = static_cast<size_t>(std::lower_bound(areas.begin(), areas.end(), at) - areas.begin());
    const auto& [a, b, c] = mesh.triangles[std::min(t, areas.size() - 1)];
    const auto& v = mesh.vertices_m;
    const double r = std::sqrt(uniform(engine)), s = uniform(engine);
    asset.positions[k] = ((1 - r) * v[a] + r * (1 - s) * v[b] + r * s * v[c]).cast<float>();
    const Eigen::Vector3d normal = (v[b] - v[a]).cross(v[c] - v[a]);
    asset.rotations[k] =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal).normalized().cast<float>();
    const auto wide = static_cast<float>(std::log(spacing_m));
    asset.log_scales[k] = {wide, wide, wide - 3.0f};
    asset.opacity_logits[k] = 3.0f;
    asset.sh_dc[k].setZero();
  }
  return asset;
}

void report(const char* shape, size_t pieces, int threads, const char* stage, const bench::Times& times,
            size_t items) {
  std::printf("%s,%zu,%d,%s,%zu,%.3f,%.3f\n", shape, pieces, threads, stage, items, times.median_ms,
              times.cpu_ms);
  std::fflush(stdout);
}

void bench_shape(const char* shape, const TriangleMesh& mesh, int threads) {
  set_thread_count(threads);
  const GaussianAsset asset = kernels_on(mesh, kKernels);
  const auto measure = [](const std::function<void()>& work) { return bench::time_of(1, 5, work); };
  for (const size_t count : {size_t{16}, size_t{64}}) {
    std::vector<Eigen::Vector3d> seeds;
    report(shape, count, threads, "seeds",
           measure([&] { seeds = fracture_seeds(mesh, {.count = count, .impacts_m = {}}).value(); }), count);
    VoronoiPieces pieces;
    const bench::Times cut = measure([&] { pieces = cut_voronoi_pieces(mesh, seeds).value(); });
    report(shape, count, threads, "cut", cut, pieces.pieces.size());
    PieceKernels kernels;
    const bench::Times split = measure([&] { kernels = make_piece_kernels(asset, {}, pieces).value(); });
    report(shape, count, threads, "split", split, kernels.asset.size());
    BondGraph graph;
    const bench::Times connect = measure([&] { graph = make_bond_graph(pieces, 0.3, 1.0); });
    report(shape, count, threads, "graph", connect, graph.bonds.size());
    const Impact impact{0, graph.pieces[0].centre_m, {0, 2, 0}};
    std::vector<uint32_t> broken;
    const bench::Times strike = measure([&] { broken = broken_bonds(graph, impact); });
    report(shape, count, threads, "blow", strike, broken.size());
  }
}

}  // namespace

int main() {
  std::printf("shape,pieces_wanted,threads,stage,items,median_ms,cpu_ms\n");
  for (const int threads : {1, 0}) {
    bench_shape("ball", sphere_mesh(0.05, 5), threads);
    bench_shape("cup", testing::cup_mesh(128, 39), threads);
  }
}
