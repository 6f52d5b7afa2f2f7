// SPDX-License-Identifier: Apache-2.0
// Zwicker et al. 2001, EWA splatting, equations 26-31; the derivatives are those of Ye and Kanazawa 2023,
// Mathematical Supplement for the gsplat Library, extended by the clamped slopes and the view direction.
#include "train/render/project_trained.h"

#include <algorithm>
#include <cmath>

#include "gaussian/spherical_harmonics.h"

namespace livegs {
namespace {

constexpr double kHalfLog2e = 0.72134752044448170;  // exp(-x/2) = 2^(-kHalfLog2e x)

using Rows = Eigen::Matrix<double, 2, 3>;

// Steps of the projection that the way back needs again.
struct Steps {
  Eigen::Vector3d offset;    // from the camera, world axes
  Eigen::Vector3d t;         // image axes
  double held_x, held_y;     // slopes within the limits of the Jacobian
  bool free_x, free_y;       // not at a limit
  Rows m;                    // screen from world
  Eigen::Matrix3d rotation;  // world from kernel
  double norm;               // of the quaternion
  Eigen::Vector3d scale;
  double xx, xy, yy, det;  // covariance on the screen with the low-pass
  double opacity, fade;    // opacity without the fade near the camera
};

Eigen::Matrix3d rotation_of(double w, double x, double y, double z) {
  Eigen::Matrix3d r;
  r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return r;
}

bool place(const Projection& projection, const KernelParameters& parameters, size_t kernel, Steps& s) {
  s.offset = Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::Position, kernel)).cast<double>() -
             projection.position_m;
  const auto& axes = projection.image_from_world;
  s.t.z() = axes.row(2).dot(s.offset);
  if (!(s.t.z() > projection.near_m)) return false;
  s.t.x() = axes.row(0).dot(s.offset);
  s.t.y() = axes.row(1).dot(s.offset);
  const double slope_x = s.t.x() / s.t.z(), slope_y = s.t.y() / s.t.z();
  s.held_x = std::clamp(slope_x, projection.min_slope_x, projection.max_slope_x);
  s.held_y = std::clamp(slope_y, projection.min_slope_y, projection.max_slope_y);
  s.free_x = s.held_x == slope_x;
  s.free_y = s.held_y == slope_y;
  s.m.row(0) = (projection.focal_x_px / s.t.z()) * (axes.row(0) - s.held_x * axes.row(2));
  s.m.row(1) = (projection.focal_y_px / s.t.z()) * (axes.row(1) - s.held_y * axes.row(2));
  const float* q = parameters.row(Family::Rotation, kernel);
  s.norm = std::sqrt(double{q[0]} * q[0] + double{q[1]} * q[1] + double{q[2]} * q[2] + double{q[3]} * q[3]);
  if (!(s.norm > 1e-20)) return false;
  s.rotation = rotation_of(q[0] / s.norm, q[1] / s.norm, q[2] / s.norm, q[3] / s.norm);
  const float* log_scale = parameters.row(Family::LogScale, kernel);
  for (int i = 0; i < 3; ++i) s.scale[i] = std::exp(double{log_scale[i]});
  const Rows root = s.m * s.rotation * s.scale.asDiagonal();
  const double sharp_xx = root.row(0).squaredNorm(), sharp_yy = root.row(1).squaredNorm();
  s.xy = root.row(0).dot(root.row(1));
  const double sharp_det = std::max(0.0, sharp_xx * sharp_yy - s.xy * s.xy);
  s.xx = sharp_xx + kLowPassPx2;
  s.yy = sharp_yy + kLowPassPx2;
  s.det = sharp_det + kLowPassPx2 * (sharp_xx + sharp_yy) + kLowPassPx2 * kLowPassPx2;
  if (!std::isfinite(s.det) || !std::isfinite(s.xx) || !std::isfinite(s.yy)) return false;
  s.opacity = 1 / (1 + std::exp(-double{*parameters.row(Family::Opacity, kernel)}));
  s.fade = projection.near_m > 0 ? std::min(1.0, (s.t.z() - projection.near_m) / (2 * projection.near_m)) : 1;
  return true;
}

// Derivatives of the bands 1..degree by the direction, each row one band (spherical_harmonics.cpp).
void harmonics_slopes(const Eigen::Vector3d& direction, int degree, double (*slope)[3]) {
  const double x = direction.x(), y = direction.y(), z = direction.z();
  const auto set = [&](int band, double dx, double dy, double dz) {
    slope[band][0] = dx;
    slope[band][1] = dy;
    slope[band][2] = dz;
  };
  if (degree < 1) return;
  constexpr double k1 = 0.48860251;
  set(0, 0, -k1, 0);
  set(1, 0, 0, k1);
  set(2, -k1, 0, 0);
  if (degree < 2) return;
  constexpr double k2 = 1.09254843, k20 = 0.31539157, k22 = 0.54627422;
  set(3, k2 * y, k2 * x, 0);
  set(4, 0, -k2 * z, -k2 * y);
  set(5, -2 * k20 * x, -2 * k20 * y, 4 * k20 * z);
  set(6, -k2 * z, 0, -k2 * x);
  set(7, 2 * k22 * x, -2 * k22 * y, 0);
  if (degree < 3) return;
  const double xx = x * x, yy = y * y, zz = z * z;
  constexpr double k33 = 0.59004359, k32 = 2.89061144, k31 = 0.45704580, k30 = 0.37317633, k32c = 1.44530572;
  set(8, -6 * k33 * x * y, -k33 * (3 * xx - 3 * yy), 0);
  set(9, k32 * y * z, k32 * x * z, k32 * x * y);
  set(10, 2 * k31 * x * y, -k31 * (4 * zz - xx - 3 * yy), -8 * k31 * y * z);
  set(11, -6 * k30 * x * z, -6 * k30 * y * z, k30 * (6 * zz - 3 * xx - 3 * yy));
  set(12, -k31 * (4 * zz - 3 * xx - yy), 2 * k31 * x * y, -8 * k31 * x * z);
  set(13, 2 * k32c * x * z, -2 * k32c * y * z, k32c * (xx - yy));
  set(14, -k33 * (3 * xx - 3 * yy), 6 * k33 * x * y, 0);
}

// Colour without the clamp at 0.
Eigen::Vector3f free_colour(const KernelParameters& parameters, size_t kernel, int degree,
                            const float* bands) {
  Eigen::Vector3f sum = Eigen::Vector3f::Constant(0.5f) +
                        kShDc * Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::Colour, kernel));
  const float* rest = parameters.row(Family::Harmonics, kernel);
  const int count = (degree + 1) * (degree + 1) - 1;
  for (int k = 0; k < count; ++k) sum += bands[k] * Eigen::Map<const Eigen::Vector3f>(rest + 3 * k);
  return sum;
}

}  // namespace

bool project_trained(const Projection& projection, const KernelParameters& parameters, size_t kernel,
                     int sh_degree, const RenderCuts& cuts, ProjectedKernel& ellipse) {
  Steps s;
  if (!place(projection, parameters, kernel, s)) return false;
  const double opacity = s.opacity * s.fade;
  if (!(opacity >= cuts.min_alpha)) return false;
  const double centre_x = projection.focal_x_px * s.t.x() / s.t.z() + projection.centre_x_px;
  const double centre_y = projection.focal_y_px * s.t.y() / s.t.z() + projection.centre_y_px;
  const double rim = std::log(opacity / cuts.min_alpha) * 2;
  const double reach_x = std::sqrt(rim * s.xx), reach_y = std::sqrt(rim * s.yy);
  if (!(centre_x + reach_x >= 0 && centre_x - reach_x <= projection.width && centre_y + reach_y >= 0 &&
        centre_y - reach_y <= projection.height))
    return false;
  const double unit = std::sqrt(kHalfLog2e);
  ellipse = {};
  ellipse.centre_x_px = static_cast<float>(centre_x);
  ellipse.centre_y_px = static_cast<float>(centre_y);
  ellipse.across_x = static_cast<float>(unit * std::sqrt(s.yy / s.det));
  ellipse.across_y = static_cast<float>(-unit * s.xy / std::sqrt(s.yy * s.det));
  ellipse.down_y = static_cast<float>(unit / std::sqrt(s.yy));
  ellipse.log2_opacity = static_cast<float>(std::log2(opacity));
  ellipse.depth_m = static_cast<float>(s.t.z());
  ellipse.object_slot = static_cast<uint32_t>(kernel);
  float bands[15];
  evaluate_sh_bands(s.offset.normalized().cast<float>(), sh_degree, bands);
  const Eigen::Vector3f colour = free_colour(parameters, kernel, sh_degree, bands);
  ellipse.red = std::max(0.0f, colour.x());
  ellipse.green = std::max(0.0f, colour.y());
  ellipse.blue = std::max(0.0f, colour.z());
  return std::isfinite(ellipse.centre_x_px) && std::isfinite(ellipse.centre_y_px);
}

CameraGradient project_backward(const Projection& projection, const KernelParameters& parameters,
                                size_t kernel, int sh_degree, const EllipseGradient& g,
                                KernelParameters& gradient) {
  Steps s;
  if (!place(projection, parameters, kernel, s)) return {};
  const double z = s.t.z();
  const auto& axes = projection.image_from_world;

  // The inverse covariance K = [[a, b], [b, c]]. alpha = opacity exp(-dᵀ K d / 2), so dL/dcentre = K sum(G d)
  // and dL/dS = K sum(G d dᵀ) K / 2.
  const double a = s.yy / s.det, b = -s.xy / s.det, c = s.xx / s.det;
  const double centre_x = a * g.x + b * g.y, centre_y = b * g.x + c * g.y;
  const double left_xx = a * g.xx + b * g.xy, left_xy = a * g.xy + b * g.yy;
  const double left_yx = b * g.xx + c * g.xy, left_yy = b * g.xy + c * g.yy;
  const double s_xx = 0.5 * (left_xx * a + left_xy * b), s_xy = 0.5 * (left_xx * b + left_xy * c);
  const double s_yy = 0.5 * (left_yx * b + left_yy * c);

  // S = N Nᵀ + low-pass with N = M R diag(scale): dN = 2 dS N.
  const Rows rotated = s.m * s.rotation;
  Rows n_gradient;  // by M R diag(scale), divided by nothing
  for (int k = 0; k < 3; ++k) {
    const double nx = rotated(0, k) * s.scale[k], ny = rotated(1, k) * s.scale[k];
    n_gradient(0, k) = 2 * (s_xx * nx + s_xy * ny);
    n_gradient(1, k) = 2 * (s_xy * nx + s_yy * ny);
  }
  float* log_scale = gradient.row(Family::LogScale, kernel);
  Rows rotated_gradient;  // by M R
  for (int k = 0; k < 3; ++k) {
    const double along = n_gradient(0, k) * rotated(0, k) + n_gradient(1, k) * rotated(1, k);
    log_scale[k] = static_cast<float>(along * s.scale[k]);
    rotated_gradient.col(k) = n_gradient.col(k) * s.scale[k];
  }
  const Eigen::Matrix3d r = s.m.transpose() * rotated_gradient;
  const Rows m_gradient = rotated_gradient * s.rotation.transpose();

  // Rotation of the unit quaternion, then the part across it.
  const float* q = parameters.row(Family::Rotation, kernel);
  const double w = q[0] / s.norm, x = q[1] / s.norm, y = q[2] / s.norm, v = q[3] / s.norm;
  const double by_w = 2 * (x * (r(2, 1) - r(1, 2)) + y * (r(0, 2) - r(2, 0)) + v * (r(1, 0) - r(0, 1)));
  const double by_x = 2 * (w * (r(2, 1) - r(1, 2)) + y * (r(0, 1) + r(1, 0)) + v * (r(0, 2) + r(2, 0)) -
                           2 * x * (r(1, 1) + r(2, 2)));
  const double by_y = 2 * (w * (r(0, 2) - r(2, 0)) + x * (r(0, 1) + r(1, 0)) + v * (r(1, 2) + r(2, 1)) -
                           2 * y * (r(0, 0) + r(2, 2)));
  const double by_z = 2 * (w * (r(1, 0) - r(0, 1)) + x * (r(0, 2) + r(2, 0)) + y * (r(1, 2) + r(2, 1)) -
                           2 * v * (r(0, 0) + r(1, 1)));
  const double radial = w * by_w + x * by_x + y * by_y + v * by_z;
  float* rotation = gradient.row(Family::Rotation, kernel);
  rotation[0] = static_cast<float>((by_w - w * radial) / s.norm);
  rotation[1] = static_cast<float>((by_x - x * radial) / s.norm);
  rotation[2] = static_cast<float>((by_y - y * radial) / s.norm);
  rotation[3] = static_cast<float>((by_z - v * radial) / s.norm);

  // Position in image axes: the centre, the rows of M, the fade near the camera.
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  t.x() += projection.focal_x_px / z * centre_x;
  t.y() += projection.focal_y_px / z * centre_y;
  t.z() -=
      (projection.focal_x_px * s.t.x() * centre_x + projection.focal_y_px * s.t.y() * centre_y) / (z * z);
  t.z() -= (s.m.row(0).dot(m_gradient.row(0)) + s.m.row(1).dot(m_gradient.row(1))) / z;
  const double by_held_x = -projection.focal_x_px / z * axes.row(2).dot(m_gradient.row(0));
  const double by_held_y = -projection.focal_y_px / z * axes.row(2).dot(m_gradient.row(1));
  if (s.free_x) {
    t.x() += by_held_x / z;
    t.z() -= by_held_x * s.held_x / z;
  }
  if (s.free_y) {
    t.y() += by_held_y / z;
    t.z() -= by_held_y * s.held_y / z;
  }
  t.z() += double{g.depth};
  if (s.fade < 1) t.z() += g.sum / (z - projection.near_m);
  Eigen::Vector3d position = axes.transpose() * t;
  // A turn of the camera is the opposite turn of the kernel about it, without a change of the direction from
  // which it is seen.
  CameraGradient camera;
  camera.turn = -s.offset.cross(position);
  for (int k = 0; k < 3; ++k) camera.turn -= s.rotation.col(k).cross(r.col(k));

  *gradient.row(Family::Opacity, kernel) = static_cast<float>(g.sum * (1 - s.opacity));

  const double distance = s.offset.norm();
  const Eigen::Vector3d direction = s.offset / distance;
  float bands[15];
  evaluate_sh_bands(direction.cast<float>(), sh_degree, bands);
  const Eigen::Vector3f colour = free_colour(parameters, kernel, sh_degree, bands);
  const float by_colour[3] = {colour.x() > 0 ? g.red : 0, colour.y() > 0 ? g.green : 0,
                              colour.z() > 0 ? g.blue : 0};
  float* dc = gradient.row(Family::Colour, kernel);
  for (int i = 0; i < 3; ++i) dc[i] = kShDc * by_colour[i];
  if (sh_degree > 0) {
    double slopes[15][3];
    harmonics_slopes(direction, sh_degree, slopes);
    const float* rest = parameters.row(Family::Harmonics, kernel);
    float* by_rest = gradient.row(Family::Harmonics, kernel);
    const int count = (sh_degree + 1) * (sh_degree + 1) - 1;
    Eigen::Vector3d by_direction = Eigen::Vector3d::Zero();
    for (int k = 0; k < count; ++k) {
      double weight = 0;
      for (int i = 0; i < 3; ++i) {
        by_rest[3 * k + i] = bands[k] * by_colour[i];
        weight += double{rest[3 * k + i]} * by_colour[i];
      }
      by_direction += weight * Eigen::Map<const Eigen::Vector3d>(slopes[k]);
    }
    position += (by_direction - direction * direction.dot(by_direction)) / distance;
  }
  for (int i = 0; i < 3; ++i) gradient.row(Family::Position, kernel)[i] = static_cast<float>(position[i]);
  camera.position = -position;
  return camera;
}

}  // namespace livegs
