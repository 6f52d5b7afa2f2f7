// SPDX-License-Identifier: Apache-2.0
#include "common/train/run/small_capture.h"

#include <cmath>
#include <fstream>

#include "core/text/format_text.h"
#include "splat/rasterise.h"
#include "train/optimise/random_number.h"

namespace livegs {
namespace {

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

}  // namespace

void write_small_capture(const std::filesystem::path& folder, const SmallCapture& options) {
  GaussianAsset asset;
  asset.resize(options.kernels);
  PosedKernels posed;
  posed.resize(options.kernels);
  std::string points = format_text(
      "ply\nformat ascii 1.0\nelement vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      options.kernels);
  for (size_t k = 0; k < options.kernels; ++k) {
    const auto number = [&](uint64_t stream) { return static_cast<float>(random_share(11, stream, k)); };
    asset.positions[k] = Eigen::Vector3f(number(1) - 0.5f, number(2) - 0.5f, number(3) - 0.5f);
    asset.sh_dc[k] = 3.0f * Eigen::Vector3f(number(4) - 0.5f, number(5) - 0.5f, number(6) - 0.5f);
    asset.opacity_logits[k] = 2;
    asset.rotations[k] = Eigen::Quaternionf::Identity();
    const float deviation = 0.04f + 0.04f * number(7);
    if (options.floor) {
      asset.positions[k] = 2.4f * asset.positions[k].cwiseProduct(Eigen::Vector3f(1, 0, 1));
      asset.opacity_logits[k] = 4;
    }
    posed.positions_m[k] = asset.positions[k];
    posed.covariances_m2[k] = {deviation * deviation, 0, 0, deviation * deviation, 0, deviation * deviation};
    posed.world_from_asset[k] = Eigen::Quaternionf::Identity();
    const auto level = [&](int i) {
      return static_cast<int>(255 * std::min(1.0f, std::max(0.0f, 0.5f + 0.282f * asset.sh_dc[k][i])));
    };
    points += format_text("%.6f %.6f %.6f %d %d %d\n", asset.positions[k].x() + 0.01, asset.positions[k].y(),
                          asset.positions[k].z(), level(0), level(1), level(2));
  }
  std::string frames;
  std::filesystem::create_directories(folder / "images");
  for (size_t i = 0; i < options.views; ++i) {
    const double turn = 2 * M_PI * static_cast<double>(i) / static_cast<double>(options.views);
    const double height = options.floor ? 1.6 : 0.6 * std::sin(3 * turn);
    const Camera camera = look_at({2 * std::cos(turn), height, 2 * std::sin(turn)}, {0, 0, 0}, {0, 1, 0}, 0.7,
                                  options.width, options.height);
    const DrawnObject object{&asset, &posed, 1};
    Rasteriser rasteriser;
    RasterisedView view;
    RasteriseOptions draw;
    if (!options.transparent) draw.background = {0.3f, 0.4f, 0.5f};
    rasteriser.draw(std::span(&object, 1), camera, draw, view);
    if (options.transparent) {
      for (size_t p = 0; p < view.image.pixels.size(); p += 4) {
        // PNG has colours that are not multiplied with alpha.
        const float alpha = std::max(view.image.pixels[p + 3], 1e-6f);
        for (size_t c = 0; c < 3; ++c) view.image.pixels[p + c] /= alpha;
      }
    }
    const std::string name = format_text("images/%02zu.png", i);
    (void)write_png(folder / name, view.image, options.transparent);
    const Eigen::Matrix3d r = camera.world_from_camera.orientation.toRotationMatrix();
    const Eigen::Vector3d& p = camera.world_from_camera.position_m;
    frames += format_text(
        "%s{\"file_path\": \"%s\", \"transform_matrix\": [[%.9f,%.9f,%.9f,%.9f],[%.9f,%.9f,%.9f,%.9f],"
        "[%.9f,%.9f,%.9f,%.9f],[0,0,0,1]]}",
        i == 0 ? "" : ",\n", name.c_str(), r(0, 0), r(0, 1), r(0, 2), p.x(), r(1, 0), r(1, 1), r(1, 2), p.y(),
        r(2, 0), r(2, 1), r(2, 2), p.z());
    if (i == 0) {
      write_text(folder / "head.json",
                 format_text("{\"w\": %d, \"h\": %d, \"fl_x\": %.9f, \"fl_y\": %.9f, \"ply_file_path\": "
                             "\"points.ply\", \"frames\": [\n",
                             camera.width, camera.height, camera.focal_x_px, camera.focal_y_px));
    }
  }
  std::ifstream head(folder / "head.json");
  const std::string start((std::istreambuf_iterator<char>(head)), std::istreambuf_iterator<char>());
  std::filesystem::remove(folder / "head.json");
  write_text(folder / "transforms.json", start + frames + "\n]}\n");
  write_text(folder / "points.ply", points);
}

}  // namespace livegs
