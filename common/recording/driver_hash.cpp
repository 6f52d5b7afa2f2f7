// SPDX-License-Identifier: Apache-2.0
#include "recording/driver_hash.h"

#include <bit>
#include <utility>

#include "wire/word_hash.h"

namespace livegs {
namespace {

uint64_t word(double value) { return std::bit_cast<uint64_t>(value); }
uint64_t word(float value) { return std::bit_cast<uint32_t>(value); }

}  // namespace

uint32_t driver_hash(const ObjectDrivers& drivers) {
  WordHash hash;
  hash.add(uint64_t{drivers.object_id} << 32 | uint64_t{drivers.revision} << 16 |
           static_cast<uint64_t>(drivers.kind) << 8 | (drivers.asleep ? 1u : 0u));
  hash.add(drivers.poses.size());
  hash.add(drivers.positions_m.size());
  hash.add(drivers.rotations.size());
  for (const Pose& pose : drivers.poses) {
    for (int k = 0; k < 3; ++k) hash.add(word(pose.position_m[k]));
    for (int k = 0; k < 4; ++k) hash.add(word(pose.orientation.coeffs()[k]));
  }
  for (const Eigen::Vector3f& position : drivers.positions_m) {
    for (int k = 0; k < 3; ++k) hash.add(word(position[k]));
  }
  for (const Eigen::Quaternionf& rotation : drivers.rotations) {
    for (int k = 0; k < 4; ++k) hash.add(word(rotation.coeffs()[k]));
  }
  return hash.value();
}

std::vector<ObjectHash> DriverHashes::take(const DriverFrame& frame) {
  std::map<uint32_t, uint32_t> now;
  for (const ObjectDrivers& object : frame.objects) now[object.object_id] = driver_hash(object);
  std::vector<ObjectHash> changed;
  for (const auto& [id, hash] : now) {
    const auto known = hashes_.find(id);
    if (known == hashes_.end() || known->second != hash) changed.push_back({id, hash});
  }
  hashes_ = std::move(now);
  return changed;
}

}  // namespace livegs
