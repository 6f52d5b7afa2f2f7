// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/describe_object.h"

#include "scene/elastic_report.h"
#include "wire/rest_body_codec.h"

namespace livegs {
namespace {

size_t driver_count(const RestBody& rest) {
  switch (rest.kind) {
    case DriverKind::Rigid:
      return rest.bodies.size();
    case DriverKind::Lattice:
      return rest.node_coordinates.size();
    case DriverKind::Particles:
      return rest.particles_m.size();
  }
  return 0;
}

}  // namespace

v1::ObjectDescription describe_object(const SceneObject& object, const AssetBytes& asset) {
  v1::ObjectDescription description;
  description.set_object_id(object.id);
  description.set_name(object.name);
  description.set_asset_hash(asset.hash);
  description.set_asset_bytes(asset.bytes.size());
  const std::vector<std::byte> rest = encode_rest_body(object.rest);
  description.set_rest_body(rest.data(), rest.size());
  description.set_environment(object.environment);
  *description.mutable_physics() = object.physics;
  description.set_mass_kg(object.mass_kg);
  description.set_kernel_count(static_cast<uint32_t>(object.asset->size()));
  description.set_driver_count(static_cast<uint32_t>(driver_count(object.rest)));
  if (object.elastic) *description.mutable_elastic() = accuracy_message(*object.elastic);
  for (const std::string& warning : object.all_warnings()) description.add_warnings(warning);
  return description;
}

}  // namespace livegs
