// SPDX-License-Identifier: Apache-2.0
#include "geometry/surface/alpha_complex.h"

#include <CGAL/Alpha_shape_3.h>
#include <CGAL/Alpha_shape_cell_base_3.h>
#include <CGAL/Alpha_shape_vertex_base_3.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <cmath>
#include <list>

#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

// Volume of the regularised alpha shape, computed by CGAL (its alpha is the squared radius).
double cgal_alpha_volume(const testing::Points& points, double radius) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Cells = CGAL::Triangulation_data_structure_3<CGAL::Alpha_shape_vertex_base_3<Kernel>,
                                                     CGAL::Alpha_shape_cell_base_3<Kernel>>;
  using Shape = CGAL::Alpha_shape_3<CGAL::Delaunay_triangulation_3<Kernel, Cells>>;
  std::vector<Kernel::Point_3> cloud;
  for (const auto& p : points) cloud.emplace_back(p.x(), p.y(), p.z());
  Shape shape(cloud.begin(), cloud.end(), radius * radius, Shape::REGULARIZED);
  std::list<Shape::Cell_handle> cells;
  shape.get_alpha_shape_cells(std::back_inserter(cells), Shape::INTERIOR);
  double volume = 0.0;
  for (const auto& cell : cells) volume += shape.tetrahedron(cell).volume();
  return volume;
}

TEST(AlphaComplex, MatchesCgalForAFilledCloud) {
  // A filled cloud has no cavity wider than the ball; CGAL's shape would keep it open.
  const testing::Points points = testing::cloud(4000, 7, [](testing::Random& r) {
    Eigen::Vector3d p = r.in_cube();
    return Eigen::Vector3d(p.x(), 0.5 * p.y(), 0.3 * p.z());
  });
  AlphaComplex complex(points);
  for (double radius : {0.25, 0.4, 1.0}) {
    const double ours = signed_volume_m3(complex.body(radius).mesh),
                 theirs = cgal_alpha_volume(points, radius);
    ASSERT_GT(theirs, 0.8);
    EXPECT_NEAR(ours / theirs, 1.0, 1e-9) << radius;
  }
}

TEST(AlphaComplex, FillsRegionsOutOfReachOfTheBall) {
  const testing::Points points = testing::sphere_cloud(3000, 1.0);
  AlphaComplex complex(points);
  // The shell itself has almost no volume; the ball behind it is filled.
  EXPECT_LT(cgal_alpha_volume(points, 0.3), 0.5);
  EXPECT_NEAR(signed_volume_m3(complex.body(0.3).mesh), 4.189, 0.03 * 4.189);
  // A ball smaller than the gaps enters and removes everything.
  EXPECT_LT(signed_volume_m3(complex.body(0.02).mesh), 0.01);
}

TEST(AlphaComplex, BodiesAreManifoldForAnyRadius) {
  const testing::Points points = testing::cloud(600, 9, [](testing::Random& r) { return r.in_cube(); });
  AlphaComplex complex(points);
  // At small radii the body is a set of tetrahedra that touch in faces, edges and corners.
  for (double radius = 0.05; radius < 0.5; radius *= 1.15) {
    const TriangleMesh mesh = complex.body(radius).mesh;
    if (mesh.triangles.empty()) continue;
    const MeshTopology topology = mesh_topology(mesh);
    EXPECT_TRUE(topology.closed) << radius;
    EXPECT_TRUE(topology.manifold) << radius;
    EXPECT_GT(signed_volume_m3(mesh), 0.0) << radius;
    // A closed surface has a characteristic of at most 2.
    EXPECT_LE(topology.euler_characteristic, 2 * topology.piece_count) << radius;
  }
}

TEST(AlphaComplex, GridsOfPointsStayConnected) {
  // The eight corners of each cell lie on one sphere: the triangulation consists of degenerate cases.
  testing::Points points;
  for (int x = 0; x <= 8; ++x) {
    for (int y = 0; y <= 6; ++y) {
      for (int z = 0; z <= 4; ++z) points.emplace_back(0.1 * x, 0.1 * y, 0.1 * z);
    }
  }
  AlphaComplex complex(points);
  const TriangleMesh mesh = complex.body(0.1).mesh;  // half a cell's diagonal is 0.087
  testing::expect_body(mesh);
  EXPECT_NEAR(signed_volume_m3(mesh), 0.8 * 0.6 * 0.4, 1e-12);
}

}  // namespace
}  // namespace livegs
