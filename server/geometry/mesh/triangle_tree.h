// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// The triangle of a mesh that is nearest to a point, by nested boxes. Immutable after building; any thread
// may ask.
class TriangleTree {
 public:
  // Triangles without area are left out.
  explicit TriangleTree(const TriangleMesh& mesh);

  struct Nearest {
    double distance_m;  // infinite where there is no triangle
    Eigen::Vector3d foot_m;
    // Unit, of the nearest triangle. Of several that share the foot, on an edge or at a corner, of the one
    // whose plane is farthest from the point: of a closed mesh its side is the point's (Sigg 2003, Signed
    // distance transform, 3).
    Eigen::Vector3d normal;
  };
  Nearest nearest(const Eigen::Vector3d& point_m) const;

  size_t size() const { return triangles_.size(); }

 private:
  struct Triangle {
    std::array<Eigen::Vector3d, 3> corner_m;
    Eigen::Vector3d normal;
  };
  struct Box {
    Eigen::Vector3d min_m, max_m;
    uint32_t begin, end;  // of triangles_
    uint32_t second;      // its second child, the first one follows it; 0: a leaf
  };
  void add_box(uint32_t begin, uint32_t end);

  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
};

}  // namespace livegs
