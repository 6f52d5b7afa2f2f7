// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/particle_fit.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "core/math/nearest_rotation.h"

namespace livegs::study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Particles of one set moved from `rest_m` to `now_m`, and their mean positions.
struct Pairs {
  std::vector<Vector3d> rest_m, now_m;
  Vector3d rest_mean_m = Vector3d::Zero(), now_mean_m = Vector3d::Zero();

  void add(const Vector3d& rest, const Vector3d& now) {
    rest_m.push_back(rest);
    now_m.push_back(now);
  }
  void close() {
    for (size_t i = 0; i < rest_m.size(); ++i) {
      rest_mean_m += rest_m[i] / static_cast<double>(rest_m.size());
      now_mean_m += now_m[i] / static_cast<double>(rest_m.size());
    }
  }
};

Pairs pairs_in(const ElasticBody& body, const ParticleSet& rest, const RestBox& box) {
  const std::vector<ParticleState> now = body.particles();
  Pairs pairs;
  for (size_t i = 0; i < now.size(); ++i) {
    const Vector3d& p = rest.positions_m[i];
    if ((p.array() < box.min_m.array()).any() || (p.array() > box.max_m.array()).any()) continue;
    pairs.add(p, now[i].position_m);
  }
  pairs.close();
  return pairs;
}

}  // namespace

Matrix3d mean_deformation(const ElasticBody& body, const ParticleSet& rest, const RestBox& box) {
  const Pairs pairs = pairs_in(body, rest, box);
  Matrix3d moved = Matrix3d::Zero(), still = Matrix3d::Zero();
  for (size_t i = 0; i < pairs.rest_m.size(); ++i) {
    const Vector3d r = pairs.rest_m[i] - pairs.rest_mean_m;
    moved += (pairs.now_m[i] - pairs.now_mean_m) * r.transpose();
    still += r * r.transpose();
  }
  return moved * still.inverse();
}

Vector3d face_to_face(const ElasticBody& body, const ParticleSet& rest) {
  Vector3d low = rest.positions_m[0], high = low;
  for (const Vector3d& p : rest.positions_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double layer_m = 0.25 * rest.spacing_m;
  Vector3d stretches;
  for (int d = 0; d < 3; ++d) {
    RestBox first{low, high}, last{low, high};
    first.min_m.array() -= layer_m;
    last.max_m.array() += layer_m;
    first.max_m.array() += layer_m;
    last.min_m.array() -= layer_m;
    first.max_m[d] = low[d] + layer_m;
    last.min_m[d] = high[d] - layer_m;
    stretches[d] = (pairs_in(body, rest, last).now_mean_m - pairs_in(body, rest, first).now_mean_m).norm() /
                   (high[d] - low[d]);
  }
  return stretches;
}

double twist_rate_rad_m(const ElasticBody& body, const ParticleSet& rest, const RestBox& box) {
  const Pairs all = pairs_in(body, rest, box);
  std::map<int64_t, Pairs> sections;  // by x in micrometres
  for (size_t i = 0; i < all.rest_m.size(); ++i) {
    sections[std::llround(1e6 * all.rest_m[i].x())].add(all.rest_m[i], all.now_m[i]);
  }
  std::vector<Vector3d> turned;  // x, angle, unused
  for (auto& [x, section] : sections) {
    section.close();
    double sine = 0.0, cosine = 0.0;
    for (size_t i = 0; i < section.rest_m.size(); ++i) {
      const Vector3d r = section.rest_m[i] - section.rest_mean_m, n = section.now_m[i] - section.now_mean_m;
      sine += r.y() * n.z() - r.z() * n.y();
      cosine += r.y() * n.y() + r.z() * n.z();
    }
    double angle = std::atan2(sine, cosine);
    if (!turned.empty()) angle += 2 * M_PI * std::round((turned.back().y() - angle) / (2 * M_PI));
    turned.push_back({section.rest_mean_m.x(), angle, 0.0});
  }
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& t : turned) mean += t / static_cast<double>(turned.size());
  double above = 0.0, below = 0.0;
  for (const Vector3d& t : turned) {
    above += (t.x() - mean.x()) * (t.y() - mean.y());
    below += (t.x() - mean.x()) * (t.x() - mean.x());
  }
  return above / below;
}

double distance_from_rest_shape_m(const ElasticBody& body, const ParticleSet& rest) {
  const double infinite = std::numeric_limits<double>::infinity();
  const Pairs pairs = pairs_in(body, rest, {Vector3d::Constant(-infinite), Vector3d::Constant(infinite)});
  Matrix3d match = Matrix3d::Zero();
  for (size_t i = 0; i < pairs.rest_m.size(); ++i) {
    match += (pairs.now_m[i] - pairs.now_mean_m) * (pairs.rest_m[i] - pairs.rest_mean_m).transpose();
  }
  if (!match.allFinite()) return infinite;
  const Matrix3d rotation = nearest_rotation(match);
  double sum = 0.0;
  for (size_t i = 0; i < pairs.rest_m.size(); ++i) {
    sum +=
        (pairs.now_m[i] - pairs.now_mean_m - rotation * (pairs.rest_m[i] - pairs.rest_mean_m)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pairs.rest_m.size()));
}

}  // namespace livegs::study
