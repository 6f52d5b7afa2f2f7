// SPDX-License-Identifier: GPL-3.0-or-later
// A face is an unordered set of directed edges. Each edge occurs once in each direction, in two faces. A cut
// by a plane preserves this invariant. In each face that crosses the plane, the points where the boundary
// leaves and enters are joined in pairs by new edges. The reversed new edges bound the new face in the plane.
// So the surface is closed after each cut, whatever the classification of the points. Faces, convex or not,
// are triangulated only after the last cut.
#include "geometry/fracture/clip_to_cell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <unordered_map>

#include "geometry/mesh/triangulate_polygon.h"

namespace livegs {
namespace {

using Edge = std::array<uint32_t, 2>;

struct Faces {
  std::vector<uint32_t> labels;
  std::vector<uint32_t> begin{0};  // edges of face f: begin[f] to begin[f + 1] - 1
  std::vector<Edge> edges;
  void close_face(uint32_t label) {
    labels.push_back(label);
    begin.push_back(static_cast<uint32_t>(edges.size()));
  }
};

struct Plane {
  Eigen::Vector3d normal;  // from the cell with the lower number to the other
  double offset;
};
Plane bisector(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d normal = high - low;
  return {normal, normal.dot(0.5 * (low + high))};
}

class CellClipper {
 public:
  CellClipper(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m, uint32_t cell)
      : mesh_(mesh), seeds_m_(seeds_m), cell_(cell), cell_count_(static_cast<uint32_t>(seeds_m.size())) {
    const auto triangle_count = static_cast<uint32_t>(mesh.triangles.size());
    out_.vertices_m = mesh.vertices_m;
    out_.names.resize(mesh.vertices_m.size());
    for (uint32_t v = 0; v < out_.names.size(); ++v) {
      out_.names[v] = {cell_count_ + triangle_count + v, ~0u, ~0u, ~0u};
    }
    faces_.labels.reserve(triangle_count);
    faces_.edges.reserve(3 * size_t{triangle_count});
    for (uint32_t t = 0; t < triangle_count; ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      faces_.edges.insert(faces_.edges.end(), {Edge{a, b}, Edge{b, c}, Edge{c, a}});
      faces_.close_face(cell_count_ + t);
    }
  }

  void cut(uint32_t neighbour) {
    const bool is_low = cell_ < neighbour;
    const Plane plane = is_low ? bisector(seeds_m_[cell_], seeds_m_[neighbour])
                               : bisector(seeds_m_[neighbour], seeds_m_[cell_]);
    // Distance beyond the plane; a point on the plane belongs to the cell with the lower number.
    beyond_.resize(out_.vertices_m.size());
    outside_.resize(out_.vertices_m.size());
    bool any_outside = false;
    for (size_t v = 0; v < out_.vertices_m.size(); ++v) {
      const double side = plane.normal.dot(out_.vertices_m[v]) - plane.offset;
      beyond_[v] = side;
      outside_[v] = is_low ? side > 0.0 : side <= 0.0;
      any_outside = any_outside || outside_[v];
    }
    if (!any_outside) return;

    Faces kept;
    std::vector<Edge> cap;
    cut_vertices_.clear();
    for (size_t f = 0; f < faces_.labels.size(); ++f) {
      cut_face(f, neighbour, plane.normal, kept, cap);
    }
    if (!cap.empty()) {
      kept.edges.insert(kept.edges.end(), cap.begin(), cap.end());
      kept.close_face(neighbour);
    }
    faces_ = std::move(kept);
    remove_unused_vertices();
  }

  ClippedCell finish() {
    for (size_t f = 0; f < faces_.labels.size(); ++f) triangulate_face(f);
    return std::move(out_);
  }

 private:
  Eigen::Vector3d normal_of(uint32_t label) const {
    if (label < cell_count_) return (seeds_m_[label] - seeds_m_[cell_]).normalized();
    const auto& [a, b, c] = mesh_.triangles[label - cell_count_];
    const Eigen::Vector3d normal =
        (mesh_.vertices_m[b] - mesh_.vertices_m[a]).cross(mesh_.vertices_m[c] - mesh_.vertices_m[a]);
    const double length = normal.norm();
    return length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitX();
  }

  // Returns the intersection of the edge (u, w) with the plane. The name gives both faces of the edge the
  // same vertex.
  uint32_t cut_vertex(uint32_t u, uint32_t w, uint32_t label, uint32_t neighbour) {
    const uint32_t low = std::min(u, w), high = std::max(u, w);
    const auto [found, is_new] = cut_vertices_.try_emplace((uint64_t{high} << 32) | low, 0u);
    if (is_new) {
      const double t = beyond_[low] / (beyond_[low] - beyond_[high]);
      found->second = static_cast<uint32_t>(out_.vertices_m.size());
      out_.vertices_m.push_back(out_.vertices_m[low] + t * (out_.vertices_m[high] - out_.vertices_m[low]));
      out_.names.push_back({cell_, neighbour, label, ~0u});
    } else if (VertexName& name = out_.names[found->second]; name[3] == ~0u) {
      name[3] = label;
      std::sort(name.begin(), name.end());
    }
    return found->second;
  }

  void cut_face(size_t f, uint32_t neighbour, const Eigen::Vector3d& plane_normal, Faces& kept,
                std::vector<Edge>& cap) {
    const uint32_t label = faces_.labels[f], begin = faces_.begin[f], end = faces_.begin[f + 1];
    uint32_t outside_count = 0;
    for (uint32_t e = begin; e < end; ++e) outside_count += outside_[faces_.edges[e][0]];
    if (outside_count == end - begin) return;
    if (outside_count == 0) {
      kept.edges.insert(kept.edges.end(), faces_.edges.begin() + begin, faces_.edges.begin() + end);
      kept.close_face(label);
      return;
    }
    exits_.clear();
    entries_.clear();
    for (uint32_t e = begin; e < end; ++e) {
      const auto [u, w] = faces_.edges[e];
      if (outside_[u] && outside_[w]) continue;
      if (!outside_[u] && !outside_[w]) {
        kept.edges.push_back({u, w});
      } else if (outside_[w]) {
        exits_.push_back(cut_vertex(u, w, label, neighbour));
        kept.edges.push_back({u, exits_.back()});
      } else {
        entries_.push_back(cut_vertex(u, w, label, neighbour));
        kept.edges.push_back({entries_.back(), w});
      }
    }
    if (exits_.size() > 1) {
      const Eigen::Vector3d line = plane_normal.cross(normal_of(label));
      const auto along = [&](uint32_t a, uint32_t b) {
        const double pa = line.dot(out_.vertices_m[a]), pb = line.dot(out_.vertices_m[b]);
        return pa != pb ? pa < pb : a < b;
      };
      std::sort(exits_.begin(), exits_.end(), along);
      std::sort(entries_.begin(), entries_.end(), along);
    }
    for (size_t k = 0; k < exits_.size(); ++k) {
      kept.edges.push_back({exits_[k], entries_[k]});
      cap.push_back({entries_[k], exits_[k]});
    }
    kept.close_face(label);
  }

  void remove_unused_vertices() {
    std::vector<uint32_t> number(out_.vertices_m.size(), ~0u);
    uint32_t count = 0;
    for (Edge& edge : faces_.edges) {
      for (uint32_t& v : edge) {
        if (number[v] == ~0u) number[v] = count++;
        v = number[v];
      }
    }
    std::vector<Eigen::Vector3d> vertices(count);
    std::vector<VertexName> names(count);
    for (size_t v = 0; v < number.size(); ++v) {
      if (number[v] == ~0u) continue;
      vertices[number[v]] = out_.vertices_m[v];
      names[number[v]] = out_.names[v];
    }
    out_.vertices_m = std::move(vertices);
    out_.names = std::move(names);
  }

  void triangulate_face(size_t f) {
    const uint32_t label = faces_.labels[f];
    const std::span<Edge> edges(faces_.edges.data() + faces_.begin[f], faces_.begin[f + 1] - faces_.begin[f]);
    const auto add = [&](std::span<const std::array<uint32_t, 3>> triangles) {
      const auto first = static_cast<uint32_t>(out_.triangles.size());
      out_.triangles.insert(out_.triangles.end(), triangles.begin(), triangles.end());
      out_.faces.push_back({label, first, static_cast<uint32_t>(out_.triangles.size())});
    };
    if (edges.size() == 3 && edges[0][1] == edges[1][0] && edges[1][1] == edges[2][0]) {
      const std::array<uint32_t, 3> triangle{edges[0][0], edges[1][0], edges[2][0]};
      return add(std::span(&triangle, 1));
    }
    // Builds loops with local corner indices.
    std::sort(edges.begin(), edges.end());
    std::vector<std::vector<uint32_t>> loops;
    std::vector<uint8_t> used(edges.size(), 0);
    std::vector<uint32_t> corners;
    const auto local = [&](uint32_t vertex) {
      return static_cast<uint32_t>(std::lower_bound(corners.begin(), corners.end(), vertex) -
                                   corners.begin());
    };
    for (const Edge& edge : edges) {
      if (corners.empty() || corners.back() != edge[0]) corners.push_back(edge[0]);
    }
    for (size_t start = 0; start < edges.size(); ++start) {
      if (used[start]) continue;
      std::vector<uint32_t>& loop = loops.emplace_back();
      size_t at = start;
      while (at < edges.size() && !used[at]) {
        used[at] = 1;
        loop.push_back(local(edges[at][0]));
        const uint32_t next = edges[at][1];
        at = static_cast<size_t>(std::lower_bound(edges.begin(), edges.end(), Edge{next, 0}) - edges.begin());
        while (at < edges.size() && edges[at][0] == next && used[at]) ++at;
        if (at < edges.size() && edges[at][0] != next) break;
      }
    }
    const Eigen::Vector3d normal = normal_of(label), right = normal.unitOrthogonal(),
                          up = normal.cross(right);
    std::vector<Eigen::Vector2d> points(corners.size());
    const Eigen::Vector3d origin = out_.vertices_m[corners[0]];
    for (size_t c = 0; c < corners.size(); ++c) {
      const Eigen::Vector3d way = out_.vertices_m[corners[c]] - origin;
      points[c] = {right.dot(way), up.dot(way)};
    }
    for (const PolygonRegion& region : nest_loops(std::move(loops), points)) {
      std::vector<std::array<uint32_t, 3>> triangles = triangulate(region, points);
      for (auto& triangle : triangles) {
        for (uint32_t& corner : triangle) corner = corners[corner];
      }
      if (!triangles.empty()) add(triangles);
    }
  }

  const TriangleMesh& mesh_;
  std::span<const Eigen::Vector3d> seeds_m_;
  uint32_t cell_, cell_count_;
  Faces faces_;
  ClippedCell out_;
  std::vector<double> beyond_;
  std::vector<uint8_t> outside_;
  std::vector<uint32_t> exits_, entries_;
  std::unordered_map<uint64_t, uint32_t> cut_vertices_;
};

}  // namespace

ClippedCell clip_to_cell(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m, uint32_t cell,
                         std::span<const uint32_t> neighbours) {
  CellClipper clipper(mesh, seeds_m, cell);
  for (uint32_t neighbour : neighbours) clipper.cut(neighbour);
  return clipper.finish();
}

}  // namespace livegs
