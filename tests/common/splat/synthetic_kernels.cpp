// SPDX-License-Identifier: Apache-2.0
#include "common/splat/synthetic_kernels.h"
#include "core/math/rotation_between.h"

#include <cmath>

namespace livegs::synthetic {
namespace {

constexpr double kShDc = 0.28209479177387814;

Eigen::Matrix3d matrix_of(const Symmetric3f& s) {
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return m;
}

Symmetric3f symmetric_of(const Eigen::Matrix3d& m) {
  return {static_cast<float>(m(0, 0)), static_cast<float>(m(0, 1)), static_cast<float>(m(0, 2)),
          static_cast<float>(m(1, 1)), static_cast<float>(m(1, 2)), static_cast<float>(m(2, 2))};
}

}  // namespace

double Random::uniform(double low, double high) {
  uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return low + (high - low) * (static_cast<double>(z >> 11) * 0x1p-53);
}

double Random::normal() {  // Box and Muller 1958
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * M_PI * uniform());
}

Eigen::Vector3d Random::in_ball(double radius) {
  const double x = normal(), y = normal(), z = normal();
  return Eigen::Vector3d(x, y, z).normalized() * radius * std::cbrt(uniform());
}

Eigen::Quaterniond Random::rotation() {
  const double w = normal(), x = normal(), y = normal(), z = normal();
  return Eigen::Quaterniond(w, x, y, z).normalized();
}

Symmetric3f covariance(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& standard_deviations_m) {
  const Eigen::Matrix3d axes = rotation.toRotationMatrix() * standard_deviations_m.asDiagonal();
  return symmetric_of(axes * axes.transpose());
}

void add_kernel(Object& object, const Eigen::Vector3d& position_m, const Eigen::Quaterniond& rotation,
                const Eigen::Vector3d& standard_deviations_m, double opacity, const Eigen::Vector3d& rgb) {
  GaussianAsset& asset = object.asset;
  asset.positions.push_back(position_m.cast<float>());
  asset.log_scales.push_back(standard_deviations_m.array().log().matrix().cast<float>());
  asset.rotations.push_back(rotation.cast<float>());
  asset.opacity_logits.push_back(static_cast<float>(std::log(opacity / (1.0 - opacity))));
  asset.sh_dc.push_back(((rgb.array() - 0.5) / kShDc).matrix().cast<float>());
  asset.sh_rest.resize(asset.size() * asset.sh_rest_count(), Eigen::Vector3f::Zero());
  object.posed.positions_m.push_back(position_m.cast<float>());
  object.posed.covariances_m2.push_back(covariance(rotation, standard_deviations_m));
  object.posed.world_from_asset.push_back(Eigen::Quaternionf::Identity());
}

void add_ball(Object& object, const Eigen::Vector3d& position_m, double standard_deviation_m, double opacity,
              const Eigen::Vector3d& rgb) {
  add_kernel(object, position_m, Eigen::Quaterniond::Identity(),
             Eigen::Vector3d::Constant(standard_deviation_m), opacity, rgb);
}

Object shell(size_t count, int sh_degree, double standard_deviation_m, uint64_t seed) {
  Random random(seed);
  Object object;
  object.asset.sh_degree = sh_degree;
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d outwards = random.rotation() * Eigen::Vector3d::UnitX();
    const double size = standard_deviation_m * std::exp(0.6 * random.normal());
    const Eigen::Vector3d deviations(0.15 * size, size * random.uniform(0.5, 1.0), size);
    const double opacity = 1.0 / (1.0 + std::exp(-(1.5 + 2.0 * random.normal())));
    const Eigen::Vector3d rgb(random.uniform(), random.uniform(), random.uniform());
    const Eigen::Vector3d position = outwards * (0.5 + 0.02 * random.normal());
    const Eigen::Quaterniond flat = rotation_between(Eigen::Vector3d::UnitX(), outwards);
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(random.uniform(0, M_PI), Eigen::Vector3d::UnitX()));
    add_kernel(object, position, flat * turned, deviations, opacity, rgb);
  }
  for (Eigen::Vector3f& coefficient : object.asset.sh_rest) {
    for (int c = 0; c < 3; ++c) coefficient[c] = static_cast<float>(0.1 * random.normal());
  }
  return object;
}

Object moved(const Object& object, const Pose& motion) {
  Object result = object;
  const Eigen::Matrix3d turn = motion.orientation.toRotationMatrix();
  for (size_t i = 0; i < object.size(); ++i) {
    result.posed.positions_m[i] = (motion * object.posed.positions_m[i].cast<double>()).cast<float>();
    result.posed.covariances_m2[i] =
        symmetric_of(turn * matrix_of(object.posed.covariances_m2[i]) * turn.transpose());
    result.posed.world_from_asset[i] =
        (motion.orientation * object.posed.world_from_asset[i].cast<double>()).cast<float>();
  }
  return result;
}

}  // namespace livegs::synthetic
