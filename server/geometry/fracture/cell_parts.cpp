// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/fracture/cell_parts.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

double volume_of(const ClippedCell& cell, const CellPart& part) {
  const Vector3d origin = cell.vertices_m[part.triangles[0][0]];
  double six = 0.0;
  for (const auto& [a, b, c] : part.triangles) {
    six +=
        (cell.vertices_m[a] - origin).dot((cell.vertices_m[b] - origin).cross(cell.vertices_m[c] - origin));
  }
  return six / 6.0;
}

// Winding number of the part around a point (van Oosterom and Strackee 1983).
double winding(const ClippedCell& cell, const CellPart& part, const Vector3d& point) {
  double angle = 0.0;
  for (const auto& triangle : part.triangles) {
    const Vector3d a = cell.vertices_m[triangle[0]] - point, b = cell.vertices_m[triangle[1]] - point,
                   c = cell.vertices_m[triangle[2]] - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

void append(CellPart& part, const CellPart& more) {
  const auto shift = static_cast<uint32_t>(part.triangles.size());
  part.triangles.insert(part.triangles.end(), more.triangles.begin(), more.triangles.end());
  for (const CellPart::Face& face : more.faces) {
    part.faces.push_back({face.label, face.begin + shift, face.end + shift});
  }
}

}  // namespace

std::vector<CellPart> connected_parts(const ClippedCell& cell, uint32_t number) {
  // The triangles of a face are connected even if its loops share no vertex, because a bridge joins them.
  DisjointSets joined(cell.vertices_m.size());
  for (const auto& triangle : cell.triangles) {
    joined.join(triangle[0], triangle[1]);
    joined.join(triangle[0], triangle[2]);
  }
  std::vector<CellPart> parts;
  std::vector<uint32_t> part_of_set(cell.vertices_m.size(), ~0u);
  for (const ClippedCell::Face& face : cell.faces) {
    uint32_t& part = part_of_set[joined.find(cell.triangles[face.begin][0])];
    if (part == ~0u) {
      part = static_cast<uint32_t>(parts.size());
      parts.emplace_back().cell = number;
    }
    CellPart& into = parts[part];
    const auto begin = static_cast<uint32_t>(into.triangles.size());
    into.triangles.insert(into.triangles.end(), cell.triangles.begin() + face.begin,
                          cell.triangles.begin() + face.end);
    into.faces.push_back({face.label, begin, static_cast<uint32_t>(into.triangles.size())});
  }
  if (parts.size() < 2) return parts;

  std::vector<CellPart> bodies, hollows;
  std::vector<double> volumes;
  for (CellPart& part : parts) {
    const double volume = volume_of(cell, part);
    if (volume > 0.0) volumes.push_back(volume);
    (volume > 0.0 ? bodies : hollows).push_back(std::move(part));
  }
  if (bodies.empty()) return hollows;
  const size_t body_count = bodies.size();
  std::vector<std::vector<size_t>> held(body_count);
  for (size_t h = 0; h < hollows.size(); ++h) {
    // Selects the smallest enclosing part.
    size_t best = 0;
    double least = INFINITY;
    const Vector3d& point = cell.vertices_m[hollows[h].triangles[0][0]];
    for (size_t b = 0; b < body_count; ++b) {
      if (volumes[b] < least && winding(cell, bodies[b], point) > 0.5) best = b, least = volumes[b];
    }
    held[best].push_back(h);
  }
  for (size_t b = 0; b < body_count; ++b) {
    for (size_t h : held[b]) append(bodies[b], hollows[h]);
  }
  return bodies;
}

}  // namespace livegs
