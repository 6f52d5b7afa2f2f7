// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/collect_scene.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <set>

#include "analysis/estimate.h"
#include "core/text/shown_text.h"
#include "geometry/mesh/mesh_io.h"
#include "geometry/reconstruct_surface.h"
#include "physics/collision/collision_shape.h"
#include "scene/build/build_cache.h"
#include "scene/build/build_object.h"
#include "scene/build/elastic_report.h"
#include "scene/check/check_object.h"
#include "scene/check/joint_parts.h"
#include "scene/check/sidecar_paths.h"
#include "scene/environment/environment.h"
#include "scene/scene.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Kind = PortableShape::Kind;

void set_inertia(PortableBody& body, const Matrix3d& inertia_kg_m2) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertia_kg_m2);
  body.inertia_kg_m2 = solver.eigenvalues();
  Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  body.object_from_inertia = Eigen::Quaterniond(axes).normalized();
}

PortableShape shape_of(const v1::Shape& shape) {
  PortableShape result;
  switch (shape.kind_case()) {
    case v1::Shape::kSphere:
      result.kind = Kind::Sphere;
      result.radius_m = shape.sphere().radius_m();
      break;
    case v1::Shape::kCylinder:
    case v1::Shape::kCapsule: {
      const v1::CylinderShape& round = shape.has_cylinder() ? shape.cylinder() : shape.capsule();
      result.kind = shape.has_cylinder() ? Kind::Cylinder : Kind::Capsule;
      result.radius_m = round.radius_m();
      result.height_m = round.height_m();
      break;
    }
    default: {
      const Numbers& size = shape.box().size_m();
      result.size_m = {size[0], size[1], size[2]};
    }
  }
  return result;
}

PortableShape shape_of(TriangleMesh mesh, bool convex) {
  PortableShape result;
  result.kind = Kind::Mesh;
  result.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  result.convex = convex;
  return result;
}

// Mass, centre and inertia of the particles at rest.
void weigh_particles(const ElasticBodyDescription& description, const ElasticBody& simulated,
                     PortableBody& body) {
  const std::vector<ParticleState> particles = simulated.particles();
  const std::vector<Vector3d>& rest_m = description.particles.positions_m;
  double mass_kg = 0;
  Vector3d moment = Vector3d::Zero();
  for (size_t i = 0; i < rest_m.size(); ++i) {
    mass_kg += particles[i].mass_kg;
    moment += particles[i].mass_kg * rest_m[i];
  }
  body.mass_kg = simulated.mass_kg();
  body.centre_m = moment / mass_kg;
  Matrix3d inertia = Matrix3d::Zero();
  for (size_t i = 0; i < rest_m.size(); ++i) {
    const Vector3d arm = rest_m[i] - body.centre_m;
    const double edge_m = std::cbrt(description.particles.volumes_m3[i]);
    inertia += particles[i].mass_kg *
               ((arm.squaredNorm() + edge_m * edge_m / 6) * Matrix3d::Identity() - arm * arm.transpose());
  }
  set_inertia(body, inertia * (body.mass_kg / mass_kg));
}

PortableElastic elastic_of(const Material& material, const v1::Object& object, const SceneObject& drawn) {
  PortableElastic elastic;
  elastic.youngs_modulus_pa = material.youngs_modulus_pa;
  elastic.poisson_ratio = material.poisson_ratio;
  elastic.structure_coefficient = material.structure_coefficient;
  elastic.plasticity = material.plasticity;
  elastic.damping = material.loss_factor;
  if (drawn.elastic) elastic.accuracy = accuracy_message(*drawn.elastic);
  elastic.regions.assign(object.regions().begin(), object.regions().end());
  elastic.lattice.kind = DriverKind::Lattice;
  elastic.lattice.object_from_lattice = drawn.rest.object_from_lattice;
  elastic.lattice.cell_width_m = drawn.rest.cell_width_m;
  elastic.lattice.node_coordinates = drawn.rest.node_coordinates;
  elastic.lattice.cells = drawn.rest.cells;
  elastic.lattice.cell_fills = drawn.rest.cell_fills;
  return elastic;
}

Result<PortableBody> body_of(const v1::Object& object, const BuiltObject& built, const SceneObject& drawn,
                             const World& world) {
  PortableBody body;
  body.name = drawn.name;
  body.behavior = drawn.physics.behavior();
  body.hidden = object.hidden();
  body.estimates = drawn.physics;
  body.asset = built.drawn.asset;
  body.kernel_count = body.asset->size();
  body.object_from_asset = built.object_from_asset;
  const Material material = to_material(drawn.physics);
  body.friction = material.friction;
  body.restitution = material.restitution;
  const bool shaped = object.form_case() == v1::Object::kShape;
  if (const auto* rigid = std::get_if<RigidBodyDescription>(&built.body)) {
    body.world_from_object = rigid->world_from_object;
    body.velocity_m_s = rigid->velocity_m_s;
    body.angular_velocity_rad_s = rigid->angular_velocity_rad_s;
    body.mass_kg = rigid->material.mass_kg;
    body.centre_m = rigid->properties.centre_of_mass_m;
    set_inertia(body, body.mass_kg * rigid->properties.inertia_m2);
    const bool exact = shaped && (rigid->sphere_radius_m > 0 || rigid->round || object.shape().has_box());
    if (exact) {
      body.shapes.push_back(shape_of(object.shape()));
    } else {
      body.shapes.push_back(shape_of(rigid->mesh, rigid->shape && rigid->shape->convex));
    }
  } else if (shaped) {
    body.shapes.push_back(shape_of(object.shape()));
  } else {
    auto surface = reconstruct_surface(built.body_points_m, elastic_surface_options());
    if (!surface) return of_object(surface.error(), body.name);
    body.shapes.push_back(shape_of(std::move(surface->mesh), false));
  }
  if (const auto* fixed = std::get_if<StaticBodyDescription>(&built.body))
    body.world_from_object = fixed->world_from_object;
  if (const auto* elastic = std::get_if<ElasticBodyDescription>(&built.body)) {
    body.world_from_object = elastic->world_from_object;
    body.velocity_m_s = elastic->velocity_m_s;
    body.angular_velocity_rad_s = elastic->angular_velocity_rad_s;
    weigh_particles(*elastic, *world.elastic_body(drawn.id), body);
    body.elastic = elastic_of(elastic->material, object, drawn);
  }
  for (PortableShape& shape : body.shapes) {
    shape.friction = body.friction;
    shape.restitution = body.restitution;
  }
  return body;
}

void add_surroundings(const v1::Environment& file, const std::filesystem::path& folder,
                      const BuiltEnvironment& built, PortableScene& scene) {
  for (size_t i = 0; i < built.colliders.size(); ++i) {
    const Collider& collider = built.colliders[i];
    PortableShape shape;
    if (std::holds_alternative<PlaneShape>(collider.shape)) {
      shape.kind = Kind::Plane;
    } else if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
      shape.size_m = box->size_m;
    } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
      shape.kind = Kind::Sphere;
      shape.radius_m = sphere->radius_m;
    } else if (i < static_cast<size_t>(file.colliders_size())) {
      auto mesh = read_obj(folder / file.colliders(static_cast<int>(i)).mesh());
      if (!mesh) continue;  // it was read a moment ago
      shape = shape_of(std::move(*mesh), false);
    } else {
      shape.kind = Kind::Mesh;
      shape.mesh = built.asset_surface;
    }
    shape.owner_from_shape = collider.world_from_collider;
    shape.friction = collider.friction;
    shape.restitution = collider.restitution;
    scene.fixed.push_back(std::move(shape));
  }
  if (!built.asset) return;
  PortableBody drawn;
  std::set<std::string> names;
  for (const PortableBody& body : scene.bodies) names.insert(body.name);
  drawn.name = "environment";
  while (names.contains(drawn.name)) drawn.name = "drawn " + drawn.name;
  drawn.drawn_only = true;
  drawn.world_from_object = built.world_from_object;
  drawn.asset = built.asset;
  drawn.kernel_count = built.asset->size();
  drawn.object_from_asset = built.object_from_asset;
  scene.bodies.push_back(std::move(drawn));
}

}  // namespace

Result<PortableScene> collect_scene(const std::filesystem::path& path) {
  auto text = read_scene(path);
  if (!text) return text.error();
  const v1::Scene& file = text->file;
  SceneOptions options;
  options.cut_fragile = false;
  options.cache = std::make_shared<BuildCache>();
  const auto running = Scene::load(path, options);
  if (!running) return running.error();
  const World& world = running->world();

  PortableScene scene;
  scene.name = text->name;
  scene.gravity_m_s2 = world.settings().gravity_m_s2;
  scene.rate_hz = world.settings().rate_hz;
  const auto count = static_cast<size_t>(file.objects_size());
  const std::vector<std::filesystem::path> sidecars = sidecar_paths(file, text->folder, text->name);
  std::vector<std::optional<Result<BuiltObject>>> built(count);
  std::map<std::string, size_t> by_name;
  for (size_t i = 0; i < count; ++i) {
    const v1::Object& object = file.objects(static_cast<int>(i));
    const std::string name = object_name(object, static_cast<int>(i));
    // From the cache: the bodies of the scene above.
    built[i] =
        build_cached_object(*options.cache, object, text->folder, static_cast<int>(i),
                            "objects[" + std::to_string(i) + "]", world.settings(), {sidecars[i], nullptr});
    if (!*built[i]) return of_object(built[i]->error(), name);
    const SceneObject* drawn = running->find_in_file(name);
    if (!drawn) return Error{ErrorCode::Internal, shown_line(name) + ": is not in the scene that was built"};
    auto body = body_of(object, **built[i], *drawn, world);
    if (!body) return body.error();
    by_name[name] = scene.bodies.size();
    scene.bodies.push_back(std::move(*body));
  }
  const auto surroundings = build_environment(options.cache.get(), file.environment(), text->folder, built);
  if (!surroundings) return surroundings.error();
  add_surroundings(file.environment(), text->folder, **surroundings, scene);
  for (const v1::Joint& joint : file.joints()) {
    const JointParts parts = parts_of(joint);
    PortableJoint one;
    one.hinge = parts.axis != nullptr;
    one.body = by_name.at(parts.object);
    if (!parts.other.empty()) one.other = by_name.at(parts.other);
    one.point_m = vector_value(*parts.point_m, Vector3d::Zero(), "").value();
    if (parts.axis) one.axis = vector_value(*parts.axis, Vector3d::UnitX(), "").value().normalized();
    scene.joints.push_back(one);
  }
  return scene;
}

}  // namespace livegs
