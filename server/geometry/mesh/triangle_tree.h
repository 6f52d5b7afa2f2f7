// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// A bounding volume hierarchy for the triangle nearest to a point. Immutable after construction; any thread
// may query.
class TriangleTree {
 public:
  // Triangles without area are skipped.
  explicit TriangleTree(const TriangleMesh& mesh);

  struct Nearest {
    double distance_m;  // infinity if there is no triangle
    Eigen::Vector3d foot_m;
    // Unit normal of the nearest triangle. If several share the nearest point, on an edge or at a corner, the
    // one whose plane is farthest from the point. For a closed mesh its sign is the side of the point (Sigg
    // 2003, Signed distance transform, 3).
    Eigen::Vector3d normal;
    uint32_t triangle;  // index in the mesh; 0 if there is none
  };
  Nearest nearest(const Eigen::Vector3d& point_m) const;

  size_t size() const { return triangles_.size(); }

 private:
  struct Triangle {
    std::array<Eigen::Vector3d, 3> corner_m;
    Eigen::Vector3d normal;
    uint32_t index;  // in the mesh
  };
  struct Box {
    Eigen::Vector3d min_m, max_m;
    uint32_t begin, end;  // range in triangles_
    uint32_t second;      // index of the second child; the first one is next; 0: a leaf
  };
  void add_box(uint32_t begin, uint32_t end);

  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
};

}  // namespace livegs
