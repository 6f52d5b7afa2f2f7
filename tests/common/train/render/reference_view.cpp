// SPDX-License-Identifier: Apache-2.0
#include "common/train/render/reference_view.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livegs {
namespace {

struct ReferenceEllipse {
  bool visible = false;
  double x = 0, y = 0, z = 0, opacity = 0;
  Eigen::Matrix2d inverse;
  Eigen::Vector3d colour;
};

// Real spherical harmonics with the signs of 3DGS files, written out from their polynomials.
Eigen::Vector3d reference_colour(const double* dc, const double* rest, int degree, const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z();
  const double bands[15] = {-0.48860251 * y,
                            0.48860251 * z,
                            -0.48860251 * x,
                            1.09254843 * x * y,
                            -1.09254843 * y * z,
                            0.31539157 * (2 * z * z - x * x - y * y),
                            -1.09254843 * x * z,
                            0.54627422 * (x * x - y * y),
                            -0.59004359 * y * (3 * x * x - y * y),
                            2.89061144 * x * y * z,
                            -0.45704580 * y * (4 * z * z - x * x - y * y),
                            0.37317633 * z * (2 * z * z - 3 * x * x - 3 * y * y),
                            -0.45704580 * x * (4 * z * z - x * x - y * y),
                            1.44530572 * z * (x * x - y * y),
                            -0.59004359 * x * (x * x - 3 * y * y)};
  Eigen::Vector3d colour(0.5, 0.5, 0.5);
  for (int i = 0; i < 3; ++i) {
    colour[i] += 0.28209479 * dc[i];
    for (int k = 0; k < (degree + 1) * (degree + 1) - 1; ++k) colour[i] += bands[k] * rest[3 * k + i];
    colour[i] = std::max(0.0, colour[i]);
  }
  return colour;
}

ReferenceEllipse reference_ellipse(const ReferenceKernels& kernels, size_t k, const Camera& camera,
                                   int degree) {
  const auto row = [&](Family family) {
    const auto f = static_cast<size_t>(family);
    return kernels.families[f].data() + k * kFamilyWidth[f];
  };
  ReferenceEllipse e;
  const Eigen::Matrix3d image_from_world =
      Eigen::Vector3d(1, -1, -1).asDiagonal() *
      camera.world_from_camera.orientation.toRotationMatrix().transpose();
  const Eigen::Vector3d offset =
      Eigen::Map<const Eigen::Vector3d>(row(Family::Position)) - camera.world_from_camera.position_m;
  const Eigen::Vector3d t = image_from_world * offset;
  e.z = t.z();
  if (e.z <= camera.near_m) return e;
  e.visible = true;
  e.x = camera.focal_x_px * t.x() / t.z() + camera.centre_x_px;
  e.y = camera.focal_y_px * t.y() / t.z() + camera.centre_y_px;
  const double left = -(camera.centre_x_px + 0.15 * camera.width) / camera.focal_x_px;
  const double right = (1.15 * camera.width - camera.centre_x_px) / camera.focal_x_px;
  const double top = -(camera.centre_y_px + 0.15 * camera.height) / camera.focal_y_px;
  const double bottom = (1.15 * camera.height - camera.centre_y_px) / camera.focal_y_px;
  const double slope_x = std::clamp(t.x() / t.z(), left, right),
               slope_y = std::clamp(t.y() / t.z(), top, bottom);
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << camera.focal_x_px / t.z(), 0, -camera.focal_x_px * slope_x / t.z(), 0,
      camera.focal_y_px / t.z(), -camera.focal_y_px * slope_y / t.z();
  const double* q = row(Family::Rotation);
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const double* s = row(Family::LogScale);
  const Eigen::Vector3d variance(std::exp(2 * s[0]), std::exp(2 * s[1]), std::exp(2 * s[2]));
  const Eigen::Matrix3d covariance = rotation * variance.asDiagonal() * rotation.transpose();
  const Eigen::Matrix<double, 2, 3> m = jacobian * image_from_world;
  const Eigen::Matrix2d screen = m * covariance * m.transpose() + 0.3 * Eigen::Matrix2d::Identity();
  e.inverse << screen(1, 1), -screen(0, 1), -screen(1, 0), screen(0, 0);
  e.inverse /= screen(0, 0) * screen(1, 1) - screen(0, 1) * screen(1, 0);
  e.opacity = 1 / (1 + std::exp(-*row(Family::Opacity)));
  if (camera.near_m > 0) e.opacity *= std::min(1.0, (t.z() - camera.near_m) / (2 * camera.near_m));
  e.colour = reference_colour(row(Family::Colour), row(Family::Harmonics), degree, offset.normalized());
  return e;
}

}  // namespace

ReferenceKernels::ReferenceKernels(const KernelParameters& parameters) {
  for (size_t f = 0; f < kFamilies; ++f)
    families[f].assign(parameters.families[f].begin(), parameters.families[f].end());
}

ReferencePicture reference_view(const ReferenceKernels& kernels, const Camera& camera,
                                const TrainedViewOptions& options) {
  std::vector<ReferenceEllipse> ellipses;
  for (size_t k = 0; k < kernels.families[3].size(); ++k)
    ellipses.push_back(reference_ellipse(kernels, k, camera, options.sh_degree));
  std::vector<size_t> order(ellipses.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return ellipses[a].z < ellipses[b].z; });
  ReferencePicture picture;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Eigen::Vector3d colour(0, 0, 0);
      double through = 1, spread = 0;
      std::vector<std::pair<double, double>> seen;  // weight, depth
      for (size_t k : order) {
        const ReferenceEllipse& e = ellipses[k];
        if (!e.visible) continue;
        const Eigen::Vector2d d(x + 0.5 - e.x, y + 0.5 - e.y);
        const double alpha = std::min(double{kMaxAlpha}, e.opacity * std::exp(-0.5 * d.dot(e.inverse * d)));
        if (alpha < options.cuts.min_alpha) continue;
        if (through * (1 - alpha) < options.cuts.min_transmittance) break;
        for (const auto& [weight, z] : seen) spread += 2 * weight * through * alpha * std::abs(e.z - z);
        seen.push_back({through * alpha, e.z});
        colour += through * alpha * e.colour;
        through *= 1 - alpha;
      }
      colour += through * options.background.cast<double>();
      picture.red.push_back(colour.x());
      picture.green.push_back(colour.y());
      picture.blue.push_back(colour.z());
      picture.alpha.push_back(1 - through);
      picture.spread.push_back(spread);
    }
  }
  return picture;
}

}  // namespace livegs
