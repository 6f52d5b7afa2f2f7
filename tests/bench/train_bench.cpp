// SPDX-License-Identifier: Apache-2.0
// Trains a capture with known depth and prints CSV: picture quality of held-out views, error of depth,
// shape of the kernels, time.
//
//   train_bench [CAPTURE] [--steps N] [--kernels N] [--shape needle|anisotropy|none] [--every N] [--ply FILE]
#include <png.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "capture/capture.h"
#include "compute/vulkan_backend.h"
#include "core/percentile.h"
#include "gaussian/asset_file.h"
#include "train/render/trained_view.h"
#include "train/trainer.h"

namespace livegs {
namespace {

// 16 or 8 bits of one channel; empty if the file cannot be read.
std::vector<uint16_t> read_grey(const std::filesystem::path& path, int& width, int& height) {
  FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) return {};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_info(png, info);
  png_set_expand_16(png);
  width = static_cast<int>(png_get_image_width(png, info));
  height = static_cast<int>(png_get_image_height(png, info));
  const bool deep = png_get_bit_depth(png, info) == 16;
  png_set_swap(png);
  png_read_update_info(png, info);
  std::vector<uint16_t> values(static_cast<size_t>(width) * static_cast<size_t>(height));
  std::vector<png_bytep> rows;
  for (int y = 0; y < height; ++y)
    rows.push_back(reinterpret_cast<png_bytep>(&values[static_cast<size_t>(y) * static_cast<size_t>(width)]));
  png_read_image(png, rows.data());
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(file);
  if (!deep) {
    for (uint16_t& value : values) value /= 257;  // expanded from 8 bits
  }
  return values;
}

// Errors of depth where the mask is not 0 (table and objects), over the views with depth, mm. Pixels without
// a surface count as 1 m.
std::vector<double> depth_errors_mm(const Capture& capture, const KernelParameters& kernels, double near_m) {
  std::vector<double> errors;
  TrainedView drawing;
  for (const CapturedView& one : capture.views) {
    if (one.depth.empty() || one.mask.empty()) continue;
    int width = 0, height = 0;
    const std::vector<uint16_t> depth = read_grey(one.depth, width, height);
    const std::vector<uint16_t> mask = read_grey(one.mask, width, height);
    if (depth.size() != mask.size() || width != one.camera.width || height != one.camera.height) continue;
    TrainedViewOptions options;
    options.depth = true;
    Camera camera = one.camera;
    camera.near_m = near_m;
    drawing.draw(kernels, camera, options);
    for (size_t i = 0; i < depth.size(); ++i) {
      if (mask[i] == 0 || depth[i] == 0) continue;
      const double seen = drawing.depths()[i];
      errors.push_back(std::isfinite(seen) ? std::min(1000.0, std::abs(1000 * seen - depth[i])) : 1000.0);
    }
  }
  return errors;
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Ratios of the axes of kernels that can be seen: longest to middle, longest to shortest.
void axis_ratios(const KernelParameters& kernels, std::vector<double>& needle, std::vector<double>& flat) {
  for (size_t k = 0; k < kernels.size(); ++k) {
    if (*kernels.row(Family::Opacity, k) < -2.944f) continue;  // opacity 0.05
    const float* s = kernels.row(Family::LogScale, k);
    float axes[3] = {s[0], s[1], s[2]};
    std::sort(axes, axes + 3);
    needle.push_back(std::exp(double{axes[2]} - axes[1]));
    flat.push_back(std::exp(double{axes[2]} - axes[0]));
  }
}

int run(int argc, char** argv) {
  CLI::App app("Trains a capture and prints its scores as CSV");
  std::string folder = LIVEGS_SHARED_DATA_DIR "/multiview/ycb_tabletop", shape = "needle", device = "cpu",
              ply;
  TrainOptions options;
  options.steps = 2000;
  options.max_kernels = 20000;
  options.longest_px = 320;
  size_t every = 500;
  app.add_option("CAPTURE", folder, "Folder of photos with poses");
  app.add_option("--steps", options.steps, "Number of steps");
  app.add_option("--kernels", options.max_kernels, "Limit of kernels");
  app.add_option("--size", options.longest_px, "Longest edge of the photos, px");
  app.add_option("--shape", shape, "Shape loss")->check(CLI::IsMember({"needle", "anisotropy", "none"}));
  app.add_option("--shape-weight", options.shape.weight, "Weight of the shape loss");
  app.add_option("--limit", options.shape.limit, "Ratio of axes without a loss");
  app.add_option("--opacity-weight", options.shape.opacity_weight, "Weight of the mean opacity");
  app.add_option("--scale-weight", options.shape.scale_weight, "Weight of the mean axis");
  app.add_option("--position-rate", options.position_rate, "First rate of positions");
  app.add_option("--last-position-rate", options.last_position_rate, "Last rate of positions");
  app.add_option("--last-rate-share", options.last_rate_share, "Last share of the other rates");
  app.add_option("--spread-weight", options.spread_weight, "Weight of the spread of depths");
  app.add_option("--spread-edge", options.spread_edge, "Change of colour with half of that weight");
  app.add_option("--scale-rate", options.scale_rate, "Rate of axes");
  app.add_option("--rotation-rate", options.rotation_rate, "Rate of rotations");
  app.add_option("--opacity-rate", options.opacity_rate, "Rate of opacities");
  app.add_option("--colour-rate", options.colour_rate, "Rate of colours");
  app.add_option("--harmonics-rate", options.harmonics_rate, "Rate of harmonics");
  app.add_option("--grow-until", options.grow_until, "Share of the steps with densification");
  app.add_option("--harmonics-interval", options.harmonics_interval, "Share of the steps of a degree");
  app.add_option("--min-axis", options.min_axis_px, "Smallest axis, px");
  app.add_option("--device", device, "Where pictures are blended")->check(CLI::IsMember({"cpu", "vulkan"}));
  app.add_option("--every", every, "Steps between rows");
  app.add_option("--ply", ply, "Writes the kernels");
  CLI11_PARSE(app, argc, argv);
  options.shape.loss = shape == "none"     ? ShapeLoss::None
                       : shape == "needle" ? ShapeLoss::Needle
                                           : ShapeLoss::Anisotropy;

  const auto capture = read_capture(folder);
  if (!capture) return std::fprintf(stderr, "%s\n", capture.error().message.c_str()), 2;
  auto trainer = Trainer::start(*capture, options);
  if (!trainer) return std::fprintf(stderr, "%s\n", trainer.error().message.c_str()), 2;
  if (device == "vulkan") {
    auto found = VulkanDevice::create();
    if (!found) return std::fprintf(stderr, "%s\n", found.error().message.c_str()), 2;
    device = (*found)->name();
    std::replace(device.begin(), device.end(), ',', ';');
    auto backend = create_vulkan_backend(*std::move(found));
    if (!backend) return std::fprintf(stderr, "%s\n", backend.error().message.c_str()), 2;
    trainer->use_device(*std::move(backend));
  }
  std::printf(
      "device,shape,steps,limit_kernels,size_px,step,kernels,psnr_db,ssim,depth_median_mm,depth_p90_mm,"
      "longest_to_middle_p95,longest_to_middle_p99,longest_to_shortest_p50,longest_to_shortest_p99,"
      "cpu_s,wall_s\n");
  double cpu = 0, wall = 0;
  while (!trainer->done()) {
    const double cpu_begin = cpu_seconds();
    const auto begin = std::chrono::steady_clock::now();
    do {
      if (auto stepped = trainer->step(); !stepped)
        return std::fprintf(stderr, "%s\n", stepped.error().message.c_str()), 1;
    } while (!trainer->done() && trainer->steps_done() % every != 0);
    cpu += cpu_seconds() - cpu_begin;
    wall += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto score = trainer->score();
    if (!score) return std::fprintf(stderr, "%s\n", score.error().message.c_str()), 1;
    const std::vector<double> depth = depth_errors_mm(*capture, trainer->kernels(), 0.02 * trainer->extent());
    std::vector<double> needle, flat;
    axis_ratios(trainer->kernels(), needle, flat);
    std::printf("%s,%s,%zu,%zu,%d,%zu,%zu,%.2f,%.4f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f\n",
                device.c_str(), shape.c_str(), options.steps, options.max_kernels, options.longest_px,
                trainer->steps_done(), trainer->kernels().size(), score->psnr_db, score->ssim,
                percentile(depth, 0.5), percentile(depth, 0.9), percentile(needle, 0.95),
                percentile(needle, 0.99), percentile(flat, 0.5), percentile(flat, 0.99), cpu, wall);
    std::fflush(stdout);
  }
  if (!ply.empty()) {
    if (auto written = write_asset(ply, trainer->asset()); !written)
      return std::fprintf(stderr, "%s\n", written.error().message.c_str()), 1;
  }
  return 0;
}

}  // namespace
}  // namespace livegs

int main(int argc, char** argv) { return livegs::run(argc, argv); }
