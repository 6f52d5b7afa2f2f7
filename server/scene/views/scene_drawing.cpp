// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/views/scene_drawing.h"

#include "core/assert.h"
#include "core/math/nearest_rotation.h"
#include "splat/frame_bounds.h"

namespace livegs {
namespace {

// Builds the drivers of an elastic body as streamed by the LIVE-GS paper: one per particle, with the rotation
// of its deformation.
RestBody particle_rest(const SceneObject& object) {
  RestBody rest;
  rest.kind = DriverKind::Particles;
  rest.object_from_asset = object.rest.object_from_asset;
  for (const Eigen::Vector3d& particle : object.rest_particles_m)
    rest.particles_m.push_back(particle.cast<float>());
  return rest;
}

ObjectDrivers particle_drivers(uint32_t object_id, const std::vector<ParticleState>& now) {
  ObjectDrivers drivers;
  drivers.object_id = object_id;
  drivers.kind = DriverKind::Particles;
  for (const ParticleState& particle : now) {
    drivers.positions_m.push_back(particle.position_m.cast<float>());
    drivers.rotations.push_back(
        Eigen::Quaterniond(nearest_rotation(particle.deformation_gradient)).normalized().cast<float>());
  }
  return drivers;
}

}  // namespace

Result<std::vector<DrawnObject>> SceneDrawing::pose(const Scene& scene, const DriverFrame* frame) {
  DriverFrame own;
  if (!frame) own = scene.world().drivers();
  const DriverFrame& drivers = frame ? *frame : own;
  const auto& rgb = scene.file().background_rgb();
  background_ = rgb.size() == 3 ? Eigen::Vector3f(Eigen::Vector3d(rgb[0], rgb[1], rgb[2]).cast<float>())
                                : kPictureBackground;
  environments_.clear();
  boxes_.clear();
  std::vector<DrawnObject> drawn;
  std::vector<uint32_t> casting;
  PosedKernels shape;
  for (const ObjectDrivers& object : drivers.objects) {
    const SceneObject* of = scene.find(object.object_id);
    if (!of)
      return not_found("object " + std::to_string(object.object_id) +
                       ": is in the frame but not in the scene");
    const ElasticBody* elastic = scene.world().elastic_body(object.object_id);
    const bool as_particles =
        skinning_ == Skinning::LivegsV1 && elastic && object.kind == DriverKind::Lattice && !frame;
    std::vector<ParticleState> particles;
    if (as_particles) particles = elastic->particles();

    auto [at, fresh] = bound_.try_emplace(object.object_id);
    Bound& bound = at->second;
    if (fresh || bound.rest.revision != of->rest.revision) {
      bound.rest = as_particles ? particle_rest(*of) : of->rest;
      auto bindings = bind_kernels(*of->asset, bound.rest);
      if (!bindings) return Error{bindings.error().code, of->name + ": " + bindings.error().message};
      bound.bindings = std::move(*bindings);
      bound.shape = of->environment ? ShapeSample() : ShapeSample(*of->asset, bound.bindings);
    }
    const ObjectDrivers converted =
        as_particles ? particle_drivers(object.object_id, particles) : ObjectDrivers{};
    const ObjectDrivers& used = as_particles ? converted : object;
    if (auto checked = check_drivers(bound.rest, used); !checked) {
      return Error{checked.error().code, of->name + ": " + checked.error().message};
    }
    skin_kernels(*of->asset, bound.rest, bound.bindings, used, bound.kernels,
                 keep_gradients_ ? &bound.gradients : nullptr);
    drawn.push_back({of->asset.get(), &bound.kernels, object.object_id});
    if (of->environment) {
      environments_.push_back(object.object_id);
    } else {
      boxes_.push_back(robust_bounds(bound.kernels.positions_m));
    }
    if (!draws_shadows_ || bound.shape.size() == 0) continue;
    bound.shape.pose(bound.rest, used, shape);
    shadows_.set(object.object_id,
                 {shape.positions_m, shape.covariances_m2, bound.shape.weights(), bound.shape.bodies()});
    casting.push_back(object.object_id);
  }
  shadows_.keep(casting);
  shadow_table_ = draws_shadows_ ? &shadows_.table() : nullptr;
  return drawn;
}

const std::vector<Eigen::Matrix3f>& SceneDrawing::deformation_gradients(uint32_t object_id) const {
  LIVEGS_ASSERT(keep_gradients_);
  return bound_.at(object_id).gradients;
}

const PosedKernels& SceneDrawing::kernels(uint32_t object_id) const { return bound_.at(object_id).kernels; }

}  // namespace livegs
