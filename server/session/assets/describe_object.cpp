// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/assets/describe_object.h"

#include <numbers>

#include "scene/build/elastic_report.h"
#include "scene/build/fragile_object.h"
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

// See ObjectDescription.reach_m. Rigid bodies and particles may move any of their kernels, so their reach is
// the whole asset.
double reach_m(const RestBody& rest, const AssetBytes& asset) {
  const double own_m = rest.kind == DriverKind::Lattice ? std::numbers::sqrt3 * rest.cell_width_m
                                                        : rest.object_from_asset.scale * asset.diagonal;
  return own_m + 3 * rest.object_from_asset.scale * asset.deviation;
}

}  // namespace

v1::ObjectDescription describe_object(const SceneObject& object, AssetStore& assets) {
  const std::shared_ptr<const AssetBytes> asset = assets.add(object.asset);
  assets.note_described(object.name, object.asset);
  v1::ObjectDescription description;
  description.set_object_id(object.id);
  description.set_name(object.name);
  description.set_asset_hash(asset->hash);
  description.set_asset_bytes(asset->bytes.size());
  const std::vector<std::byte> rest = encode_rest_body(object.rest);
  description.set_rest_body(rest.data(), rest.size());
  description.set_environment(object.environment);
  description.set_hidden(object.hidden);
  description.set_label(object.label);
  description.set_lift_m(object.lift_m);
  *description.mutable_physics() = object.physics;
  description.set_mass_kg(object.mass_kg);
  description.set_reach_m(reach_m(object.rest, *asset));
  description.set_kernel_count(static_cast<uint32_t>(object.asset->size()));
  description.set_driver_count(static_cast<uint32_t>(driver_count(object.rest)));
  if (object.elastic) *description.mutable_elastic() = accuracy_message(*object.elastic);
  if (object.fragility) {
    v1::Fragility& fragility = *description.mutable_fragility();
    fragility.set_pieces(object.fragility->pieces);
    fragility.set_bodies(object.fragility->bodies);
    fragility.set_break_impulse_n_s(object.fragility->break_impulse_n_s);
    fragility.set_drop_height_m(object.fragility->drop_height_m);
  }
  if (object.broken && object.rest.revision == 0 && assets.has(object.broken->asset)) {
    const std::shared_ptr<const AssetBytes> broken = assets.add(object.broken->asset);
    description.set_broken_asset_hash(broken->hash);
    description.set_broken_asset_bytes(broken->bytes.size());
  }
  for (const std::string& warning : object.all_warnings()) description.add_warnings(warning);
  return description;
}

}  // namespace livegs
