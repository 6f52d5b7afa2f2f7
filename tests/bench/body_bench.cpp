// SPDX-License-Identifier: Apache-2.0
// Time from an asset to a body by stage, on one core. Prints CSV: `body_bench > results/<machine>/body.csv`.
// Assets: two deterministic ones of exactly 100 000 and 300 000 kernels (a noisy vase with leaves and haze),
// and captured ones if the shared data is present. Median of three runs after one warm-up. `read` of a
// synthetic asset is from memory (0). `cpu_ms` is processor time, which hardly depends on other load. `alpha`
// is the Delaunay triangulation alone; `repair` is the rest of the surface: thinning, sheets, flood, pairing,
// small components. Bound of `total`: 3 s for 100 000 kernels, 8 s for 300 000.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "bench/support/time_of.h"
#include "core/parallel_for.h"
#include "gaussian/asset_file.h"
#include "geometry/field/distance_field.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/surface/alpha_complex.h"
#include "geometry/surface/mesh_facts.h"
#include "geometry/surface/voxel_thinning.h"

using namespace livegs;
namespace fs = std::filesystem;

namespace {

constexpr double kPi = std::numbers::pi;

double uniform(std::mt19937_64& engine, double low, double high) {
  return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
}

// 75 % of the kernels on a fluted vase, 15 % on 12 arching leaves, 10 % haze. 0.8 units high.
GaussianAsset vase_with_leaves(size_t count) {
  std::mt19937_64 engine(count);
  GaussianAsset asset;
  asset.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const double part = uniform(engine, 0, 1);
    Eigen::Vector3d p;
    float logit = 3.0f;
    if (part < 0.75) {
      const double turn = uniform(engine, 0, 2 * kPi), y = uniform(engine, 0, 0.4);
      const double radius = part < 0.05 ? uniform(engine, 0, 0.1)  // the foot
                                        : 0.1 + 0.04 * std::sin(8 * y) + 0.004 * std::cos(14 * turn);
      p = {radius * std::cos(turn), part < 0.05 ? 0.0 : y, radius * std::sin(turn)};
    } else if (part < 0.9) {
      const double leaf = std::floor(uniform(engine, 0, 12)), s = uniform(engine, 0, 1);
      const double out = 0.35 * s, across = uniform(engine, -0.008, 0.008), turn = 2 * kPi * leaf / 12;
      p = {out * std::cos(turn) - across * std::sin(turn), 0.4 + 0.4 * s * (1.6 - s),
           out * std::sin(turn) + across * std::cos(turn)};
      logit = 0.5f;
    } else {
      p = {uniform(engine, -0.4, 0.4), uniform(engine, -0.1, 0.9), uniform(engine, -0.4, 0.4)};
      logit = -4.0f;
    }
    for (int axis = 0; axis < 3; ++axis) p[axis] += uniform(engine, -0.0015, 0.0015);
    asset.positions[i] = {static_cast<float>(p.x()), static_cast<float>(-p.y()), static_cast<float>(-p.z())};
    asset.log_scales[i].setConstant(std::log(0.002f));
    asset.rotations[i].setIdentity();
    asset.opacity_logits[i] = logit;
    asset.sh_dc[i].setZero();
  }
  return asset;
}

struct Row {
  const char* asset;
  const char* kind;
  size_t kernels;
};

void report(const Row& row, const char* stage, const bench::Times& times, size_t items) {
  std::printf("%s,%zu,%s,%s,%zu,%.2f,%.2f\n", row.asset, row.kernels, row.kind, stage, items, times.median_ms,
              times.cpu_ms);
  std::fflush(stdout);
}

bench::Times measure(const std::function<void()>& work) { return bench::time_of(1, 3, work); }

// As in reconstruct_surface: at unit size, with voxels as fractions of the diagonal.
std::vector<Eigen::Vector3d> thin(std::vector<Eigen::Vector3d> points, double voxel) {
  Eigen::AlignedBox3d bounds;
  for (const auto& point : points) bounds.extend(point);
  for (auto& point : points) point = (point - bounds.center()) / bounds.diagonal().norm();
  return thin_by_voxels(points, voxel);
}

void bench_body(const char* name, const GaussianAsset& asset, const bench::Times& read) {
  Similarity up;
  up.rotation = Eigen::Quaterniond(0, 1, 0, 0);
  std::vector<Eigen::Vector3d> points;
  const bench::Times gather = measure([&] { points = body_points(asset, up); });
  for (const bool rigid : {false, true}) {
    const Row row{name, rigid ? "rigid" : "elastic", asset.size()};
    const SurfaceOptions options = rigid ? rigid_surface_options() : elastic_surface_options();
    Surface surface;
    const bench::Times whole = measure([&] { surface = reconstruct_surface(points, options).value(); });
    const std::vector<Eigen::Vector3d> thinned =
        thin(points, rigid ? options.downsample : options.alpha_radius / 3);
    const bench::Times alpha = measure([&] { AlphaComplex complex(thinned); });
    ParticleSet particles;
    MassProperties mass;
    MeshFacts facts;
    const bench::Times sample = measure([&] { particles = sample_particles(surface.mesh); });
    const bench::Times weigh = measure([&] { mass = solid_mass_properties(surface.mesh); });
    const double longest_m = mesh_bounds_m(surface.mesh).sizes().maxCoeff();
    size_t nodes = 0;
    const bench::Times field = measure([&] {
      const DistanceField made(surface.mesh, longest_m / 64, longest_m / 16);
      nodes = static_cast<size_t>(made.node_counts().prod());
    });
    const bench::Times know = measure([&] { facts = mesh_facts(surface.mesh); });
    const size_t triangles = surface.mesh.triangles.size();
    report(row, "read", read, asset.size());
    report(row, "points", gather, points.size());
    report(row, "alpha", alpha, thinned.size());
    report(row, "repair", {whole.median_ms - alpha.median_ms, 0, whole.cpu_ms - alpha.cpu_ms}, triangles);
    report(row, "particles", sample, particles.positions_m.size());
    report(row, "mass", weigh, triangles);
    report(row, "distance_field", field, nodes);
    report(row, "facts", know, triangles);
    bench::Times total;
    for (const bench::Times& part : {read, gather, whole, sample, weigh, field, know}) {
      total.median_ms += part.median_ms;
      total.cpu_ms += part.cpu_ms;
    }
    report(row, "total", total, asset.size());
  }
}

}  // namespace

int main() {
  set_thread_count(1);
  std::printf("asset,kernels,kind,stage,items,median_ms,cpu_ms\n");
  bench_body("vase_100k", vase_with_leaves(100000), {});
  bench_body("vase_300k", vase_with_leaves(300000), {});
  const fs::path splats = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  for (const char* file : {"ponytail_palm/ponytail_palm.ply", "guitar/guitar.ply", "statues/narcissus.sog",
                           "lego_house/fourth_st.spz", "fur_block/meta.json"}) {
    if (!fs::exists(splats / file)) {
      std::fprintf(stderr, "%s: skipped; the shared data is missing\n", file);
      continue;
    }
    GaussianAsset asset;
    bool ok = true;
    const bench::Times read = measure([&] {
      auto opened = read_asset(splats / file);
      ok = ok && opened.has_value();
      if (opened) asset = std::move(opened->asset);
    });
    if (!ok) {
      std::fprintf(stderr, "%s: skipped; not readable\n", file);
      continue;
    }
    const std::string name = fs::path(file).parent_path().filename().string() == "statues"
                                 ? fs::path(file).stem().string()
                                 : fs::path(file).parent_path().filename().string();
    bench_body(name.c_str(), asset, read);
  }
}
