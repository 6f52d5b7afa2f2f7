// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/shape_asset.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation_between.h"

namespace livegs {
namespace {

constexpr float kShDc = 0.28209479f;   // Y_00
constexpr float kOpacityLogit = 3.5f;  // 0.97
constexpr float kFlatness = 0.12f;     // thickness of a surface kernel relative to its width

Eigen::Vector3f dc_from_rgb(const Eigen::Vector3f& rgb) { return (rgb.array() - 0.5f).matrix() / kShDc; }

// Returns the n-th point of the R2 low-discrepancy sequence (Roberts 2018). Needs no seed.
Eigen::Vector2d even_point(size_t n) {
  constexpr double kPlastic = 1.32471795724474602596;
  const double u = 0.5 + static_cast<double>(n) / kPlastic,
               v = 0.5 + static_cast<double>(n) / (kPlastic * kPlastic);
  return {u - std::floor(u), v - std::floor(v)};
}

}  // namespace

GaussianAsset mesh_asset(const TriangleMesh& mesh, const Eigen::Vector3f& rgb, size_t kernel_count) {
  std::vector<double> area_up_to;
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area +=
        0.5 * (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]).norm();
    area_up_to.push_back(area);
  }
  GaussianAsset asset;
  asset.resize(kernel_count);
  const float width =
      static_cast<float>(0.75 * std::sqrt(area / static_cast<double>(std::max<size_t>(kernel_count, 1))));
  const Eigen::Vector3d light = Eigen::Vector3d(0.4, 0.8, 0.45).normalized();
  for (size_t i = 0; i < kernel_count; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(kernel_count) * area;
    const size_t triangle = static_cast<size_t>(std::min<std::ptrdiff_t>(
        std::lower_bound(area_up_to.begin(), area_up_to.end(), at) - area_up_to.begin(),
        static_cast<std::ptrdiff_t>(area_up_to.size()) - 1));
    const auto& [a, b, c] = mesh.triangles[triangle];
    Eigen::Vector2d st = even_point(i);
    if (st.x() + st.y() > 1.0) st = Eigen::Vector2d::Ones() - st;
    const Eigen::Vector3d &pa = mesh.vertices_m[a], &pb = mesh.vertices_m[b], &pc = mesh.vertices_m[c];
    const Eigen::Vector3d normal = (pb - pa).cross(pc - pa).normalized();
    // Offset inwards by the kernel's thickness, so that the visible surface coincides with the mesh.
    const Eigen::Vector3d point = pa + st.x() * (pb - pa) + st.y() * (pc - pa) - kFlatness * width * normal;
    asset.positions[i] = point.cast<float>();
    asset.log_scales[i] = Eigen::Vector3f(std::log(width), std::log(width), std::log(kFlatness * width));
    asset.rotations[i] = rotation_between(Eigen::Vector3d::UnitZ(), normal).cast<float>();
    asset.opacity_logits[i] = kOpacityLogit;
    const float shade =
        static_cast<float>(0.55 + 0.25 * std::max(0.0, normal.dot(light)) + 0.2 * (0.5 + 0.5 * normal.y()));
    asset.sh_dc[i] = dc_from_rgb(rgb * shade);
  }
  return asset;
}

GaussianAsset point_asset(std::span<const Eigen::Vector3d> points_m, double spacing_m,
                          const Eigen::Vector3f& rgb) {
  GaussianAsset asset;
  asset.resize(points_m.size());
  const float log_scale = static_cast<float>(std::log(std::max(0.5 * spacing_m, 1e-6)));
  for (size_t i = 0; i < points_m.size(); ++i) {
    asset.positions[i] = points_m[i].cast<float>();
    asset.log_scales[i] = Eigen::Vector3f::Constant(log_scale);
    asset.rotations[i] = Eigen::Quaternionf::Identity();
    asset.opacity_logits[i] = kOpacityLogit;
    asset.sh_dc[i] = dc_from_rgb(rgb);
  }
  return asset;
}

Eigen::Vector3f palette_rgb(size_t index) {
  // Hues are a golden angle apart, at constant lightness.
  const double hue = 0.07 + 0.61803398875 * static_cast<double>(index);
  Eigen::Vector3f rgb;
  for (int channel = 0; channel < 3; ++channel) {
    rgb[channel] = static_cast<float>(0.58 + 0.27 * std::cos(6.283185307 * (hue - channel / 3.0)));
  }
  return rgb;
}

}  // namespace livegs
