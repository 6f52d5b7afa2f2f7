// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "skin/skin_kernels.h"

namespace livegs {
namespace {

const char* name_of(DriverKind kind) {
  switch (kind) {
    case DriverKind::Rigid:
      return "rigid";
    case DriverKind::Lattice:
      return "lattice";
    case DriverKind::Particles:
      return "particles";
  }
  return "unknown";
}

Result<void> check_count(uint32_t object_id, const char* what, size_t have, size_t want) {
  if (have == want) return {};
  return invalid_data("drivers of object " + std::to_string(object_id) + ": " + std::to_string(have) + " " +
                      what + " instead of " + std::to_string(want) + "; bind the object again");
}

template <class Values, class IsFinite>
Result<void> check_finite(uint32_t object_id, const char* what, const Values& values, IsFinite is_finite) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!is_finite(values[i])) {
      return invalid_data("drivers of object " + std::to_string(object_id) + ": " + what + " " +
                          std::to_string(i) + " is not finite");
    }
  }
  return {};
}

}  // namespace

Result<void> check_drivers(const RestBody& rest, const ObjectDrivers& drivers) {
  if (rest.kind != drivers.kind) {
    return invalid_data("drivers of object " + std::to_string(drivers.object_id) + ": are " +
                        name_of(drivers.kind) + ", but its rest body is " + name_of(rest.kind) +
                        "; bind the object again");
  }
  if (rest.revision != drivers.revision) {
    return invalid_data("drivers of object " + std::to_string(drivers.object_id) + ": have revision " +
                        std::to_string(drivers.revision) + ", but its rest body has " +
                        std::to_string(rest.revision) + "; bind the object again");
  }
  const bool rigid = rest.kind == DriverKind::Rigid, particles = rest.kind == DriverKind::Particles;
  const size_t positions = rigid ? 0 : particles ? rest.particles_m.size() : rest.node_coordinates.size();
  const uint32_t id = drivers.object_id;
  Result<void> checked = check_count(id, "poses", drivers.poses.size(), rigid ? rest.bodies.size() : 0);
  if (checked) checked = check_count(id, "positions", drivers.positions_m.size(), positions);
  if (checked) checked = check_count(id, "rotations", drivers.rotations.size(), particles ? positions : 0);
  if (checked) {
    checked = check_finite(id, "pose", drivers.poses, [](const Pose& pose) {
      return pose.position_m.allFinite() && pose.orientation.coeffs().allFinite();
    });
  }
  if (checked) {
    checked = check_finite(id, "position", drivers.positions_m,
                           [](const Eigen::Vector3f& position) { return position.allFinite(); });
  }
  if (checked) {
    checked = check_finite(id, "rotation", drivers.rotations,
                           [](const Eigen::Quaternionf& rotation) { return rotation.coeffs().allFinite(); });
  }
  return checked;
}

}  // namespace livegs
