// SPDX-License-Identifier: GPL-3.0-or-later
// Separating axis test with edge pairs pruned on the Gauss map (Gregorius 2013, The separating axis test
// between convex polyhedra), followed by clipping of the incident face against the reference face.
#include <algorithm>
#include <array>
#include <cmath>

#include "physics/collision/contact_candidate.h"
#include "physics/collision/convex_polyhedron.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Edge = ConvexPolyhedron::Edge;
using Face = ConvexPolyhedron::Face;

// A polyhedron in a's axes, relative to a's origin.
struct Side {
  const ConvexPolyhedron& shape;
  std::array<Vector3d, kMaxPolyhedronVertices> vertices;
  std::array<Vector3d, kMaxPolyhedronFaces> normals;
  std::array<double, kMaxPolyhedronFaces> offsets;
  Vector3d centre;

  explicit Side(const ConvexPolyhedron& of) : shape(of) {}
  void place(const Eigen::Matrix3d& rotation, const Vector3d& shift) {
    for (size_t i = 0; i < shape.vertices_m.size(); ++i) vertices[i] = rotation * shape.vertices_m[i] + shift;
    for (size_t i = 0; i < shape.faces.size(); ++i) {
      normals[i] = rotation * shape.faces[i].normal;
      offsets[i] = shape.faces[i].offset_m + normals[i].dot(shift);
    }
    centre = rotation * shape.centre_m + shift;
  }
  const Vector3d& corner(const Face& face, int index) const {
    return vertices[shape.loops[face.first + index % face.count]];
  }
  double lowest(const Vector3d& normal) const {
    double low = normal.dot(vertices[0]);
    for (size_t i = 1; i < shape.vertices_m.size(); ++i) low = std::min(low, normal.dot(vertices[i]));
    return low;
  }
};

struct FaceAxis {
  double gap = -INFINITY;
  size_t face = 0;
};
struct EdgeAxis {
  double gap = -INFINITY;
  size_t a = 0, b = 0;
  Vector3d normal = Vector3d::UnitY();  // pointing out of a
};

// The first face wins ties, so that coincident bodies have a defined direction too.
FaceAxis best_face(const Side& of, const Side& other, double reach) {
  FaceAxis best;
  for (size_t f = 0; f < of.shape.faces.size(); ++f) {
    const double gap = other.lowest(of.normals[f]) - of.offsets[f];
    if (gap > best.gap) best = {gap, f};
    if (gap > reach) break;
  }
  return best;
}

EdgeAxis best_edges(const Side& a, const Side& b, double reach) {
  EdgeAxis best;
  for (size_t i = 0; i < a.shape.edges.size(); ++i) {
    const Edge& ea = a.shape.edges[i];
    const Vector3d along_a = a.vertices[ea.to] - a.vertices[ea.from];
    for (size_t k = 0; k < b.shape.edges.size(); ++k) {
      const Edge& eb = b.shape.edges[k];
      // The two edges form a face of the Minkowski difference only if their arcs on the Gauss map cross.
      const double left = b.normals[eb.left].dot(along_a), right = b.normals[eb.right].dot(along_a);
      if (left * right >= 0.0) continue;
      const Vector3d along_b = b.vertices[eb.to] - b.vertices[eb.from];
      const double other_left = a.normals[ea.left].dot(along_b),
                   other_right = a.normals[ea.right].dot(along_b);
      if (other_left * other_right >= 0.0 || left * other_right >= 0.0) continue;
      Vector3d normal = along_a.cross(along_b);
      const double length2 = normal.squaredNorm();
      if (length2 < 1e-6 * along_a.squaredNorm() * along_b.squaredNorm()) continue;  // nearly parallel
      normal /= std::sqrt(length2);
      if (normal.dot(a.vertices[ea.from] - a.centre) < 0.0) normal = -normal;
      const double gap = normal.dot(b.vertices[eb.from] - a.vertices[ea.from]);
      if (gap > best.gap) best = {gap, i, k, normal};
      if (gap > reach) return best;
    }
  }
  return best;
}

// A corner of the clipped polygon: its id and the id of the edge that starts there.
struct PolygonCorner {
  Vector3d point;
  uint64_t id, edge;
};

uint64_t face_pair_id(uint64_t reference, uint64_t incident) { return (reference << 16) | (incident << 22); }

// Clips `other`'s most antiparallel face to `normal` against the sides of `of`'s face.
struct Cut {
  std::array<PolygonCorner, 2 * kMaxPolyhedronVertices> first, second;
  PolygonCorner *corners = first.data(), *spare = second.data();
  size_t count = 0;

  void cut(const Vector3d& outwards, double offset, uint64_t side) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
      const PolygonCorner &from = corners[i], &to = corners[i + 1 < count ? i + 1 : 0];
      const double height = outwards.dot(from.point) - offset, next = outwards.dot(to.point) - offset;
      if (height <= 0.0 && kept < first.size()) spare[kept++] = from;
      if ((height <= 0.0) == (next <= 0.0) || kept == first.size()) continue;
      const double share = height / (height - next);
      // At an exit the polygon continues along the clipping plane, at an entry along the clipped edge.
      spare[kept++] = {from.point + share * (to.point - from.point), 256 + from.edge * 64 + side,
                       height <= 0.0 ? 64 + side : from.edge};
    }
    std::swap(corners, spare);
    count = kept;
  }
};

// Calls take(point of `other`, gap, id) for each contact.
template <class Take>
void cut_faces(const Side& of, size_t face_index, const Side& other, double reach, const Take& take) {
  const Face& face = of.shape.faces[face_index];
  const Vector3d& normal = of.normals[face_index];
  size_t incident = 0;
  for (size_t f = 1; f < other.shape.faces.size(); ++f) {
    if (other.normals[f].dot(normal) < other.normals[incident].dot(normal)) incident = f;
  }
  const Face& against = other.shape.faces[incident];
  Cut cut;
  for (int k = 0; k < against.count; ++k) {
    cut.corners[cut.count++] = {other.corner(against, k),
                                static_cast<uint64_t>(other.shape.loops[against.first + k]),
                                static_cast<uint64_t>(k)};
  }
  for (int k = 0; k < face.count && cut.count > 0; ++k) {
    const Vector3d outwards = (of.corner(face, k + 1) - of.corner(face, k)).cross(normal).normalized();
    cut.cut(outwards, outwards.dot(of.corner(face, k)), static_cast<uint64_t>(k));
  }
  const uint64_t faces = face_pair_id(face_index, incident);
  bool any = false;
  for (size_t i = 0; i < cut.count; ++i) {
    const double gap = normal.dot(cut.corners[i].point) - of.offsets[face_index];
    if (gap > reach) continue;
    take(cut.corners[i].point, gap, faces + cut.corners[i].id);
    any = true;
  }
  if (any) return;
  // The bodies overlap but not over this face: use the deepest corner.
  size_t deepest = 0;
  for (size_t v = 1; v < other.shape.vertices_m.size(); ++v) {
    if (normal.dot(other.vertices[v]) < normal.dot(other.vertices[deepest])) deepest = v;
  }
  const double gap = normal.dot(other.vertices[deepest]) - of.offsets[face_index];
  if (gap < 0.0) take(other.vertices[deepest], gap, faces + deepest);
}

void place_both(const PlacedPolyhedron& a, const PlacedPolyhedron& b, Side& side_a, Side& side_b) {
  side_a.place(Eigen::Matrix3d::Identity(), Vector3d::Zero());
  side_b.place(a.rotation.transpose() * b.rotation, a.rotation.transpose() * (b.position_m - a.position_m));
}

}  // namespace

double polyhedron_gap_m(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m) {
  Side side_a(*a.shape), side_b(*b.shape);
  place_both(a, b, side_a, side_b);
  double gap = best_face(side_a, side_b, reach_m).gap;
  if (gap > reach_m) return gap;
  gap = std::max(gap, best_face(side_b, side_a, reach_m).gap);
  if (gap > reach_m) return gap;
  return std::max(gap, best_edges(side_a, side_b, reach_m).gap);
}

void polyhedron_contacts(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m,
                         double tolerance_m, std::vector<ContactCandidate>& candidates) {
  Side side_a(*a.shape), side_b(*b.shape);
  place_both(a, b, side_a, side_b);
  const FaceAxis of_a = best_face(side_a, side_b, reach_m);
  if (of_a.gap > reach_m) return;
  const FaceAxis of_b = best_face(side_b, side_a, reach_m);
  if (of_b.gap > reach_m) return;
  const EdgeAxis edges = best_edges(side_a, side_b, reach_m);
  if (edges.gap > reach_m) return;

  const auto world = [&](const Vector3d& point) { return Vector3d(a.rotation * point + a.position_m); };
  if (edges.gap > std::max(of_a.gap, of_b.gap) + tolerance_m) {
    const Edge &ea = a.shape->edges[edges.a], &eb = b.shape->edges[edges.b];
    const Vector3d from_a = side_a.vertices[ea.from], along_a = side_a.vertices[ea.to] - from_a;
    const Vector3d from_b = side_b.vertices[eb.from], along_b = side_b.vertices[eb.to] - from_b;
    const Vector3d between = from_b - from_a;
    const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
    const double determinant = aa * bb - ab * ab;
    const double s = (bb * along_a.dot(between) - ab * along_b.dot(between)) / determinant;
    const double t = (ab * along_a.dot(between) - aa * along_b.dot(between)) / determinant;
    const bool crossing = s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0;
    if (crossing || edges.gap < 0.0) {
      const Vector3d on_a = from_a + std::clamp(s, 0.0, 1.0) * along_a;
      const Vector3d on_b = from_b + std::clamp(t, 0.0, 1.0) * along_b;
      candidates.push_back({kEdgePair + edges.a * 256 + edges.b, world(0.5 * (on_a + on_b)),
                            a.rotation * -edges.normal, edges.gap});
      return;
    }
  }
  if (of_b.gap > of_a.gap + tolerance_m) {
    const Vector3d normal = a.rotation * side_b.normals[of_b.face];
    cut_faces(side_b, of_b.face, side_a, reach_m, [&](const Vector3d& point, double gap, uint64_t id) {
      candidates.push_back({id, world(point), normal, gap});
    });
  } else {
    const Vector3d normal = a.rotation * -side_a.normals[of_a.face];
    cut_faces(side_a, of_a.face, side_b, reach_m, [&](const Vector3d& point, double gap, uint64_t id) {
      candidates.push_back({kForeignFeature + id, world(point), normal, gap});
    });
  }
}

}  // namespace livegs
