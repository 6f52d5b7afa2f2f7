// SPDX-License-Identifier: Apache-2.0
// Cost and benefit of culling kernels with small contributions. Prints CSV, one row per asset, view and
// threshold: kernels drawn, PSNR against all kernels, and processor time per frame on the CPU (all threads,
// best of three). Views (posed_assets.h): afar at three times the size, front, close and inside. Run by hand:
//   cull_bench > tests/bench/results/<processor>/cull.csv
//   cull_bench cap > .../cap.csv      cost and benefit of limiting the radius of kernels
//   cull_bench order > .../order.csv  effect of the blending order of kernels
//   cull_bench lean > .../lean.csv    wall time of frames of a camera that moves into an asset: at full
//                                     quality, with the resolution adapted to a budget, also with culling,
//                                     and also with a limited radius
//   cull_bench lean vulkan > .../lean_vulkan.csv
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "client/render/renderer/posed_assets.h"
#include "common/splat/synthetic_kernels.h"
#include "gaussian/asset_file.h"
#include "render/splat_renderer.h"
#include "splat/rasterise.h"
#include "viewer/camera/render_scale.h"

namespace livegs {
namespace {

constexpr int kWidth = 640, kHeight = 480;
const Eigen::Vector3f kBackground{0.08f, 0.08f, 0.1f};

double process_cpu_ms() {  // all threads
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

struct Drawn {
  double cpu_ms = 0;
  size_t kernels = 0;
};

Drawn draw(Rasteriser& rasteriser, const DrawnObject& object, const Camera& camera, float min_contribution_px,
           float max_radius_px, RasterisedView& view) {
  RasteriseOptions options;
  options.background = kBackground;
  options.order = DepthOrder::Distance;
  options.min_contribution_px = min_contribution_px;
  options.max_radius_px = max_radius_px;
  const double begun_ms = process_cpu_ms();
  rasteriser.draw({&object, 1}, camera, options, view);
  return {process_cpu_ms() - begun_ms, rasteriser.last_times().visible_kernels};
}

struct Thing {
  std::string name;
  GaussianAsset asset;
  PosedKernels posed;
  DrawnObject drawn() const { return {&asset, &posed, 0}; }
};

std::vector<Thing> things() {
  std::vector<Thing> all;
  const std::filesystem::path captured = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  for (const char* file : {"ponytail_palm/ponytail_palm.ply", "lego_house/lego_house_50k.ply",
                           "guitar/guitar.ply", "playbot/playbot_31k.ply", "statues/massa.sog"}) {
    auto read = read_asset(captured / file);
    if (!read) {
      std::fprintf(stderr, "%s: skipped\n", read.error().message.c_str());
      continue;
    }
    Thing thing{std::filesystem::path(file).stem().string(), std::move(read->asset), {}};
    thing.posed = pose_asset(thing.asset);
    all.push_back(std::move(thing));
  }
  synthetic::Object shell = synthetic::shell(100'000, 3, 0.9 / std::sqrt(1e5), 1);
  all.push_back({"shell", std::move(shell.asset), std::move(shell.posed)});
  return all;
}

Camera seen_from(const CloudExtent& extent, double distance, int width, int height) {
  const Eigen::Vector3d toward = Eigen::Vector3d(0.3, 0.25, 1.0).normalized();
  return look_at(extent.centre_m + distance * extent.size_m * toward, extent.centre_m,
                 Eigen::Vector3d::UnitY(), 0.8, width, height);
}

std::vector<std::pair<const char*, Camera>> named_views(const CloudExtent& extent) {
  return {{"afar", seen_from(extent, 3.0, kWidth, kHeight)},
          {"front", view_of(extent, View::Front, kWidth, kHeight)},
          {"close", view_of(extent, View::Close, kWidth, kHeight)},
          {"inside", view_of(extent, View::Inside, kWidth, kHeight)}};
}

void measure_thresholds() {
  std::printf("asset,kernels,view,width,height,threshold_px,drawn,left_out,psnr_db,cpu_ms,time_share\n");
  for (const Thing& thing : things()) {
    const CloudExtent extent = extent_of(thing.posed);
    for (const auto& [name, camera] : named_views(extent)) {
      Rasteriser rasteriser;
      RasterisedView all, some;
      Drawn whole;
      for (const float threshold_px : {0.0f, 0.5f, 1.0f, 2.0f, 4.0f, 8.0f, 16.0f, 32.0f}) {
        Drawn best;
        for (int i = 0; i < 3; ++i) {
          const Drawn once =
              draw(rasteriser, thing.drawn(), camera, threshold_px, 0, threshold_px == 0 ? all : some);
          if (i == 0 || once.cpu_ms < best.cpu_ms) best = once;
        }
        if (threshold_px == 0) whole = best;
        std::printf(
            "%s,%zu,%s,%d,%d,%g,%zu,%.3f,%.1f,%.1f,%.2f\n", thing.name.c_str(), thing.asset.size(), name,
            kWidth, kHeight, threshold_px, best.kernels,
            1.0 - static_cast<double>(best.kernels) / static_cast<double>(std::max<size_t>(1, whole.kernels)),
            threshold_px == 0 ? 999.0 : psnr_db(some.image, all.image), best.cpu_ms,
            best.cpu_ms / whole.cpu_ms);
      }
      std::fflush(stdout);
    }
  }
}

void measure_caps() {
  std::printf("asset,kernels,view,width,height,cap_of_longer_side,psnr_db,cpu_ms,time_share\n");
  for (const Thing& thing : things()) {
    const CloudExtent extent = extent_of(thing.posed);
    for (const auto& [name, camera] : named_views(extent)) {
      Rasteriser rasteriser;
      RasterisedView all, some;
      double whole_ms = 0;
      for (const float cap : {0.0f, 4.0f, 2.0f, 1.0f, 0.5f, 0.25f}) {
        Drawn best;
        for (int i = 0; i < 3; ++i) {
          const Drawn once = draw(rasteriser, thing.drawn(), camera, 0, cap * kWidth, cap == 0 ? all : some);
          if (i == 0 || once.cpu_ms < best.cpu_ms) best = once;
        }
        if (cap == 0) whole_ms = best.cpu_ms;
        std::printf("%s,%zu,%s,%d,%d,%g,%.1f,%.1f,%.2f\n", thing.name.c_str(), thing.asset.size(), name,
                    kWidth, kHeight, cap, cap == 0 ? 999.0 : std::min(999.0, psnr_db(some.image, all.image)),
                    best.cpu_ms, best.cpu_ms / whole_ms);
      }
      std::fflush(stdout);
    }
  }
}

// PSNR against the picture sorted by depth, as in the training of the captured assets. Sort keys: distance
// from the eye; distance from a point 32 mm aside, shared by two eyes, for an object of 0.3 m; and depth for
// a head turned by 5 and by 30 degrees, which does not affect sorting by distance.
void measure_orders() {
  std::printf("asset,kernels,view,distance_db,distance_aside_db,turned_5_degrees_db,turned_30_degrees_db\n");
  for (const Thing& thing : things()) {
    const CloudExtent extent = extent_of(thing.posed);
    for (const View view : {View::Front, View::Close, View::Inside}) {
      const Camera camera = view_of(extent, view, kWidth, kHeight);
      const Pose& eye = camera.world_from_camera;
      Rasteriser rasteriser;
      const auto drawn = [&](const Eigen::Vector3d& from_m) {
        RasteriseOptions options;
        options.background = kBackground;
        options.order = DepthOrder::Distance;
        options.distance_from_m = from_m;
        RasterisedView picture;
        const DrawnObject object = thing.drawn();
        rasteriser.draw({&object, 1}, camera, options, picture);
        return picture.image;
      };
      // Sorting by depth equals sorting by distance from a point far behind the camera.
      const auto by_depth = [&](double turned_rad) {
        const Eigen::Vector3d back = eye.orientation *
                                     Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitY()) *
                                     Eigen::Vector3d::UnitZ();
        return drawn(eye.position_m + 300 * extent.size_m * back);
      };
      const Image depth = by_depth(0), distance = drawn(eye.position_m);
      const Image aside =
          drawn(eye.position_m + eye.orientation * Eigen::Vector3d(0.032 / 0.3 * extent.size_m, 0, 0));
      std::printf("%s,%zu,%s,%.1f,%.1f,%.1f,%.1f\n", thing.name.c_str(), thing.asset.size(), name_of(view),
                  psnr_db(distance, depth), psnr_db(aside, depth), psnr_db(by_depth(5 * M_PI / 180), depth),
                  psnr_db(by_depth(30 * M_PI / 180), depth));
      std::fflush(stdout);
    }
  }
}

// The camera moves from three times the size into the middle of an object and stays there, with the
// resolution and the budget of the window.
constexpr int kLeanWidth = 1280, kLeanHeight = 800;
constexpr double kBudget_ms = 30;
struct LeanPictures {
  int coming, staying;
};
constexpr LeanPictures kManyPictures{60, 15},
    kFewPictures{16, 6};  // the latter for software devices, which take up to a second per picture

struct Mode {
  const char* name;
  bool scales, leaves_out, holds;
};
// The last mode is that of SceneView.
constexpr Mode kModes[] = {{"neither", false, false, false},
                           {"resolution", true, false, false},
                           {"both", true, true, false},
                           {"radius too", true, true, true}};

void lean_into(SplatRenderer& renderer, const Thing& thing, const Mode& mode, const LeanPictures& pictures) {
  const CloudExtent extent = extent_of(thing.posed);
  static uint64_t version = 0;
  ++version;
  const RenderedObject object{thing.drawn(), version, version};
  RenderScale scale(kBudget_ms);
  std::vector<Image> images;
  RenderOptions options;
  options.background = kBackground;
  options.order = DepthOrder::Distance;
  for (int frame = -2; frame < pictures.coming + pictures.staying; ++frame) {
    const double along = std::clamp(static_cast<double>(frame) / (pictures.coming - 1), 0.0, 1.0);
    const double distance = 3.0 * (1.0 - along) + 0.02 * along;
    const int width = mode.scales ? scale.of(kLeanWidth) : kLeanWidth;
    const int height = mode.scales ? scale.of(kLeanHeight) : kLeanHeight;
    options.min_contribution_px = mode.leaves_out ? scale.min_contribution_px() : 0.0f;
    if (mode.holds)
      options.max_radius_px =
          static_cast<float>((options.min_contribution_px > 0 ? 1 : 2) * std::max(width, height));
    const Camera camera = seen_from(extent, distance, width, height);
    if (auto drawn = renderer.draw({&object, 1}, {&camera, 1}, options, images); !drawn) {
      std::fprintf(stderr, "%s: %s\n", renderer.name().c_str(), drawn.error().message.c_str());
      return;
    }
    const double ms = renderer.last_times().total_ms();
    if (frame >= 0) {  // negative frames are a warm-up
      std::printf("%s,%s,%d,%.3f,%.3f,%.2f,%.1f,%.0f\n", thing.name.c_str(), mode.name, frame, distance,
                  mode.scales ? scale.value() : 1.0, options.min_contribution_px, ms, kBudget_ms);
      scale.drew(ms);
    }
  }
  std::fflush(stdout);
}

int measure_lean(bool vulkan) {
  auto renderer = create_cpu_renderer();
  LeanPictures pictures = kManyPictures;
  if (vulkan) {
    auto device = VulkanDevice::create();
    if (device && (*device)->is_software()) pictures = kFewPictures;
    auto made =
        device ? create_vulkan_renderer(*device) : Result<std::unique_ptr<SplatRenderer>>(device.error());
    if (!made) {
      std::fprintf(stderr, "cull_bench: %s\n", made.error().message.c_str());
      return 1;
    }
    renderer = *std::move(made);
  }
  std::printf("# %s, %d x %d\nasset,mode,frame,distance_of_size,scale,threshold_px,picture_ms,budget_ms\n",
              renderer->name().c_str(), kLeanWidth, kLeanHeight);
  for (const Thing& thing : things()) {
    for (const Mode& mode : kModes) lean_into(*renderer, thing, mode, pictures);
  }
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "lean") return livegs::measure_lean(argc > 2 && std::string(argv[2]) == "vulkan");
  if (what == "order")
    livegs::measure_orders();
  else if (what == "cap")
    livegs::measure_caps();
  else
    livegs::measure_thresholds();
  return 0;
}
