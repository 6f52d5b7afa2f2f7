// SPDX-License-Identifier: Apache-2.0
#include "common/splat/raster/reference_renderer.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {
namespace {

// std::assoc_legendre has no Condon-Shortley sign; (-1)^m adds it.
double signed_legendre(int l, int m, double x) { return (m % 2 ? -1.0 : 1.0) * std::assoc_legendre(l, m, x); }

double factorial(int n) { return std::tgamma(n + 1.0); }

Eigen::Vector3d colour(const GaussianAsset& asset, size_t kernel, int max_degree,
                       const Eigen::Vector3d& direction) {
  Eigen::Vector3d sum = Eigen::Vector3d::Constant(0.5);
  sum += spherical_harmonic(0, 0, direction) * asset.sh_dc[kernel].cast<double>();
  const size_t stride = asset.sh_rest_count();
  size_t k = 0;
  for (int l = 1; l <= std::min(asset.sh_degree, max_degree); ++l) {
    for (int m = -l; m <= l; ++m, ++k) {
      sum += spherical_harmonic(l, m, direction) * asset.sh_rest[kernel * stride + k].cast<double>();
    }
  }
  return sum.cwiseMax(0.0);
}

}  // namespace

double spherical_harmonic(int l, int m, const Eigen::Vector3d& direction) {
  const int order = std::abs(m);
  const double azimuth = std::atan2(direction.y(), direction.x());
  const double scale =
      std::sqrt((2.0 * l + 1.0) / (4.0 * M_PI) * factorial(l - order) / factorial(l + order));
  const double legendre = signed_legendre(l, order, std::clamp(direction.z(), -1.0, 1.0));
  if (m == 0) return scale * legendre;
  return M_SQRT2 * scale * legendre * (m > 0 ? std::cos(order * azimuth) : std::sin(order * azimuth));
}

ReferenceRenderer::ReferenceRenderer(std::span<const DrawnObject> objects, const Camera& camera,
                                     const RasteriseOptions& options)
    : width_(camera.width), height_(camera.height), background_(options.background.cast<double>()) {
  Eigen::Matrix3d flip = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Matrix3d W = flip * camera.world_from_camera.orientation.toRotationMatrix().inverse();
  const Eigen::Vector3d T = -W * camera.world_from_camera.position_m;
  const double fx = camera.focal_x_px, fy = camera.focal_y_px;
  const double tan_x = 0.5 * width_ / fx, tan_y = 0.5 * height_ / fy;
  const double left = camera.centre_x_px / fx + 0.3 * tan_x;
  const double right = (width_ - camera.centre_x_px) / fx + 0.3 * tan_x;
  const double above = camera.centre_y_px / fy + 0.3 * tan_y;
  const double below = (height_ - camera.centre_y_px) / fy + 0.3 * tan_y;
  for (const DrawnObject& object : objects) {
    for (size_t i = 0; i < object.asset->size(); ++i) {
      const Eigen::Vector3d position = object.kernels->positions_m[i].cast<double>();
      const Eigen::Vector3d t = W * position + T;
      if (t.z() <= camera.near_m) continue;
      const double tx = std::clamp(t.x() / t.z(), -left, right) * t.z();
      const double ty = std::clamp(t.y() / t.z(), -above, below) * t.z();
      Eigen::Matrix<double, 2, 3> J;
      J << fx / t.z(), 0, -fx * tx / (t.z() * t.z()), 0, fy / t.z(), -fy * ty / (t.z() * t.z());
      const Symmetric3f& s = object.kernels->covariances_m2[i];
      Eigen::Matrix3d sigma;
      sigma << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
      const Eigen::Matrix2d sharp = J * W * sigma * W.transpose() * J.transpose();
      const Eigen::Matrix2d blurred = sharp + 0.3 * Eigen::Matrix2d::Identity();
      Kernel kernel;
      kernel.opacity = 1.0 / (1.0 + std::exp(-static_cast<double>(object.asset->opacity_logits[i])));
      kernel.opacity *= std::clamp((t.z() - camera.near_m) / (2.0 * camera.near_m), 0.0, 1.0);
      if (object.asset->antialiased) {
        kernel.opacity *= std::sqrt(std::max(0.0, sharp.determinant() / blurred.determinant()));
      }
      kernel.centre_px = {fx * t.x() / t.z() + camera.centre_x_px, fy * t.y() / t.z() + camera.centre_y_px};
      kernel.conic = blurred.inverse();
      kernel.depth_m = t.z();
      kernel.order = options.order == DepthOrder::ViewZ ? t.z() : t.norm();
      const Eigen::Matrix3d world_from_asset =
          object.kernels->world_from_asset[i].cast<double>().normalized().toRotationMatrix();
      const Eigen::Vector3d view = (position - camera.world_from_camera.position_m).normalized();
      kernel.rgb = colour(*object.asset, i, options.max_sh_degree, world_from_asset.inverse() * view);
      kernels_.push_back(kernel);
    }
  }
  std::stable_sort(kernels_.begin(), kernels_.end(),
                   [](const Kernel& a, const Kernel& b) { return a.order < b.order; });
}

ReferenceRenderer::Pixel ReferenceRenderer::pixel(int x, int y) const {
  double transmittance = 1.0;
  Pixel result{Eigen::Vector3d::Zero(), 0.0, std::numeric_limits<double>::infinity()};
  for (const Kernel& kernel : kernels_) {
    const Eigen::Vector2d d = kernel.centre_px - Eigen::Vector2d(x + 0.5, y + 0.5);
    const double alpha = std::min(0.99, kernel.opacity * std::exp(-0.5 * d.dot(kernel.conic * d)));
    if (alpha < 1.0 / 255.0) continue;
    const double next = transmittance * (1.0 - alpha);
    if (next < 1e-4) break;
    result.rgb += kernel.rgb * alpha * transmittance;
    if (transmittance >= 0.5 && next < 0.5) result.depth_m = kernel.depth_m;
    transmittance = next;
  }
  result.rgb += transmittance * background_;
  result.coverage = 1.0 - transmittance;
  return result;
}

Image ReferenceRenderer::image() const {
  Image image{width_, height_, {}};
  image.pixels.resize(4 * static_cast<size_t>(width_) * height_);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Pixel value = pixel(x, y);
      float* rgba = image.at(x, y);
      for (int c = 0; c < 3; ++c) rgba[c] = static_cast<float>(value.rgb[c]);
      rgba[3] = static_cast<float>(value.coverage);
    }
  }
  return image;
}

}  // namespace livegs
