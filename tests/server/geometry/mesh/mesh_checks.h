// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "geometry/mesh/mesh_topology.h"

namespace livegs::testing {

inline void expect_body(const TriangleMesh& mesh) {
  const MeshTopology topology = mesh_topology(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.manifold);
  EXPECT_GT(signed_volume_m3(mesh), 0.0);
  for (const auto& vertex : mesh.vertices_m) ASSERT_TRUE(vertex.allFinite());
}

inline TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& way_m) {
  for (auto& vertex : mesh.vertices_m) vertex += way_m;
  return mesh;
}

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto start = static_cast<uint32_t>(a.vertices_m.size());
  a.vertices_m.insert(a.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({start + i, start + j, start + k});
  return a;
}

}  // namespace livegs::testing
