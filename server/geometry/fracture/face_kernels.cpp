// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/fracture/face_kernels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/parallel_for.h"

namespace livegs {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Lengths below are relative to the spacing. Standard deviation of a grid kernel. Where three neighbours
// meet, their combined opacity is 0.97.
constexpr double kGridDeviation = 0.6;
constexpr double kMinRimDistance = 0.3;  // minimum distance of a grid kernel from the rim
// Rows of kernels along the rim. The first row follows the walls of thin parts, the second covers wider
// faces.
constexpr double kRimStep = 0.6, kRimAlong = 0.45, kRimInsets[] = {0.2, 0.55};
constexpr double kThickness = 0.02;
// Minimum distance of a kernel from the rim, in standard deviations. Its opacity there is a seventh.
constexpr double kDeviationsToRim = 2.0;

// Returns the maximum standard deviation of a kernel at this distance from the rim.
double widest(double rim, double most_overhang) {
  return std::min(rim / kDeviationsToRim, (rim + most_overhang) / 3.0);
}

// The triangles of one bond in one plane, as seen from the first piece.
struct Face {
  Vector3d origin, right, up, normal;
  std::vector<std::array<Vector2d, 3>> triangles;
  std::vector<std::array<Vector2d, 2>> rim;

  Vector3d at(const Vector2d& p) const { return origin + p.x() * right + p.y() * up; }
};

// Returns the vector from a point to the nearest point of an edge.
Vector2d way_to(const Vector2d& p, const std::array<Vector2d, 2>& edge) {
  const Vector2d way = edge[1] - edge[0];
  const double length2 = way.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - edge[0]).dot(way) / length2, 0.0, 1.0) : 0.0;
  return edge[0] + t * way - p;
}

// Returns the distance to the rim, negative outside.
double rim_distance(const Face& face, const Vector2d& p) {
  double nearest = std::numeric_limits<double>::max();
  bool inside = false;
  for (const auto& [a, b] : face.rim) {
    nearest = std::min(nearest, way_to(p, {a, b}).norm());
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) {
      inside = !inside;
    }
  }
  return inside ? nearest : -nearest;
}

std::vector<Face> faces_of(const VoronoiPiece& piece, uint32_t bond) {
  struct FacePlane {
    Vector3d normal;
    double offset;
    std::vector<size_t> triangles;
  };
  std::vector<FacePlane> planes;
  const auto& vertices = piece.mesh.vertices_m;
  for (size_t t = 0; t < piece.mesh.triangles.size(); ++t) {
    if (piece.triangle_bond[t] != bond) continue;
    const auto& [a, b, c] = piece.mesh.triangles[t];
    const Vector3d cross = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
    const double size = cross.norm(), longest2 = std::max({(vertices[b] - vertices[a]).squaredNorm(),
                                                           (vertices[c] - vertices[b]).squaredNorm(),
                                                           (vertices[a] - vertices[c]).squaredNorm()});
    // Slivers have no reliable normal; they are added to the first plane that they lie in.
    const bool sliver = size < 1e-6 * longest2;
    const Vector3d normal = sliver ? Vector3d::Zero() : Vector3d(cross / size);
    const double near = 1e-6 * std::sqrt(longest2);
    auto plane = std::find_if(planes.begin(), planes.end(), [&](const FacePlane& p) {
      return (sliver || normal.dot(p.normal) > 1 - 1e-9) &&
             std::abs(p.normal.dot(vertices[a]) - p.offset) < std::max(near, 1e-12);
    });
    if (plane == planes.end()) {
      if (sliver) continue;
      planes.push_back({normal, normal.dot(vertices[a]), {}});
      plane = planes.end() - 1;
    }
    plane->triangles.push_back(t);
  }
  std::vector<Face> faces;
  for (const FacePlane& plane : planes) {
    Face& face = faces.emplace_back();
    face.normal = plane.normal;
    face.right = plane.normal.unitOrthogonal();
    face.up = plane.normal.cross(face.right);
    face.origin = vertices[piece.mesh.triangles[plane.triangles[0]][0]];
    const auto flat = [&](uint32_t v) {
      const Vector3d way = vertices[v] - face.origin;
      return Vector2d(way.dot(face.right), way.dot(face.up));
    };
    std::map<std::pair<uint32_t, uint32_t>, int> balance;
    for (size_t t : plane.triangles) {
      const auto& corners = piece.mesh.triangles[t];
      face.triangles.push_back({flat(corners[0]), flat(corners[1]), flat(corners[2])});
      for (int k = 0; k < 3; ++k) {
        const uint32_t from = corners[k], to = corners[(k + 1) % 3];
        balance[std::minmax(from, to)] += from < to ? 1 : -1;
      }
    }
    for (const auto& [edge, count] : balance) {
      if (count > 0) face.rim.push_back({flat(edge.first), flat(edge.second)});
      if (count < 0) face.rim.push_back({flat(edge.second), flat(edge.first)});
    }
  }
  return faces;
}

struct FlatKernel {
  Vector2d place, along;  // along: unit direction of the first deviation
  double along_m, across_m;
};

// Shrinks the kernel until it extends no farther beyond an edge than allowed.
void fit(const Face& face, double overhang, FlatKernel& kernel) {
  double share = 1.0;
  for (const auto& edge : face.rim) {
    const Vector2d way = way_to(kernel.place, edge);
    const double distance = way.norm();
    const double along = way.dot(kernel.along), across2 = std::max(0.0, distance * distance - along * along);
    const double deviation = std::sqrt(along * along * kernel.along_m * kernel.along_m +
                                       across2 * kernel.across_m * kernel.across_m);
    // Condition at distance d to the edge: 3 deviations are at most d + overhang.
    if (deviation > 0.0) share = std::min(share, distance * (distance + overhang) / (3.0 * deviation));
  }
  kernel.along_m *= share;
  kernel.across_m *= share;
}

void add_grid(const Face& face, double spacing, double overhang, std::vector<FlatKernel>& out) {
  const double row = spacing * std::sqrt(0.75);
  std::set<std::pair<int, int>> places;
  for (const auto& [a, b, c] : face.triangles) {
    const Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const auto cross = [](const Vector2d& o, const Vector2d& p, const Vector2d& q) {
      return (p - o).x() * (q - o).y() - (p - o).y() * (q - o).x();
    };
    for (int j = static_cast<int>(std::ceil(low.y() / row)); j * row <= high.y(); ++j) {
      const double shift = j & 1 ? 0.5 * spacing : 0.0;
      for (int i = static_cast<int>(std::ceil((low.x() - shift) / spacing)); i * spacing + shift <= high.x();
           ++i) {
        const Vector2d p(i * spacing + shift, j * row);
        if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) places.insert({j, i});
      }
    }
  }
  for (const auto& [j, i] : places) {
    const Vector2d p(i * spacing + (j & 1 ? 0.5 * spacing : 0.0), j * row);
    const double rim = rim_distance(face, p);
    if (rim < kMinRimDistance * spacing) continue;
    const double deviation = std::min(kGridDeviation * spacing, widest(rim, overhang));
    FlatKernel kernel{p, Vector2d::UnitX(), deviation, deviation};
    fit(face, overhang, kernel);
    out.push_back(kernel);
  }
}

void add_rim(const Face& face, double spacing, double overhang, double first_inset, bool closer,
             std::vector<FlatKernel>& out) {
  // The step continues across edges, so that a rim of many short edges gets no more kernels than one of few
  // long edges.
  double walked = 0.0;
  for (const auto& [a, b] : face.rim) {
    const double length = (b - a).norm();
    if (!(length > 0.0)) continue;
    const Vector2d along = (b - a) / length,
                   inwards(-along.y(), along.x());  // counter-clockwise: the inside is on the left
    const double step = kRimStep * spacing;
    for (double next = (std::floor(walked / step) + 1.0) * step; next <= walked + length; next += step) {
      const Vector2d on = a + (next - walked) * along;
      for (double inset = first_inset * spacing; inset > 0.02 * spacing; inset *= 0.5) {
        const Vector2d place = on + inset * inwards;
        const double rim = rim_distance(face, place);
        if (rim < 0.7 * inset) {  // the wall is thinner than the inset
          if (closer) continue;
          break;
        }
        FlatKernel kernel{place, along, kRimAlong * spacing, widest(rim, overhang)};
        const auto reach = [&] {
          return std::max(kDeviationsToRim * kernel.along_m, 3.0 * kernel.along_m - overhang);
        };
        while (kernel.along_m > kernel.across_m && (rim_distance(face, place + reach() * along) < 0.0 ||
                                                    rim_distance(face, place - reach() * along) < 0.0)) {
          kernel.along_m *= 0.7;
        }
        fit(face, overhang, kernel);
        out.push_back(kernel);
        break;
      }
    }
    walked += length;
  }
}

}  // namespace

std::vector<FaceKernel> face_kernels(const VoronoiPieces& pieces, double spacing_m, double max_overhang_m) {
  std::vector<std::vector<FaceKernel>> by_bond(pieces.bonds.size());
  parallel_for(pieces.bonds.size(), 1, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) {
      const auto bond = static_cast<uint32_t>(b);
      std::vector<FaceKernel> first, second;
      for (const Face& face : faces_of(pieces.pieces[pieces.bonds[b].first], bond)) {
        std::vector<FlatKernel> flat;
        add_grid(face, spacing_m, max_overhang_m, flat);
        add_rim(face, spacing_m, max_overhang_m, kRimInsets[0], true, flat);
        add_rim(face, spacing_m, max_overhang_m, kRimInsets[1], false, flat);
        for (const FlatKernel& kernel : flat) {
          const Vector3d along = kernel.along.x() * face.right + kernel.along.y() * face.up;
          FaceKernel made;
          made.bond = bond;
          made.deviations_m = {kernel.along_m, kernel.across_m, kThickness * spacing_m};
          const Vector3d place = face.at(kernel.place), behind = 3.0 * kThickness * spacing_m * face.normal;
          made.piece = pieces.bonds[b].first;
          made.position_m = place - behind;
          made.axes << along, face.normal.cross(along), face.normal;
          first.push_back(made);
          made.piece = pieces.bonds[b].second;
          made.position_m = place + behind;
          made.axes << along, -face.normal.cross(along), -face.normal;
          second.push_back(made);
        }
      }
      by_bond[b] = std::move(first);
      by_bond[b].insert(by_bond[b].end(), second.begin(), second.end());
    }
  });
  std::vector<FaceKernel> all;
  for (const auto& kernels : by_bond) all.insert(all.end(), kernels.begin(), kernels.end());
  return all;
}

}  // namespace livegs
