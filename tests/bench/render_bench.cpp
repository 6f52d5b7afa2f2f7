// SPDX-License-Identifier: Apache-2.0
// Time of the CPU rasteriser. Prints CSV: medians and 99th percentiles of the passes over frames in which the
// camera orbits the object once, after a warm-up. cpu_ms is the processor time of all threads per frame; on
// an idle machine, a frame takes about cpu_ms / threads. Run by hand:
//   livegs sample scene/
//   render_bench scene > tests/bench/results/<processor>/render.csv
//   render_bench --shadows: the cost of shadows, as a ratio within one run
// The folder adds the sample scene as a window draws it: at a quarter and at half of 1280x720 with the
// culling of these sizes (viewer/camera/render_scale.h), and at full size with all kernels. Its camera moves
// from side to side.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/splat/synthetic_kernels.h"
#include "core/parallel_for.h"
#include "core/percentile.h"
#include "gaussian/asset_file.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr int kFrames = 60, kShadowFrames = 12;
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

using CameraAt = std::function<Camera(double angle_rad)>;  // 0..2 pi over the frames

void measure(const char* name, std::span<const DrawnObject> drawn, const CameraAt& camera_at,
             const RasteriseOptions& options, int threads) {
  set_thread_count(threads);
  Rasteriser rasteriser;
  RasterisedView view;
  std::vector<double> project, sort, blend, total, cpu;
  size_t visible = 0, kernels = 0;
  int degree = 0;
  for (const DrawnObject& object : drawn) {
    kernels += object.asset->size();
    degree = std::max(degree, object.asset->sh_degree);
  }
  for (int frame = -kWarmUpFrames; frame < kFrames; ++frame) {
    const Camera camera = camera_at(2.0 * M_PI * frame / kFrames);
    const double cpu_start_ms = process_cpu_ms();
    rasteriser.draw(drawn, camera, options, view);
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
  std::printf("%s,%zu,%zu,%d,%d,%d,%d,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f,%.2f\n", name, kernels, visible,
              degree, view.image.width, view.image.height, threads, p.median, p.p99, s.median, s.p99,
              b.median, b.p99, t.median, t.p99, percentiles(cpu).median);
  std::fflush(stdout);
}

// The camera is on a circle of radius `distance_m`, slightly above the centre.
void measure(const char* name, const synthetic::Object& object, const Eigen::Vector3d& centre_m,
             double distance_m, int width, int height, int threads) {
  const DrawnObject drawn = object.drawn();
  const auto camera = [&](double angle) {
    const Eigen::Vector3d from(std::sin(angle), 0.3, std::cos(angle));
    return look_at(centre_m + distance_m * from.normalized(), centre_m, Eigen::Vector3d::UnitY(), kFov_rad,
                   width, height);
  };
  measure(name, {&drawn, 1}, camera, {}, threads);
}

synthetic::Object posed(GaussianAsset asset, double scale, const Pose& pose) {
  synthetic::Object object;
  object.posed.resize(asset.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    object.posed.positions_m[i] =
        (pose.position_m + scale * (pose.orientation * asset.positions[i].cast<double>())).cast<float>();
    object.posed.covariances_m2[i] =
        synthetic::covariance(pose.orientation * asset.rotations[i].cast<double>(),
                              scale * asset.log_scales[i].cast<double>().array().exp().matrix());
    object.posed.world_from_asset[i] = pose.orientation.cast<float>();
  }
  object.asset = std::move(asset);
  return object;
}

// The sample scene: its assets, with -Y up and in metres, at the positions of its scene file.
void measure_sample(const std::filesystem::path& folder) {
  const std::pair<const char*, Eigen::Vector3d> places[] = {{"room", {0, 0, 0}},
                                                            {"stool", {-0.62, 0.02, -0.45}},
                                                            {"plant", {0.72, 0.04, -0.55}},
                                                            {"pillow", {-0.02, 0.40, -0.30}},
                                                            {"hat", {-0.42, 0.30, 0.12}},
                                                            {"cup", {0.42, 0.90, 0.15}},
                                                            {"duck", {0.05, 0.05, 0.30}}};
  std::vector<synthetic::Object> objects;
  for (const auto& [name, place] : places) {
    Result<AssetFile> asset = read_asset(folder / (std::string(name) + ".ply"));
    if (!asset) {
      std::fprintf(stderr, "%s: skipped: %s\n", name, asset.error().message.c_str());
      return;
    }
    objects.push_back(posed(std::move(asset->asset), 1, {place, Eigen::Quaterniond(0, 1, 0, 0)}));
    objects.back().id = static_cast<uint32_t>(objects.size());
  }
  std::vector<DrawnObject> drawn;
  for (const synthetic::Object& object : objects) drawn.push_back(object.drawn());
  for (const int part : {4, 2, 1}) {
    const int width = 1280 / part, height = 720 / part;
    RasteriseOptions options;
    options.min_contribution_px = part == 1 ? 0.0f : 0.25f;
    options.max_radius_px = static_cast<float>((part == 1 ? 2 : 1) * width);
    const auto camera = [&](double angle) {
      return look_at({0.8 * std::sin(angle), 1.0, 2.2}, {0, 0.35, -0.2}, Eigen::Vector3d::UnitY(), kFov_rad,
                     width, height);
    };
    for (const int threads : {1, 2}) measure("sample", drawn, camera, options, threads);
  }
}

// The asset in a usual pose: -Y turned up, with a bounding-box diagonal of 1.5 m.
synthetic::Object standing(GaussianAsset asset) {
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& position : asset.positions) bounds.extend(position);
  const double scale = 1.5 / bounds.diagonal().norm();
  const Eigen::Quaterniond turn(0, 1, 0, 0);  // half a turn about x
  return posed(std::move(asset), scale, {-scale * (turn * bounds.center().cast<double>()), turn});
}

void measure_all(const char* sample) {
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
  if (sample) measure_sample(sample);
}

// A shell of kernels on or above the floor, and the sample of its kernels that casts the shadow.
struct Caster {
  synthetic::Object object;
  std::vector<Eigen::Vector3f> positions_m;
  std::vector<Symmetric3f> covariances_m2;
  std::vector<float> weights;
  std::vector<uint32_t> bodies;

  Caster(size_t kernels, const Eigen::Vector3f& at_m, uint64_t seed) {
    object = synthetic::shell(kernels, 2, 0.9 / std::sqrt(static_cast<double>(kernels)), seed);
    for (size_t i = 0; i < object.size(); ++i) {
      object.posed.positions_m[i] = 0.3f * object.posed.positions_m[i] + at_m;
      for (float& value : object.posed.covariances_m2[i]) value *= 0.09f;
    }
    const size_t step = std::max<size_t>(1, kernels / 2048);
    for (size_t i = 0; i < object.size(); i += step) {
      positions_m.push_back(object.posed.positions_m[i]);
      covariances_m2.push_back(object.posed.covariances_m2[i]);
    }
    weights.assign(positions_m.size(), static_cast<float>(step));
    bodies.assign(positions_m.size(), 0);
  }
};

// The cost of shadows in one run: the same pictures of six objects on a floor, 434k kernels as in the sample
// scene, with and without shadows in turn. `moving` objects are cast again for every picture.
void measure_shadows() {
  std::vector<Caster> casters;
  for (int i = 0; i < 6; ++i) {
    const float height_m = i % 2 == 0 ? 0.3f : 0.5f;
    casters.emplace_back(
        60'000,
        Eigen::Vector3f(0.7f * static_cast<float>(i % 3 - 1), height_m, 0.7f * static_cast<float>(i / 3)),
        10 + static_cast<uint64_t>(i));
  }
  synthetic::Object floor = synthetic::shell(74'000, 1, 0.01, 3);
  for (size_t i = 0; i < floor.size(); ++i) {
    const auto column = static_cast<float>(i % 272), row = static_cast<float>(i / 272);
    floor.posed.positions_m[i] = {0.011f * column - 1.5f, 0, 0.011f * row - 1.2f};
    floor.posed.covariances_m2[i] = {6e-5f, 0, 0, 1e-6f, 0, 6e-5f};
  }
  std::vector<DrawnObject> drawn = {{&floor.asset, &floor.posed, 100}};
  for (uint32_t i = 0; i < casters.size(); ++i)
    drawn.push_back({&casters[i].object.asset, &casters[i].object.posed, i});
  const Camera camera = look_at({0.5, 1.2, 2.6}, {0, 0.2, 0.3}, Eigen::Vector3d::UnitY(), kFov_rad, 640, 480);
  SceneShadows shadows;
  const auto cast = [&] {
    for (uint32_t i = 0; i < casters.size(); ++i) {
      const Caster& caster = casters[i];
      shadows.set(i, {caster.positions_m, caster.covariances_m2, caster.weights, caster.bodies});
    }
    (void)shadows.table();
  };
  std::printf("scene,moving,threads,plain_cpu_ms,shadows_cpu_ms,cast_cpu_ms,ratio\n");
  Rasteriser rasteriser;
  RasterisedView view;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    for (const bool moving : {false, true}) {
      cast();
      std::vector<double> plain, shaded, casting;
      for (int frame = -kWarmUpFrames; frame < kShadowFrames; ++frame) {
        double at_ms = process_cpu_ms();
        const auto lap = [&] {
          const double before_ms = std::exchange(at_ms, process_cpu_ms());
          return at_ms - before_ms;
        };
        rasteriser.draw(drawn, camera, {}, view);
        const double plain_ms = lap();
        if (moving) cast();
        const double cast_ms = lap();
        RasteriseOptions options;
        options.shadows = &shadows.table();
        rasteriser.draw(drawn, camera, options, view);
        const double shaded_ms = lap();
        if (frame < 0) continue;
        plain.push_back(plain_ms);
        casting.push_back(cast_ms);
        shaded.push_back(shaded_ms + cast_ms);
      }
      const double p = percentiles(plain).median, s = percentiles(shaded).median;
      std::printf("six objects on a floor,%s,%d,%.2f,%.2f,%.2f,%.3f\n", moving ? "all" : "none", threads, p,
                  s, percentiles(casting).median, s / p);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace livegs

int main(int count, char** words) {
  if (count > 1 && std::string(words[1]) == "--shadows")
    livegs::measure_shadows();
  else
    livegs::measure_all(count > 1 ? words[1] : nullptr);
}
