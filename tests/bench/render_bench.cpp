// SPDX-License-Identifier: Apache-2.0
// Time of the CPU rasteriser. Prints CSV: medians and 99th percentiles of the passes over frames in which the
// camera orbits the object once, after a warm-up. cpu_ms is the processor time of all threads per frame; on
// an idle machine, a frame takes about cpu_ms / threads. Run by hand:
//   render_bench > tests/bench/results/<processor>/render.csv
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/splat/synthetic_kernels.h"
#include "core/parallel_for.h"
#include "core/percentile.h"
#include "gaussian/asset_file.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kFrames = 60;
constexpr int kWarmUpFrames = 5;
constexpr double kFov_rad = 0.8;

// Processor time of all threads of this process.
double process_cpu_ms() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

struct Percentiles {
  double median, p99;
};

Percentiles percentiles(const std::vector<double>& values) {
  return {percentile(values, 0.5), percentile(values, 0.99)};
}

// The camera is on a circle of radius `distance_m`, slightly above the centre.
void measure(const char* name, const synthetic::Object& object, const Eigen::Vector3d& centre_m,
             double distance_m, int width, int height, int threads) {
  set_thread_count(threads);
  Rasteriser rasteriser;
  RasterisedView view;
  const DrawnObject drawn = object.drawn();
  std::vector<double> project, sort, blend, total, cpu;
  size_t visible = 0;
  for (int frame = -kWarmUpFrames; frame < kFrames; ++frame) {
    const double angle = 2.0 * M_PI * frame / kFrames;
    const Eigen::Vector3d from(std::sin(angle), 0.3, std::cos(angle));
    const Camera camera = look_at(centre_m + distance_m * from.normalized(), centre_m,
                                  Eigen::Vector3d::UnitY(), kFov_rad, width, height);
    const double cpu_start_ms = process_cpu_ms();
    rasteriser.draw({&drawn, 1}, camera, {}, view);
    const double cpu_ms = process_cpu_ms() - cpu_start_ms;
    if (frame < 0) continue;
    const Rasteriser::Times& times = rasteriser.last_times();
    project.push_back(times.project_ms);
    sort.push_back(times.sort_ms);
    blend.push_back(times.blend_ms);
    cpu.push_back(cpu_ms);
    total.push_back(times.project_ms + times.sort_ms + times.blend_ms);
    visible = std::max(visible, times.visible_kernels);
  }
  const Percentiles p = percentiles(project), s = percentiles(sort), b = percentiles(blend),
                    t = percentiles(total);
  std::printf("%s,%zu,%zu,%d,%d,%d,%d,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f\n", name, object.size(),
              visible, object.asset.sh_degree, width, height, threads, p.median, p.p99, s.median, s.p99,
              b.median, b.p99, t.median, t.p99, percentiles(cpu).median);
  std::fflush(stdout);
}

// The asset in a usual pose: -Y turned up, with a bounding-box diagonal of 1.5 m.
synthetic::Object standing(GaussianAsset asset) {
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& position : asset.positions) bounds.extend(position);
  const double scale = 1.5 / bounds.diagonal().norm();
  const Eigen::Quaterniond turn(0, 1, 0, 0);  // half a turn about x
  synthetic::Object object;
  object.posed.resize(asset.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    const Eigen::Vector3d from_centre = (asset.positions[i] - bounds.center()).cast<double>();
    object.posed.positions_m[i] = (scale * (turn * from_centre)).cast<float>();
    object.posed.covariances_m2[i] =
        synthetic::covariance(turn * asset.rotations[i].cast<double>(),
                              scale * asset.log_scales[i].cast<double>().array().exp().matrix());
    object.posed.world_from_asset[i] = turn.cast<float>();
  }
  object.asset = std::move(asset);
  return object;
}

void measure_all() {
  std::printf(
      "scene,kernels,visible,sh_degree,width,height,threads,project_ms,project_p99_ms,sort_ms,sort_p99_ms,"
      "blend_ms,blend_p99_ms,total_ms,total_p99_ms,cpu_ms\n");
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const size_t count : {20'000u, 100'000u, 300'000u}) {
    // Kernels shrink with their number, so that the opacity of the shell stays the same.
    const synthetic::Object object =
        synthetic::shell(count, 3, 0.9 / std::sqrt(static_cast<double>(count)), 1);
    for (const int threads : {1, 2}) measure("shell", object, origin, 1.5, 640, 480, threads);
    measure("shell", object, origin, 1.5, 1280, 960, 2);
    measure("shell_close", object, origin, 0.7, 640, 480, 2);
  }
  const std::filesystem::path data = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  for (const char* file : {"ponytail_palm/ponytail_palm.ply", "lego_house/lego_house_50k.ply",
                           "guitar/guitar.ply", "playbot/sog_lod2", "fur_block"}) {
    Result<AssetFile> asset = read_asset(data / file);
    if (!asset) {
      std::fprintf(stderr, "%s: skipped: %s\n", file, asset.error().message.c_str());
      continue;
    }
    const std::string name = std::filesystem::path(file).stem().string();
    const synthetic::Object object = standing(std::move(asset->asset));
    measure(name.c_str(), object, origin, 1.8, 640, 480, 2);
  }
}

}  // namespace
}  // namespace livegs

int main() { livegs::measure_all(); }
