// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/simulation_record.h"

#include <cerrno>
#include <cstring>

namespace livegs {
namespace {

// A name in a CSV cell: quoted only when it must be (RFC 4180).
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char letter : text) {
    if (letter == '"') quoted += '"';
    quoted += letter;
  }
  return quoted + "\"";
}

void put(std::FILE* file, const Eigen::Vector3d& v) {
  std::fprintf(file, ",%.12g,%.12g,%.12g", v.x(), v.y(), v.z());
}

template <class Matrix>
void put_rows(std::FILE* file, const Matrix& matrix, int digits) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      std::fprintf(file, ",%.*g", digits, static_cast<double>(matrix(row, column)));
  }
}

const char* event_name(WorldEventKind kind) {
  switch (kind) {
    case WorldEventKind::Contact:
      return "contact";
    case WorldEventKind::Sleep:
      return "sleep";
    case WorldEventKind::Wake:
      return "wake";
  }
  return "";
}

}  // namespace

Result<SimulationRecord::File> SimulationRecord::create(const char* name, const char* header) {
  const auto path = folder_ / name;
  File file(std::fopen(path.c_str(), "w"));
  if (!file)
    return Error{ErrorCode::PermissionDenied, path.string() + ": cannot be written: " + std::strerror(errno)};
  std::setvbuf(file.get(), nullptr, _IOFBF, 1 << 20);
  std::fprintf(file.get(), "%s\n", header);
  return file;
}

Result<SimulationRecord> SimulationRecord::open(const std::filesystem::path& folder, const Options& options) {
  SimulationRecord record;
  record.folder_ = folder;
  const auto add = [&](File& file, const char* name, const char* header) -> Result<void> {
    auto made = record.create(name, header);
    if (!made) return made.error();
    file = std::move(*made);
    return {};
  };
  Result<void> done = add(record.bodies_, "bodies.csv",
                          "frame,time_s,object,body,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,mass_kg,asleep");
  if (done)
    done = add(record.energy_, "energy.csv", "frame,time_s,kinetic_j,elastic_j,gravity_j,px,py,pz,lx,ly,lz");
  if (done) done = add(record.events_, "events.csv", "frame,time_s,event,object,impulse_n_s,x,y,z");
  if (done && options.particles) {
    done = add(record.particles_, "particles.csv",
               "frame,time_s,object,particle_id,x,y,z,vx,vy,vz,mass_kg,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  }
  if (done && options.kernels) {
    done = add(
        record.kernels_, "kernels.csv",
        "frame,time_s,object,kernel_id,x,y,z,sxx,sxy,sxz,syy,syz,szz,F00,F01,F02,F10,F11,F12,F20,F21,F22");
  }
  if (!done) return done.error();
  return record;
}

void SimulationRecord::write(Scene& scene, const SceneDrawing& drawing) {
  World& world = scene.world();
  const uint64_t frame = world.tick();
  const double time_s = static_cast<double>(frame) / world.settings().rate_hz;
  const auto begin_row = [&](std::FILE* file, const SceneObject& object) {
    std::fprintf(file, "%lu,%.12g,%s", frame, time_s, cell(object.name).c_str());
  };
  for (const BodyState& body : world.bodies()) {
    const SceneObject& object = *scene.find(body.object_id);
    if (object.environment) continue;
    std::FILE* file = bodies_.get();
    begin_row(file, object);
    std::fprintf(file, ",%u", body.body_index);
    put(file, body.world_from_body.position_m);
    const Eigen::Quaterniond& q = body.world_from_body.orientation;
    std::fprintf(file, ",%.12g,%.12g,%.12g,%.12g", q.w(), q.x(), q.y(), q.z());
    put(file, body.velocity_m_s);
    put(file, body.angular_velocity_rad_s);
    std::fprintf(file, ",%.12g,%d\n", body.mass_kg, body.asleep ? 1 : 0);
  }
  for (const SceneObject& object : scene.objects()) {
    if (const ElasticBody* elastic = world.elastic_body(object.id); elastic && particles_) {
      std::FILE* file = particles_.get();
      size_t particle_id = 0;
      for (const ParticleState& particle : elastic->particles()) {
        begin_row(file, object);
        std::fprintf(file, ",%zu", particle_id++);
        put(file, particle.position_m);
        put(file, particle.velocity_m_s);
        std::fprintf(file, ",%.12g", particle.mass_kg);
        put_rows(file, particle.deformation_gradient, 12);
        std::fputc('\n', file);
      }
    }
    if (kernels_ && !object.environment) {
      std::FILE* file = kernels_.get();
      const PosedKernels& kernels = drawing.kernels(object.id);
      const auto& gradients = drawing.deformation_gradients(object.id);
      for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
        begin_row(file, object);
        const Eigen::Vector3f& p = kernels.positions_m[i];
        std::fprintf(file, ",%zu,%.9g,%.9g,%.9g", i, p.x(), p.y(), p.z());
        for (float entry : kernels.covariances_m2[i]) std::fprintf(file, ",%.9g", entry);
        put_rows(file, gradients[i], 9);
        std::fputc('\n', file);
      }
    }
  }
  const BodyEnergy energy = world.energy();
  std::fprintf(energy_.get(), "%lu,%.12g,%.12g,%.12g,%.12g", frame, time_s, energy.kinetic_j,
               energy.elastic_j, energy.gravity_j);
  put(energy_.get(), energy.linear_momentum);
  put(energy_.get(), energy.angular_momentum);
  std::fputc('\n', energy_.get());
  for (const WorldEvent& event : world.take_events()) {
    const SceneObject* object = scene.find(event.object_id);
    std::fprintf(events_.get(), "%lu,%.12g,%s,%s,%.12g", event.tick,
                 static_cast<double>(event.tick) / world.settings().rate_hz, event_name(event.kind),
                 object ? cell(object->name).c_str() : "", event.impulse_n_s);
    put(events_.get(), event.point_m);
    std::fputc('\n', events_.get());
  }
}

Result<void> SimulationRecord::close() {
  bool fine = true;
  for (File* file : {&bodies_, &particles_, &kernels_, &energy_, &events_}) {
    if (!*file) continue;
    std::FILE* raw = file->release();
    fine &= std::ferror(raw) == 0;
    fine &= std::fclose(raw) == 0;
  }
  if (!fine) return Error{ErrorCode::Internal, folder_.string() + ": writing failed; is the disk full?"};
  return {};
}

}  // namespace livegs
