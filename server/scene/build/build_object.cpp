// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/build_object.h"

#include "analysis/physics_file.h"
#include "analysis/sidecar/manual_edits.h"
#include "core/clock.h"
#include "core/log.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/standing_base.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/surface/hollow_mesh.h"
#include "geometry/surface/mesh_facts.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "prepare/mesh_collider.h"
#include "scene/build/fracture_warning.h"
#include "scene/build/part_materials.h"
#include "scene/build/place_asset.h"
#include "scene/build/shape_asset.h"
#include "scene/build/too_stiff_for_lattice.h"
#include "scene/check/check_object.h"
#include "scene/values/points_file.h"
#include "scene/values/region_value.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

// Memory of a contact shape, about: a distance field of a hundred thousand numbers.
constexpr size_t kContactShapeBytes = 400'000;

// Common result of the three forms of an object: asset, shape and list of points.
struct Form {
  std::shared_ptr<const GaussianAsset> asset;
  Similarity object_from_asset;
  std::vector<Eigen::Vector3d> points_m;          // for the surface; empty for shapes
  TriangleMesh mesh;                              // fine surface, object frame
  std::shared_ptr<const SurfaceKernels> kernels;  // of an asset
  ParticleSet particles;                          // only for a list of points
  std::vector<Eigen::Vector3d> particle_velocities_m_s;
  std::string surface_note;
  bool scale_known = true;
  std::string scale_reason = "given in the scene file";
};

std::optional<RoundShape> round_shape(const v1::Shape& shape) {
  const auto of = [](RoundShape::Kind kind, const v1::CylinderShape& measures) {
    RoundShape round;
    round.kind = kind;
    round.radius_m = measures.radius_m();
    round.half_length_m = 0.5 * measures.height_m();
    return round;
  };
  if (shape.has_cylinder()) return of(RoundShape::Kind::Cylinder, shape.cylinder());
  if (shape.has_capsule()) return of(RoundShape::Kind::Capsule, shape.capsule());
  return std::nullopt;
}

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
  auto surface = reconstruct_surface(list->positions_m, elastic_surface_options());
  if (!surface) return surface.error();
  Form form;
  form.mesh = std::move(surface->mesh);  // the note about repairs is dropped: the points are the body
  ParticleSet& particles = form.particles;
  particles.spacing_m =
      object.has_spacing_m() ? object.spacing_m() : filling_spacing_m(list->positions_m, form.mesh);
  if (!(particles.spacing_m > 0)) {
    return invalid_data(object.points() + ": point spacing is zero; give spacing_m or distinct points");
  }
  const double volume = particles.spacing_m * particles.spacing_m * particles.spacing_m;
  const size_t count = list->positions_m.size();
  particles.positions_m = std::move(list->positions_m);
  particles.volumes_m3.assign(count, volume);
  particles.on_surface.assign(count,
                              false);  // each point stands for a cube: the body ends half a spacing beyond
  form.particle_velocities_m_s = std::move(list->velocities_m_s);
  form.points_m = particles.positions_m;
  const bool kernel_per_point = !object.has_kernel_per_point() || object.kernel_per_point();
  form.asset = std::make_shared<GaussianAsset>(
      kernel_per_point ? point_asset(particles.positions_m, particles.spacing_m, palette_rgb(index))
                       : mesh_asset(form.mesh, palette_rgb(index)));
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
  const auto assumed = object.has_assumed_scale() ? std::optional(object.assumed_scale()) : std::nullopt;
  auto placed = place_asset(folder / object.asset(), name, scale, object.up(), field, assumed);
  if (!placed) return placed.error();
  auto surface = reconstruct_surface(placed->body_points_m, elastic_surface_options());
  if (!surface) return surface.error();
  form.asset = std::move(placed->asset);
  form.object_from_asset = placed->object_from_asset;
  form.kernels = std::make_shared<const SurfaceKernels>(surface_kernels(*form.asset, form.object_from_asset));
  form.points_m = std::move(placed->body_points_m);
  form.mesh = std::move(surface->mesh);
  form.surface_note = std::move(surface->note);
  form.scale_known = placed->scale_known;
  if (object.standing() && !placed->up_known)
    log_info("%s: the file names no up axis; -y is assumed; set \"up\" in a scene file", name.c_str());
  form.scale_reason = std::move(placed->scale_reason);
  return form;
}

// The form of an asset is kept: with other physical parameters it is the same.
Result<Form> cached_form(const v1::Object& object, const std::filesystem::path& folder, int index,
                         const std::string& name, const std::string& field, BuildCache& cache) {
  if (object.form_case() != v1::Object::kAsset) return form_of(object, folder, index, name, field);
  v1::Object read;  // fields on which the form of an asset depends, with its name
  read.set_asset(object.asset());
  if (object.has_scale()) read.set_scale(object.scale());
  if (object.has_assumed_scale()) read.set_assumed_scale(object.assumed_scale());
  read.set_up(object.up());
  read.set_standing(object.standing());
  read.set_name(name);
  const std::string key =
      "form " + field + ' ' + read.SerializeAsString() + BuildCache::stamp_of(folder / object.asset());
  return *cache.value<Result<Form>>(
      key, [&] { return form_of(object, folder, index, name, field); },
      [](const Result<Form>& form) {
        return form ? BuildCache::kKernelBytes * form->asset->size() +
                          sizeof(Eigen::Vector3d) * form->points_m.size()
                    : size_t{1000};
      });
}

// The volume of a list of points is the sum over its particles; the volume of other forms is enclosed by the
// surface.
ObjectFacts facts_of(const Form& form, const std::string& name, bool captured, const std::string& shape_key,
                     BuildCache& cache) {
  ObjectFacts facts;
  facts.name = name;
  facts.scale_known = form.scale_known;
  facts.solid = !captured;
  facts.appearance = appearance_facts(*form.asset);
  facts.kernels = form.kernels;
  facts.mesh = shape_key.empty() ? mesh_facts(form.mesh)
                                 : *cache.value<MeshFacts>(
                                       "facts " + shape_key, [&] { return mesh_facts(form.mesh); },
                                       [](const MeshFacts& known) { return sizeof known; });
  if (!form.particles.volumes_m3.empty()) {
    facts.mesh.volume_m3 = 0;
    for (double volume : form.particles.volumes_m3) facts.mesh.volume_m3 += volume;
  }
  return facts;
}

// Selects the collision mesh of a rigid body. An asset uses the coarse mesh of LIVE-GS. A shape uses its own
// mesh. A fragile asset uses the fine surface that is cut, so that its fragments have sharp edges and their
// masses add up to the mass of the whole.
Result<TriangleMesh> rigid_mesh(const Form& form, bool fine) {
  if (fine) return form.mesh;
  auto surface = reconstruct_surface(form.points_m, rigid_surface_options());
  if (!surface) return surface.error();
  return std::move(surface->mesh);
}

// Makes the base of a captured thing flat, so that it stands. Returns the base; nullopt, and the mesh
// unchanged, if there is none or if a part of the volume would go, such as the floor of a tray.
std::optional<StandingBase> stand(TriangleMesh& mesh, const Eigen::Vector3d& centre_of_mass_m) {
  constexpr double kMinVolume = 0.8;  // after over before
  const auto volume_m3 = [](const TriangleMesh& of) {
    double six = 0.0;
    for (const auto& triangle : of.triangles)
      six += of.vertices_m[triangle[0]].dot(of.vertices_m[triangle[1]].cross(of.vertices_m[triangle[2]]));
    return six / 6.0;
  };
  const auto base = standing_base(mesh.vertices_m, centre_of_mass_m);
  if (!base) return base;
  TriangleMesh flat = mesh;
  flatten_base(flat.vertices_m, *base, centre_of_mass_m);
  if (volume_m3(flat) < kMinVolume * volume_m3(mesh)) return std::nullopt;
  mesh = std::move(flat);
  return base;
}

// `part_warnings`: set to those of weigh_parts().
MassProperties properties_of(const TriangleMesh& mesh, Fill fill, v1::PhysicalParameters& parameters,
                             std::vector<std::string>& part_warnings) {
  const bool shell = (fill == Fill::Shell || fill == Fill::OpenShell) && !has_hollow(mesh);
  MassProperties properties = shell ? shell_mass_properties(mesh) : solid_mass_properties(mesh);
  part_warnings = weigh_parts(mesh, shell, parameters, properties);
  return properties;
}

// Bounds of the material in the rest state, object frame, metres.
Eigen::AlignedBox3d material_bounds(const ParticleSet& particles, const TriangleMesh& mesh, bool points) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& vertex : points ? particles.positions_m : mesh.vertices_m)
    bounds.extend(vertex);
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(points ? 0.5 * particles.spacing_m : 0.0);
  return {bounds.min() - half, bounds.max() + half};
}

// Refuses a region that does not overlap the object, because it would have no effect.
Result<void> check_reach(const BodyRegion& region, const Eigen::AlignedBox3d& material,
                         const std::string& field) {
  const double slack = 1e-6 * material.sizes().maxCoeff();
  // A traction or a material needs an overlap with a volume. A plane is enough to fix or move the points on
  // it.
  const bool plane_will_do = !region.material && region.traction_pa.isZero(0.0);
  const Eigen::Array3d overlap =
      region.max_m.cwiseMin(material.max()).array() - region.min_m.cwiseMax(material.min()).array();
  if (region.boundary || (overlap >= (plane_will_do ? -slack : slack)).all()) return {};
  char message[200];
  std::snprintf(
      message, sizeof message,
      ": does not overlap the object, which extends from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g) m at rest",
      material.min().x(), material.min().y(), material.min().z(), material.max().x(), material.max().y(),
      material.max().z());
  return invalid_argument((region.name.empty() ? "" : "region \"" + region.name + "\": ") + field + ".box" +
                          message);
}

Result<ElasticBodyDescription> elastic_description(const v1::Object& object, Form& form,
                                                   const std::string& field) {
  ElasticBodyDescription body;
  const bool points = object.form_case() == v1::Object::kPoints;
  body.particles = points ? std::move(form.particles)
                          : sample_particles(form.mesh, kDefaultSamplingDensity, object.spacing_m());
  body.particle_velocities_m_s = std::move(form.particle_velocities_m_s);
  body.initial_deformation =
      matrix_value(object.initial_deformation(), field + ".initial_deformation").value();
  const v1::Resolution& resolution = object.resolution();
  if (resolution.has_cell_width_m()) {
    body.cell_width_m = resolution.cell_width_m();
    const double edge_m = resolution_request(body, 1.0, 1).particle_edge_m;
    if (body.cell_width_m < 0.5 * edge_m * (1.0 - 1e-9)) {
      char message[160];
      std::snprintf(message, sizeof message,
                    ".resolution.cell_width_m: %.4g m is less than half of the particles' %.4g m; give at "
                    "least %.4g, or "
                    "a smaller spacing_m",
                    body.cell_width_m, edge_m, 0.5 * edge_m);
      return invalid_argument(field + message);
    }
  }
  body.substeps = static_cast<int>(resolution.substeps());
  if (resolution.has_budget_ms()) {
    body.max_node_substeps = resolution.budget_ms() / kNodeSubstep_ms;
    body.own_budget = true;
  }
  const Eigen::AlignedBox3d material = material_bounds(body.particles, form.mesh, points);
  for (int i = 0; i < object.regions_size(); ++i) {
    const std::string name = field + ".regions[" + std::to_string(i) + "]";
    body.regions.push_back(region_value(object.regions(i), name).value());  // checked when the file was read
    if (auto reached = check_reach(body.regions.back(), material, name); !reached) return reached.error();
  }
  return body;
}

// Returns why the `spacing_m` of the scene file is probably a mistake, or an empty string. A spacing is
// doubtful if fewer than kMinCellsAlong particles span the longest side, or if the particles of a list fill
// more than kMaxVolumeRatio times the volume of the body.
std::string doubtful_spacing(const v1::Object& object, const ParticleSet& particles, const TriangleMesh& mesh,
                             double longest_side_m) {
  constexpr double kMinCellsAlong = 4.0, kMaxVolumeRatio = 2.0;
  if (!object.has_spacing_m()) return "";
  char text[200] = "";
  if (object.form_case() == v1::Object::kPoints) {
    const double fitting_m = filling_spacing_m(particles.positions_m, mesh);
    const double ratio = std::pow(object.spacing_m() / fitting_m, 3);
    if (fitting_m > 0.0 && ratio > kMaxVolumeRatio) {
      std::snprintf(
          text, sizeof text,
          "spacing_m: %.4g m makes the points fill %.3g times the volume of the body; omit it, or give "
          "about %.4g",
          object.spacing_m(), ratio, fitting_m);
    }
    return text;
  }
  const double most_m = longest_side_m / kMinCellsAlong;
  if (object.spacing_m() > most_m * (1.0 + 1e-9)) {
    std::snprintf(text, sizeof text,
                  "spacing_m: %.4g m is more than a quarter of the longest side, which leaves only %zu "
                  "particles; omit it, or give at most %.4g",
                  object.spacing_m(), particles.positions_m.size(), most_m);
  }
  return text;
}

// Returns the first field that is valid only for elastic objects, or an empty string.
std::string needs_elastic(const v1::Object& object, const Form& form) {
  if (object.regions_size() > 0) return "regions";
  if (!object.initial_deformation().empty()) return "initial_deformation";
  if (object.has_resolution()) return "resolution";
  if (!form.particle_velocities_m_s.empty()) return "points";
  return "";
}

}  // namespace

Result<BuiltObject> build_object(const v1::Object& object, const std::filesystem::path& folder, int index,
                                 const std::string& field, const WorldSettings& settings,
                                 const ObjectSidecar& sidecar, BuildCache* cache) {
  const int64_t started_ns = now_ns();
  BuildCache own_cache;
  if (!cache) cache = &own_cache;
  const auto fail = [&](const Error& error) {
    return Error{error.code, error.message.starts_with(field) ? error.message : field + ": " + error.message};
  };
  const std::string name = object_name(object, index);
  const bool shape = object.form_case() == v1::Object::kShape;
  // The analysis reads the kind and the material of an object from one phrase: "oak stool".
  const std::string identity = (object.material().empty() ? "" : object.material() + " ") +
                               (object.label().empty() ? name : object.label());
  auto form = cached_form(object, folder, index, identity, field, *cache);
  if (!form) return fail(form.error());
  double lowest_m = INFINITY;  // of the capture
  for (const Eigen::Vector3d& point : form->points_m) lowest_m = std::min(lowest_m, point.y());
  std::optional<StandingBase> base;
  if (object.standing()) {
    base = stand(form->mesh, solid_mass_properties(form->mesh).centre_of_mass_m);
    for (Eigen::Vector3d& point : form->points_m) {
      if (base) point.y() = std::max(point.y(), base->plane_m);
    }
  }
  // Shapes of equal measures have equal meshes, unless a base is cut off.
  const std::string shape_key = shape && !base ? object.shape().SerializeAsString() : "";
  ObjectFacts facts = facts_of(*form, identity, object.form_case() == v1::Object::kAsset, shape_key, *cache);
  const std::filesystem::path& kept_in = sidecar.path;
  v1::PhysicsFile kept;
  if (sidecar.replacement) {
    kept = *sidecar.replacement;
  } else if (!kept_in.empty()) {
    auto file = read_physics_file(kept_in);
    if (!file) return fail(file.error());
    kept = std::move(*file);
  }
  if (!kept.name().empty() && object.label().empty() && object.material().empty()) facts.name = kept.name();
  const v1::PhysicalParameters offline = estimate_offline(facts);
  std::string kept_note;
  auto before = with_physics_file(offline, kept, facts, kept_note);
  if (!before) {
    return fail({before.error().code, kept_in.string() + ": edits." + before.error().message +
                                          "; correct it, or delete the file"});
  }
  const v1::PhysicalParameters estimated = std::move(*before);
  auto parameters = merge_scene_physics(estimated, object.physics(), facts);
  if (!parameters) return Error{parameters.error().code, field + ".physics." + parameters.error().message};
  v1::EstimatedValue& side = *parameters->mutable_longest_side_m();
  side.set_best(facts.mesh.size_m.maxCoeff());
  side.set_low(side.best() * (form->scale_known ? 1.0 : 0.5));
  side.set_high(side.best() * (form->scale_known ? 1.0 : 2.0));
  side.set_source(form->scale_known ? v1::EstimatedValue::SCENE : v1::EstimatedValue::OFFLINE);
  side.set_reason(form->scale_reason);

  BuiltObject built;
  for (const std::string& doubt : implausible_physics(estimated, object.physics(), *parameters, facts)) {
    built.drawn.warnings.push_back("physics." + doubt);
  }
  if (!form->surface_note.empty()) built.drawn.warnings.push_back(form->surface_note);
  if (!kept_note.empty()) built.drawn.warnings.push_back(kept_note);
  if (const std::string unheard = overridden_edits(kept.edits(), object.physics()); !unheard.empty()) {
    built.drawn.warnings.push_back(kept_in.string() + ": " + unheard);
  }
  Material material = to_material(*parameters);
  const std::string elastic_only = needs_elastic(object, *form);
  if (material.behavior != Behavior::Elastic && !elastic_only.empty()) {
    return invalid_argument(
        field + "." + elastic_only + ": " + (elastic_only == "points" ? "have velocities, which are" : "is") +
        " only for elastic objects, and this object is " +
        v1::Physics::Behavior_Name(parameters->behavior()) + "; set physics.behavior to ELASTIC");
  }
  std::vector<std::string> part_warnings;  // of the body that is chosen
  std::optional<ElasticBodyDescription> elastic;
  if (material.behavior == Behavior::Elastic) {
    auto described = elastic_description(object, *form, field);
    if (!described) return described.error();
    elastic = std::move(*described);
    if (const std::string doubt =
            doubtful_spacing(object, elastic->particles, form->mesh, facts.mesh.size_m.maxCoeff());
        !doubt.empty()) {
      built.drawn.warnings.push_back(doubt);
    }
    elastic->material = material;
    part_warnings = add_part_regions(*parameters, *elastic);
    // Replaces an elastic body by a rigid one only if ELASTIC was not set by the user and is not required.
    if (object.physics().behavior() == v1::Physics::AUTO && kept.edits().behavior() == v1::Physics::AUTO &&
        elastic_only.empty()) {
      if (const auto reason = too_stiff_for_lattice(*elastic, settings.rate_hz, settings.substeps)) {
        elastic.reset();
        material.behavior = Behavior::Rigid;
        parameters->set_behavior(v1::Physics::RIGID);
        parameters->set_behavior_reason(*reason);
        built.drawn.warnings.push_back(*reason);
      }
    }
  }
  if (const auto why = fracture_warning(*parameters); why && object.physics().fragile()) {
    built.drawn.warnings.push_back("physics." + *why);
  }
  switch (material.behavior) {
    case Behavior::Elastic: {
      elastic->material = material;
      built.drawn.rest_particles_m = elastic->particles.positions_m;
      prepare_body(*elastic);
      built.body = std::move(*elastic);
      break;
    }
    case Behavior::Static: {
      built.body =
          StaticBodyDescription{{}, mesh_collider(form->mesh), material.friction, material.restitution};
      break;
    }
    default: {
      RigidBodyDescription body;
      auto mesh = rigid_mesh(*form, shape || material.fragile);
      if (!mesh) return fail(mesh.error());
      body.mesh = std::move(*mesh);
      if (base && !material.fragile) {
        // The collision mesh is another surface, and the material may be a shell.
        const StandingBase fine = *base;
        const Eigen::Vector3d centre =
            properties_of(body.mesh, material.fill, *parameters, part_warnings).centre_of_mass_m;
        if (const auto own = stand(body.mesh, centre)) base = own;
        base->widened = std::max(base->widened, fine.widened);
        base->margin = std::min(base->margin, fine.margin);
      }
      built.cut_mesh = std::make_shared<const TriangleMesh>(body.mesh);
      built.fine_mesh =
          shape || material.fragile ? built.cut_mesh : std::make_shared<const TriangleMesh>(form->mesh);
      // A captured closed surface shows only the outside of a hollow object; the inner wall is generated.
      if (material.fragile && material.fill == Fill::Shell && !has_hollow(body.mesh)) {
        if (auto hollow = hollow_mesh(body.mesh, material.wall_thickness_m)) {
          built.cut_mesh = built.fine_mesh = std::make_shared<const TriangleMesh>(std::move(*hollow));
        } else {
          built.drawn.warnings.push_back("physics.fill: the object breaks as a solid: " +
                                         hollow.error().message);
        }
      }
      body.properties = properties_of(*built.cut_mesh, material.fill, *parameters, part_warnings);
      // A ball turns about its middle; a sphere of several parts does not, and takes its mesh.
      if (shape && object.shape().has_sphere() && !PartPlaces(parameters->parts()).divided())
        body.sphere_radius_m = object.shape().sphere().radius_m();
      if (shape && !material.fragile) body.round = round_shape(object.shape());
      body.material = material;
      body.friction_boxes = part_friction(*parameters);
      if (shape_key.empty()) {
        prepare_body(body);
      } else {
        // The contact shape lies about the centre of mass, which depends on the walls of a hollow shape.
        const Eigen::Vector3d& centre = body.properties.centre_of_mass_m;
        char around[100];
        std::snprintf(around, sizeof around, "contact %a %a %a ", centre.x(), centre.y(), centre.z());
        const std::string key = around + shape_key;
        body.shape = *cache->value<std::shared_ptr<const RigidShape>>(
            key,
            [&] {
              prepare_body(body);
              return body.shape;
            },
            [](const auto&) { return kContactShapeBytes; });
      }
      built.body = std::move(body);
    }
  }
  for (std::string& warning : part_warnings) built.drawn.warnings.push_back(std::move(warning));
  if (base && base->margin < kStandingMargin) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "base: does not carry the object as captured; it is moved under the centre of mass and "
                  "widened %.2g times",
                  base->widened);
    built.drawn.warnings.push_back(text);
  }
  built.standing = object.standing() && material.behavior != Behavior::Static;
  built.drawn.name = name;
  built.drawn.label = object.label();
  built.drawn.asset = std::move(form->asset);
  built.drawn.physics = std::move(*parameters);
  built.drawn.built_parts = built.drawn.physics.parts();
  built.drawn.written = object.physics();
  built.drawn.physics_file = kept_in;
  if (kept.ByteSizeLong() > 0) built.drawn.sidecar = std::make_shared<const v1::PhysicsFile>(kept);
  built.drawn.mass_kg = material.behavior == Behavior::Static ? 0.0 : material.mass_kg;
  built.drawn.surface_note = std::move(form->surface_note);
  built.drawn.facts = std::make_shared<const ObjectFacts>(std::move(facts));
  built.object_from_asset = form->object_from_asset;
  built.body_points_m = shape ? std::move(form->mesh.vertices_m) : std::move(form->points_m);
  if (base) built.drawn.lift_m = lowest_m - base->plane_m;
  place_built(built, object);
  built.build_ms = milliseconds_from_ns(now_ns() - started_ns);
  return built;
}

Pose body_pose(const v1::Object& object, double lift_m) {
  Pose pose = pose_value(object.pose(), "pose").value();  // checked when the file was read
  pose.position_m += pose.orientation * Eigen::Vector3d(0.0, lift_m, 0.0);
  return pose;
}

void place_built(BuiltObject& built, const v1::Object& object) {
  built.drawn.hidden = object.hidden();
  const Pose pose = body_pose(object, built.drawn.lift_m);
  const auto move = [&](auto& body) {
    body.world_from_object = pose;
    if constexpr (!std::is_same_v<decltype(body), StaticBodyDescription&>) {
      body.velocity_m_s = vector_value(object.velocity_m_s(), Eigen::Vector3d::Zero(), "").value();
      body.angular_velocity_rad_s =
          vector_value(object.angular_velocity_rad_s(), Eigen::Vector3d::Zero(), "").value();
    }
  };
  std::visit(move, built.body);
}

}  // namespace livegs
