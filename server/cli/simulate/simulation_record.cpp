// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/simulate/simulation_record.h"

#include "geometry/fracture/piece_kernels.h"
#include "scene/build/fragile_object.h"

namespace livegs {
namespace {

// Significant digits that reproduce a float exactly.
constexpr int kFloatDigits = 9;

const char* event_name(WorldEventKind kind) {
  switch (kind) {
    case WorldEventKind::Contact:
      return "contact";
    case WorldEventKind::Sleep:
      return "sleep";
    case WorldEventKind::Wake:
      return "wake";
    case WorldEventKind::Fracture:
      return "fracture";
  }
  return "";
}

// Returns the id of a kernel: its index in the object's original asset, also for its parts after a break.
// Kernels of cut faces are numbered after those.
size_t kernel_id(const SceneObject& object, size_t kernel) {
  if (object.rest.revision == 0) return kernel;
  const uint32_t source = object.broken->source[kernel];
  return source == kInteriorKernel ? object.broken->source.size() + kernel : source;
}

}  // namespace

Result<SimulationRecord> SimulationRecord::open(const std::filesystem::path& folder, const Options& options) {
  SimulationRecord record;
  record.folder_ = folder;
  Result<void> done;
  const auto add = [&](auto& file, const char* name, const char* header) {
    if (!done) return;
    auto made = CsvFile::create(folder / name, header);
    if (made)
      file = std::move(*made);
    else
      done = made.error();
  };
  add(record.bodies_, "bodies.csv",
      "frame,time_s,object,body,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,mass_kg,asleep");
  add(record.energy_, "energy.csv", "frame,time_s,kinetic_j,elastic_j,gravity_j,px,py,pz,lx,ly,lz");
  add(record.events_, "events.csv", "frame,time_s,event,object,impulse_n_s,x,y,z");
  if (options.particles) {
    add(record.particles_, "particles.csv",
        "frame,time_s,object,particle_id,x,y,z,vx,vy,vz,mass_kg,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  }
  if (options.kernels) {
    add(record.kernels_, "kernels.csv",
        "frame,time_s,object,kernel_id,x,y,z,sxx,sxy,sxz,syy,syz,szz,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  }
  if (!done) return done.error();
  return record;
}

void SimulationRecord::write(Scene& scene, const SceneDrawing& drawing) {
  World& world = scene.world();
  const uint64_t frame = world.tick();
  const double time_s = static_cast<double>(frame) / world.settings().rate_hz;
  for (const BodyState& body : world.bodies()) {
    const SceneObject& object = *scene.find(body.object_id);
    if (object.environment) continue;
    bodies_.integer(frame).number(time_s).text(object.name).integer(body.body_index);
    const Eigen::Quaterniond& q = body.world_from_body.orientation;
    bodies_.vector(body.world_from_body.position_m).number(q.w()).vector(q.vec());
    bodies_.vector(body.velocity_m_s).vector(body.angular_velocity_rad_s);
    bodies_.number(body.mass_kg).integer(body.asleep ? 1 : 0).end_row();
  }
  for (const SceneObject& object : scene.objects()) {
    if (const ElasticBody* elastic = world.elastic_body(object.id); elastic && particles_) {
      size_t particle_id = 0;
      for (const ParticleState& particle : elastic->particles()) {
        particles_->integer(frame).number(time_s).text(object.name).integer(particle_id++);
        particles_->vector(particle.position_m).vector(particle.velocity_m_s).number(particle.mass_kg);
        particles_->matrix(particle.deformation_gradient).end_row();
      }
    }
    if (kernels_ && !object.environment) {
      const PosedKernels& kernels = drawing.kernels(object.id);
      const auto& gradients = drawing.deformation_gradients(object.id);
      for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
        kernels_->integer(frame).number(time_s).text(object.name).integer(kernel_id(object, i));
        kernels_->vector(kernels.positions_m[i], kFloatDigits);
        for (const float entry : kernels.covariances_m2[i]) kernels_->number(entry, kFloatDigits);
        kernels_->matrix(gradients[i], kFloatDigits).end_row();
      }
    }
  }
  const BodyEnergy energy = world.energy();
  energy_.integer(frame)
      .number(time_s)
      .number(energy.kinetic_j)
      .number(energy.elastic_j)
      .number(energy.gravity_j);
  energy_.vector(energy.linear_momentum).vector(energy.angular_momentum).end_row();
  for (const WorldEvent& event : world.take_events()) {
    const SceneObject* object = scene.find(event.object_id);
    events_.integer(event.tick).number(static_cast<double>(event.tick) / world.settings().rate_hz);
    events_.text(event_name(event.kind)).text(object ? object->name : "").number(event.impulse_n_s);
    events_.vector(event.point_m).end_row();
  }
}

Result<void> SimulationRecord::close() {
  bool fine = bodies_.close();
  fine &= energy_.close();
  fine &= events_.close();
  if (particles_) fine &= particles_->close();
  if (kernels_) fine &= kernels_->close();
  if (!fine)
    return Error{ErrorCode::Internal, folder_.string() + ": writing failed; check the free disk space"};
  return {};
}

}  // namespace livegs
