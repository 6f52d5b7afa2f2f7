// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build_object.h"

#include "core/clock.h"
#include "geometry/mesh_facts.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/sample_particles.h"
#include "geometry/shape_mesh.h"
#include "scene/check_scene.h"
#include "scene/place_asset.h"
#include "scene/points_file.h"
#include "scene/scene_values.h"
#include "scene/shape_asset.h"

namespace livegs {
namespace {

constexpr size_t kFewestPointVolumes = 1;

// What all three forms come down to.
struct Form {
  std::shared_ptr<const GaussianAsset> asset;
  Similarity object_from_asset;
  std::vector<Eigen::Vector3d> points_m;  // for surfaces; empty for shapes
  TriangleMesh mesh;      // fine surface, object frame; empty for points until a rigid body needs it
  ParticleSet particles;  // points only
  std::vector<Eigen::Vector3d> particle_velocities_m_s;
  std::string surface_note;
  bool scale_known = true;
  std::string scale_reason = "told by the scene";
};

TriangleMesh mesh_of(const v1::Shape& shape) {
  switch (shape.kind_case()) {
    case v1::Shape::kSphere:
      return sphere_mesh(shape.sphere().radius_m(), 3);
    case v1::Shape::kCylinder:
      return cylinder_mesh(shape.cylinder().radius_m(), shape.cylinder().height_m());
    case v1::Shape::kCapsule:
      return capsule_mesh(shape.capsule().radius_m(), shape.capsule().height_m());
    default: {
      const Numbers& size = shape.box().size_m();
      return box_mesh(Eigen::Vector3d(size[0], size[1], size[2]));
    }
  }
}

Result<Form> form_of_points(const v1::Object& object, const std::filesystem::path& folder, int index) {
  auto list = read_points_file(folder / object.points());
  if (!list) return list.error();
  Form form;
  ParticleSet& particles = form.particles;
  particles.spacing_m = object.has_spacing_m() ? object.spacing_m() : median_spacing_m(list->positions_m);
  if (!(particles.spacing_m > 0)) {
    return invalid_data(object.points() +
                        ": the spacing of its points is zero; give spacing_m or points that differ");
  }
  const double volume = particles.spacing_m * particles.spacing_m * particles.spacing_m;
  const size_t count = std::max(list->positions_m.size(), kFewestPointVolumes);
  particles.positions_m = std::move(list->positions_m);
  particles.volumes_m3.assign(count, volume);
  particles.on_surface.assign(count, true);
  form.particle_velocities_m_s = std::move(list->velocities_m_s);
  form.points_m = particles.positions_m;
  form.asset = std::make_shared<GaussianAsset>(
      point_asset(particles.positions_m, particles.spacing_m, palette_rgb(index)));
  return form;
}

Result<Form> form_of(const v1::Object& object, const std::filesystem::path& folder, int index,
                     const std::string& name, const std::string& field) {
  if (object.form_case() == v1::Object::kPoints) return form_of_points(object, folder, index);
  Form form;
  if (object.form_case() == v1::Object::kShape) {
    form.mesh = mesh_of(object.shape());
    form.asset = std::make_shared<GaussianAsset>(mesh_asset(form.mesh, palette_rgb(index)));
    return form;
  }
  const auto scale = object.has_scale() ? std::optional(object.scale()) : std::nullopt;
  auto placed = place_asset(folder / object.asset(), name, scale, object.up(), field);
  if (!placed) return placed.error();
  auto surface = reconstruct_surface(placed->body_points_m, elastic_surface_options());
  if (!surface) return surface.error();
  form.asset = std::move(placed->asset);
  form.object_from_asset = placed->object_from_asset;
  form.points_m = std::move(placed->body_points_m);
  form.mesh = std::move(surface->mesh);
  form.surface_note = std::move(surface->note);
  form.scale_known = placed->scale_known;
  form.scale_reason = std::move(placed->scale_reason);
  return form;
}

// The facts of a list of points come from its particles' volume and bounds; a surface is made for everything
// else.
Result<ObjectFacts> facts_of(Form& form, const std::string& name, bool points) {
  ObjectFacts facts;
  facts.name = name;
  facts.scale_known = form.scale_known;
  facts.appearance = appearance_facts(*form.asset);
  if (points) {
    auto surface = reconstruct_surface(form.points_m, elastic_surface_options());
    if (!surface) return surface.error();
    form.mesh = std::move(surface->mesh);
    form.surface_note = std::move(surface->note);
  }
  facts.mesh = mesh_facts(form.mesh);
  if (points) {
    facts.mesh.volume_m3 = 0;
    for (double volume : form.particles.volumes_m3) facts.mesh.volume_m3 += volume;
  }
  return facts;
}

// A rigid asset collides as LIVE-GS's coarse mesh; shapes as themselves.
Result<TriangleMesh> rigid_mesh(const Form& form, bool shape) {
  if (shape) return form.mesh;
  auto surface = reconstruct_surface(form.points_m, rigid_surface_options());
  if (!surface) return surface.error();
  return std::move(surface->mesh);
}

MassProperties properties_of(const TriangleMesh& mesh, Fill fill) {
  return fill == Fill::Shell || fill == Fill::OpenShell ? shell_mass_properties(mesh)
                                                        : solid_mass_properties(mesh);
}

}  // namespace

std::shared_ptr<const DistanceField> collision_field(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) bounds.extend(vertex);
  const double cell = bounds.sizes().maxCoeff() / kFieldCells;
  return std::make_shared<DistanceField>(mesh, cell, 2 * cell);
}

Result<BuiltObject> build_object(const v1::Object& object, const std::filesystem::path& folder, int index,
                                 const std::string& field) {
  const int64_t started_ns = now_ns();
  const auto fail = [&](const Error& error) {
    return Error{error.code, error.message.starts_with(field) ? error.message : field + ": " + error.message};
  };
  const std::string name = object_name(object, index);
  const bool points = object.form_case() == v1::Object::kPoints;
  const bool shape = object.form_case() == v1::Object::kShape;
  auto form = form_of(object, folder, index, name, field);
  if (!form) return fail(form.error());
  auto facts = facts_of(*form, name, points);
  if (!facts) return fail(facts.error());
  auto parameters = merge_scene_physics(estimate_offline(*facts), object.physics(), *facts);
  if (!parameters) return Error{parameters.error().code, field + ".physics." + parameters.error().message};
  v1::EstimatedValue& side = *parameters->mutable_longest_side_m();
  side.set_best(facts->mesh.size_m.maxCoeff());
  side.set_low(side.best() * (form->scale_known ? 1.0 : 0.5));
  side.set_high(side.best() * (form->scale_known ? 1.0 : 2.0));
  side.set_source(form->scale_known ? v1::EstimatedValue::SCENE : v1::EstimatedValue::OFFLINE);
  side.set_reason(form->scale_reason);

  BuiltObject built;
  const Material material = to_material(*parameters);
  const Pose pose = pose_value(object.pose(), field + ".pose").value();  // checked when the file was read
  const Eigen::Vector3d velocity =
      vector_value(object.velocity_m_s(), Eigen::Vector3d::Zero(), field).value();
  const Eigen::Vector3d spin =
      vector_value(object.angular_velocity_rad_s(), Eigen::Vector3d::Zero(), field).value();
  switch (material.behavior) {
    case Behavior::Elastic: {
      ElasticBodyDescription body;
      body.particles = points ? std::move(form->particles)
                              : sample_particles(form->mesh, kDefaultSamplingDensity, object.spacing_m());
      body.material = material;
      body.world_from_object = pose;
      body.velocity_m_s = velocity;
      body.angular_velocity_rad_s = spin;
      body.particle_velocities_m_s = std::move(form->particle_velocities_m_s);
      for (const v1::Region& region : object.regions()) {
        body.regions.push_back(fixed_box(
            vector_value(region.box().min_m(), Eigen::Vector3d::Constant(-kLargestCoordinate), field).value(),
            vector_value(region.box().max_m(), Eigen::Vector3d::Constant(kLargestCoordinate), field).value()));
      }
      built.drawn.rest_particles_m = body.particles.positions_m;
      built.body = std::move(body);
      break;
    }
    case Behavior::Static: {
      built.body =
          StaticBodyDescription{pose, collision_field(form->mesh), material.friction, material.restitution};
      break;
    }
    default: {
      if (object.regions_size() > 0) {
        return invalid_argument(field + ".regions: a rigid object has none; set physics.behavior to ELASTIC");
      }
      RigidBodyDescription body;
      auto mesh = rigid_mesh(*form, shape);
      if (!mesh) return fail(mesh.error());
      body.mesh = std::move(*mesh);
      body.properties = properties_of(body.mesh, material.fill);
      body.material = material;
      body.world_from_object = pose;
      body.velocity_m_s = velocity;
      body.angular_velocity_rad_s = spin;
      built.body = std::move(body);
    }
  }
  built.drawn.name = name;
  built.drawn.asset = std::move(form->asset);
  built.drawn.physics = std::move(*parameters);
  built.drawn.mass_kg = material.behavior == Behavior::Static ? 0.0 : material.mass_kg;
  built.drawn.surface_note = std::move(form->surface_note);
  built.drawn.facts = std::make_shared<const ObjectFacts>(std::move(*facts));
  built.object_from_asset = form->object_from_asset;
  built.body_points_m = shape ? std::move(form->mesh.vertices_m) : std::move(form->points_m);
  built.build_ms = milliseconds_from_ns(now_ns() - started_ns);
  return built;
}

}  // namespace livegs
