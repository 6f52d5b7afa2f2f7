// SPDX-License-Identifier: GPL-3.0-or-later
// Edelsbrunner and Mücke 1994, Three-dimensional alpha shapes. Uses CGAL's Delaunay triangulation with its
// exact predicates. CGAL's Alpha_shape_3 is not used, because it sorts all simplices by alpha, which costs
// more than the triangulation. Only one radius at a time is needed here.
#include "geometry/surface/alpha_complex.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/percentile.h"
#include "geometry/surface/assemble_surface.h"

namespace livegs {
namespace {

struct CellInfo {
  double radius2 = 0.0;  // squared circumradius
  bool reached = false;  // reached by the ball from outside
  // Triangle of the body's surface opposite each corner, if there is one.
  std::array<int32_t, 4> face = {};
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<CellInfo, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;
using Cell = Delaunay::Cell_handle;
using Vertex = Delaunay::Vertex_handle;

// Corners of the face opposite corner i of a positively oriented tetrahedron, counter-clockwise as seen from
// outside.
constexpr int kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
// Relative tolerance for a point inside a sphere. Cospherical clouds (grids) must not be split by rounding.
constexpr double kInsideSphere = 1.0 - 1e-9;

Point to_cgal(const Eigen::Vector3d& p) { return Point(p.x(), p.y(), p.z()); }

Eigen::Vector3d position(const Vertex& vertex) {
  const Point& p = vertex->point();
  return {p.x(), p.y(), p.z()};
}

// Returns positions sorted by vertex number. CGAL's order of the corners of a cell or triangle may depend on
// memory addresses. Sorting makes rounding, and decisions based on it, deterministic.
template <size_t N>
std::array<Eigen::Vector3d, N> numbered_positions(std::array<Vertex, N> vertices) {
  std::sort(vertices.begin(), vertices.end(),
            [](const Vertex& a, const Vertex& b) { return a->info() < b->info(); });
  std::array<Eigen::Vector3d, N> positions;
  std::transform(vertices.begin(), vertices.end(), positions.begin(), position);
  return positions;
}

double squared_circumradius(const Cell& cell) {
  const auto [origin, p, q, r] =
      numbered_positions<4>({cell->vertex(0), cell->vertex(1), cell->vertex(2), cell->vertex(3)});
  const Eigen::Vector3d a = p - origin, b = q - origin, c = r - origin;
  const double twice_det = 2.0 * a.dot(b.cross(c));
  if (twice_det == 0.0) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d centre =
      (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)) /
      twice_det;
  return centre.squaredNorm();
}

struct Circle {
  Eigen::Vector3d centre;
  double radius2;
};
Circle circumcircle(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
  const Eigen::Vector3d a = q - p, b = r - p, normal = a.cross(b);
  const double scale = 2.0 * normal.squaredNorm();
  if (scale == 0.0) return {p, std::numeric_limits<double>::infinity()};
  const Eigen::Vector3d offset =
      (a.squaredNorm() * b.cross(normal) + b.squaredNorm() * normal.cross(a)) / scale;
  return {p + offset, offset.squaredNorm()};
}

}  // namespace

struct AlphaComplex::Impl {
  Delaunay delaunay;
  std::vector<Vertex> vertices;  // sorted by number; vertices of the cloud first, then added ones
  size_t cloud_size = 0;

  void renumber() {
    std::vector<std::pair<uint32_t, Vertex>> numbered;
    for (Vertex v : delaunay.finite_vertex_handles()) numbered.emplace_back(v->info(), v);
    std::sort(numbered.begin(), numbered.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    vertices.clear();
    for (const auto& [number, vertex] : numbered) {
      vertex->info() = static_cast<uint32_t>(vertices.size());
      vertices.push_back(vertex);
    }
  }

  void add(const Eigen::Vector3d& point, const Vertex& near) {
    const size_t before = delaunay.number_of_vertices();
    const Vertex vertex = delaunay.insert(to_cgal(point), near->cell());
    if (delaunay.number_of_vertices() == before) return;
    vertex->info() = static_cast<uint32_t>(vertices.size());
    vertices.push_back(vertex);
  }

  // Calls with both ends of each finite edge, several times for most edges: once for each cell around it.
  // CGAL's edge iterator circulates around each of these edges to find the one cell that reports it, which
  // costs more than the triangulation.
  template <class Function>
  void visit_edges(const Function& function) const {
    for (Cell cell : delaunay.finite_cell_handles()) {
      for (int i = 0; i < 4; ++i) {
        for (int k = i + 1; k < 4; ++k) function(cell->vertex(i), cell->vertex(k));
      }
    }
  }

  std::array<Vertex, 3> face_vertices(const Cell& cell, int i) const {
    return {cell->vertex(kFace[i][0]), cell->vertex(kFace[i][1]), cell->vertex(kFace[i][2])};
  }

  // Returns whether the ball cannot pass through this triangle; both adjacent cells are larger than the ball.
  bool blocked(const Cell& cell, int i, double radius2) const {
    const auto [p, q, r] = numbered_positions(face_vertices(cell, i));
    const Circle circle = circumcircle(p, q, r);
    if (!(circle.radius2 <= radius2)) return false;
    const Cell other = cell->neighbor(i);
    for (const Vertex& opposite : {cell->vertex(i), other->vertex(other->index(cell))}) {
      if (delaunay.is_infinite(opposite)) continue;
      if ((position(opposite) - circle.centre).squaredNorm() < circle.radius2 * kInsideSphere) return false;
    }
    return true;
  }

  void flood(double radius) {
    const double radius2 = radius * radius;
    std::vector<Cell> open;
    for (Cell cell : delaunay.all_cell_handles()) {
      const bool outside = delaunay.is_infinite(cell);
      cell->info().reached = outside;
      cell->info().radius2 = outside ? std::numeric_limits<double>::infinity() : squared_circumradius(cell);
      if (outside) open.push_back(cell);
    }
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      for (int i = 0; i < 4; ++i) {
        const Cell next = cell->neighbor(i);
        if (next->info().reached || next->info().radius2 <= radius2 || blocked(cell, i, radius2)) continue;
        next->info().reached = true;
        open.push_back(next);
      }
    }
  }

  std::vector<bool> on_body() const {
    std::vector<bool> on(vertices.size(), false);
    for (Cell cell : delaunay.finite_cell_handles()) {
      if (cell->info().reached) continue;
      for (int i = 0; i < 4; ++i) on[cell->vertex(i)->info()] = true;
    }
    return on;
  }
};

AlphaComplex::AlphaComplex(std::span<const Eigen::Vector3d> points) : impl_(std::make_unique<Impl>()) {
  std::vector<std::pair<Point, uint32_t>> cloud;
  cloud.reserve(points.size());
  for (const auto& point : points) cloud.emplace_back(to_cgal(point), static_cast<uint32_t>(cloud.size()));
  impl_->delaunay.insert(cloud.begin(), cloud.end());
  impl_->renumber();
  impl_->cloud_size = impl_->vertices.size();
}

AlphaComplex::~AlphaComplex() = default;

int AlphaComplex::dimension() const { return impl_->delaunay.dimension(); }

double AlphaComplex::median_gap() const {
  // The nearest neighbour of a point is one of its Delaunay neighbours.
  std::vector<double> gap2(impl_->vertices.size(), std::numeric_limits<double>::infinity());
  impl_->visit_edges([&](const Vertex& a, const Vertex& b) {
    const double length2 = (position(a) - position(b)).squaredNorm();
    for (const Vertex& end : {a, b}) gap2[end->info()] = std::min(gap2[end->info()], length2);
  });
  return std::sqrt(percentile(std::move(gap2), 0.5));
}

void AlphaComplex::thicken_plane(double thickness) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Vertex& v : impl_->vertices) mean += position(v);
  mean /= static_cast<double>(impl_->vertices.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vertex& v : impl_->vertices) spread += (position(v) - mean) * (position(v) - mean).transpose();
  const Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  std::vector<std::pair<Point, uint32_t>> added;
  for (const Vertex& v : impl_->vertices) {
    for (double side : {-0.5, 0.5}) {
      added.emplace_back(to_cgal(position(v) + side * thickness * normal),
                         static_cast<uint32_t>(impl_->vertices.size() + added.size()));
    }
  }
  impl_->delaunay.insert(added.begin(), added.end());
  impl_->renumber();
}

size_t AlphaComplex::thicken_sheets(double radius, double thickness) {
  Impl& impl = *impl_;
  impl.flood(radius);
  const double radius2 = radius * radius;

  // Triangles that block the ball although it has been on both sides. Small ones are included: they close
  // gaps between tetrahedra, without which leaves fall apart.
  struct SheetTriangle {
    std::array<uint32_t, 3> corners;
    Eigen::Vector3d double_area;
  };
  std::vector<SheetTriangle> sheets;
  for (const auto& [cell, i] : impl.delaunay.finite_facets()) {
    if (!cell->info().reached || !cell->neighbor(i)->info().reached || !impl.blocked(cell, i, radius2))
      continue;
    const std::array<Vertex, 3> vertices = impl.face_vertices(cell, i);
    const auto [p, q, r] = numbered_positions(vertices);
    std::array<uint32_t, 3> corners{vertices[0]->info(), vertices[1]->info(), vertices[2]->info()};
    std::sort(corners.begin(), corners.end());
    sheets.push_back({corners, (q - p).cross(r - p)});
  }
  std::sort(sheets.begin(), sheets.end(),
            [](const SheetTriangle& a, const SheetTriangle& b) { return a.corners < b.corners; });
  std::vector<Eigen::Vector3d> normals(impl.vertices.size(), Eigen::Vector3d::Zero());
  for (const auto& sheet : sheets) {
    for (uint32_t corner : sheet.corners) {
      normals[corner] +=
          normals[corner].dot(sheet.double_area) < 0.0 ? -sheet.double_area : sheet.double_area;
    }
  }
  // Threads: points on neither a body nor a sheet that have a neighbour within the ball.
  std::vector<bool> held = impl.on_body();
  for (const auto& sheet : sheets) {
    for (uint32_t corner : sheet.corners) held[corner] = true;
  }
  std::vector<bool> thread(impl.vertices.size(), false);
  impl.visit_edges([&](const Vertex& a, const Vertex& b) {
    if (held[a->info()] && held[b->info()]) return;
    if ((position(a) - position(b)).squaredNorm() > radius2) return;
    for (const Vertex& end : {a, b}) thread[end->info()] = thread[end->info()] || !held[end->info()];
  });

  size_t thickened = 0;
  const size_t count = impl.vertices.size();
  for (size_t v = 0; v < count; ++v) {
    const Vertex vertex = impl.vertices[v];
    const Eigen::Vector3d middle = position(vertex);
    if (normals[v].squaredNorm() > 0.0) {
      const Eigen::Vector3d half = 0.5 * thickness * normals[v].normalized();
      impl.add(middle + half, vertex);
      impl.add(middle - half, vertex);
      ++thickened;
    } else if (thread[v]) {  // a small tetrahedron of fixed orientation around the point
      for (const Eigen::Vector3d& way : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1, -1, -1),
                                         Eigen::Vector3d(-1, 1, -1), Eigen::Vector3d(-1, -1, 1)}) {
        impl.add(middle + 0.5 * thickness * way.normalized(), vertex);
      }
      ++thickened;
    }
  }
  return thickened;
}

double AlphaComplex::near_surface(double distance) const {
  const Impl& impl = *impl_;
  std::vector<double> depth(impl.vertices.size(), std::numeric_limits<double>::infinity());
  for (Cell cell : impl.delaunay.finite_cell_handles()) {
    if (cell->info().reached) continue;
    for (int i = 0; i < 4; ++i) {
      if (!cell->neighbor(i)->info().reached) continue;
      for (const Vertex& vertex : impl.face_vertices(cell, i)) depth[vertex->info()] = 0.0;
    }
  }
  for (bool changed = true; changed;) {
    changed = false;
    const std::vector<double> before = depth;  // so that the order of the edges does not matter
    const auto reach = [&](const Vertex& from, const Vertex& to, double length) {
      const double through = before[from->info()] + length;
      if (through > distance || through >= depth[to->info()]) return;
      depth[to->info()] = through;
      changed = true;
    };
    impl.visit_edges([&](const Vertex& a, const Vertex& b) {
      const double length = (position(a) - position(b)).norm();
      reach(a, b, length);
      reach(b, a, length);
    });
  }
  const auto near = std::count_if(depth.begin(), depth.begin() + static_cast<std::ptrdiff_t>(impl.cloud_size),
                                  [&](double one) { return one <= distance; });
  return impl.cloud_size > 0 ? static_cast<double>(near) / static_cast<double>(impl.cloud_size) : 0.0;
}

AlphaComplex::Body AlphaComplex::body(double radius) {
  Impl& impl = *impl_;
  impl.flood(radius);

  struct Face {
    std::array<uint32_t, 3> corners;  // point numbers, smallest first
    Cell cell;
    int opposite;
  };
  std::vector<Face> faces;
  for (Cell cell : impl.delaunay.finite_cell_handles()) {
    if (cell->info().reached) continue;
    for (int i = 0; i < 4; ++i) {
      if (!cell->neighbor(i)->info().reached) continue;
      const auto [p, q, r] = impl.face_vertices(cell, i);
      std::array<uint32_t, 3> corners{p->info(), q->info(), r->info()};
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      faces.push_back({corners, cell, i});
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.corners < b.corners; });
  for (size_t f = 0; f < faces.size(); ++f)
    faces[f].cell->info().face[faces[f].opposite] = static_cast<int32_t>(f);

  // Two triangles are twins along an edge if a path around it *inside* the body leads from one to the other.
  // So each half-edge has one twin, also where four or more triangles meet.
  PairedTriangles surface;
  surface.twins.resize(faces.size() * 3);
  const auto half_edge_from = [&](size_t face, uint32_t point) {
    const auto& corners = faces[face].corners;
    return static_cast<uint32_t>(3 * face + (corners[0] == point ? 0 : corners[1] == point ? 1 : 2));
  };
  for (size_t f = 0; f < faces.size(); ++f) {
    surface.corners.push_back(faces[f].corners);
    for (int k = 0; k < 3; ++k) {
      Cell cell = faces[f].cell;
      int from = faces[f].opposite;
      const Vertex a = cell->vertex(kFace[from][k]), b = cell->vertex(kFace[from][(k + 1) % 3]);
      int to = 6 - from - cell->index(a) - cell->index(b);
      while (!cell->neighbor(to)->info().reached) {
        const Cell next = cell->neighbor(to);
        from = next->index(cell);
        cell = next;
        to = 6 - from - cell->index(a) - cell->index(b);
      }
      surface.twins[half_edge_from(f, a->info())] =
          half_edge_from(static_cast<size_t>(cell->info().face[to]), b->info());
    }
  }

  Body body;
  body.mesh = assemble_surface(surface, [&](uint32_t point) { return position(impl.vertices[point]); });
  const std::vector<bool> on = impl.on_body();
  const auto held = std::count(on.begin(), on.begin() + static_cast<std::ptrdiff_t>(impl.cloud_size), true);
  if (impl.cloud_size > 0) body.covered = static_cast<double>(held) / static_cast<double>(impl.cloud_size);
  return body;
}

}  // namespace livegs
