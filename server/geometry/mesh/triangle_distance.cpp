// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/triangle_distance.h"

#include <algorithm>

namespace livegs {
namespace {

Eigen::Vector3d closest_point_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                         const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  if (!(length2 > 0.0)) return a;
  return a + std::clamp((p - a).dot(along) / length2, 0.0, 1.0) * along;
}

}  // namespace

Eigen::Vector3d closest_point_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                          const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  // Twice the area times the barycentric weights of a, b and c at the projection of p.
  const double weight_c = d1 * d4 - d3 * d2, weight_b = d5 * d2 - d1 * d6, weight_a = d3 * d6 - d5 * d4;
  if (weight_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return closest_point_on_segment(p, a, b);
  if (weight_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return closest_point_on_segment(p, a, c);
  if (weight_a <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return closest_point_on_segment(p, b, c);
  const double sum = weight_a + weight_b + weight_c;
  if (!(sum > 0.0)) {  // zero area: the nearest of its edges
    Eigen::Vector3d best = closest_point_on_segment(p, a, b);
    for (const Eigen::Vector3d& other :
         {closest_point_on_segment(p, b, c), closest_point_on_segment(p, c, a)}) {
      if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
    }
    return best;
  }
  return a + (weight_b / sum) * ab + (weight_c / sum) * ac;
}

}  // namespace livegs
