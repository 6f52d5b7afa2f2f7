// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "export/gltf/gltf_values.h"

namespace livegs::gltf {
namespace {

using Eigen::Vector3d;
using Kind = PortableShape::Kind;

Result<void> take_shape(const Values& values, const Json& index, const std::string& where,
                        PortableShape& shape) {
  const Json& shapes = part_of(extension_of(values.document().json(), "KHR_implicit_shapes"), "shapes");
  const auto entry = values.entry_of(shapes, index, where, "shape");
  if (!entry) return entry.error();
  const std::string type = text_of(**entry, "type");
  const Json& measures = part_of(**entry, type.c_str());
  static constexpr Kind kKinds[] = {Kind::Plane, Kind::Box, Kind::Sphere, Kind::Cylinder, Kind::Capsule};
  const auto* kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](Kind one) { return type == name_of(one); });
  if (kind == std::end(kKinds)) return values.bad(where, "has a shape of an unknown type");
  shape.kind = *kind;
  const auto size = values.vector(measures, "size", Vector3d::Ones(), where);
  const auto radius = values.number(measures, "radius", 0.5, where);
  const auto bottom = values.number(measures, "radiusBottom", 0.25, where);
  const auto top = values.number(measures, "radiusTop", 0.25, where);
  const auto height = values.number(measures, "height", 0.5, where);
  if (!size) return size.error();
  if (!radius) return radius.error();
  if (!bottom) return bottom.error();
  if (!top) return top.error();
  if (!height) return height.error();
  if (shape.kind == Kind::Box) shape.size_m = *size;
  if (shape.kind == Kind::Sphere) shape.radius_m = *radius;
  if (shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule) {
    if (*bottom != *top)
      return values.document().missing(where +
                                       " has a shape with two radii, which is not supported; use a mesh");
    shape.radius_m = *bottom;
    shape.height_m = *height;
  }
  return {};
}

Result<void> take_mesh(const Values& values, const Json& index, const std::string& where,
                       PortableShape& shape) {
  const auto mesh = values.document().entry("meshes", index);
  if (!mesh) return mesh.error();
  auto read = std::make_shared<TriangleMesh>();
  const Json& primitives = part_of(**mesh, "primitives");
  if (!primitives.is_array()) return values.bad(where, "has a collider mesh without primitives");
  for (const Json& primitive : primitives) {
    if (part_of(primitive, "mode").is_number() && primitive["mode"] != 4) continue;
    const auto positions =
        values.document().numbers(part_of(part_of(primitive, "attributes"), "POSITION"), 3);
    if (!positions) return positions.error();
    if (auto within = values.spend(6 * positions->count); !within) return within;
    const auto first = static_cast<uint32_t>(read->vertices_m.size());
    for (size_t i = 0; i < positions->count; ++i)
      read->vertices_m.emplace_back(positions->at(i, 0), positions->at(i, 1), positions->at(i, 2));
    std::vector<uint32_t> indices(positions->count);
    for (size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<uint32_t>(i);
    if (primitive.contains("indices")) {
      auto listed = values.whole_numbers(primitive["indices"]);
      if (!listed) return listed.error();
      indices = std::move(*listed);
    }
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
      for (size_t k = 0; k < 3; ++k) {
        if (indices[i + k] >= positions->count)
          return values.bad(where, "has a collider mesh with a wrong index");
      }
      read->triangles.push_back({first + indices[i], first + indices[i + 1], first + indices[i + 2]});
    }
  }
  if (read->triangles.empty()) return values.bad(where, "has a collider mesh without triangles");
  for (const Vector3d& vertex : read->vertices_m) {
    if (!(vertex.cwiseAbs().maxCoeff() <= kMaxNumber))
      return values.bad(where, "has a collider mesh with a wrong vertex");
  }
  shape.kind = Kind::Mesh;
  shape.mesh = std::move(read);
  return {};
}

}  // namespace

Result<PortableShape> read_collider(const Values& values, const Json& collider, const std::string& where) {
  PortableShape shape;
  const Json& geometry = part_of(collider, "geometry");
  if (geometry.contains("shape")) {
    if (auto taken = take_shape(values, geometry["shape"], where, shape); !taken) return taken.error();
  } else {
    Json mesh = part_of(geometry, "mesh");
    if (mesh.is_null()) {
      const auto node = values.document().entry("nodes", part_of(geometry, "node"));
      if (!node) return node.error();
      mesh = part_of(**node, "mesh");
    }
    if (auto taken = take_mesh(values, mesh, where, shape); !taken) return taken.error();
    shape.convex = flag_of(geometry, "convexHull");
  }
  if (collider.contains("physicsMaterial")) {
    const Json& materials =
        part_of(extension_of(values.document().json(), "KHR_physics_rigid_bodies"), "physicsMaterials");
    const auto material = values.entry_of(materials, collider["physicsMaterial"], where, "physicsMaterial");
    if (!material) return material.error();
    const auto friction = values.number(**material, "dynamicFriction", shape.friction, where);
    const auto restitution = values.number(**material, "restitution", shape.restitution, where);
    if (!friction) return friction.error();
    if (!restitution) return restitution.error();
    shape.friction = *friction;
    shape.restitution = *restitution;
  }
  return shape;
}

}  // namespace livegs::gltf
