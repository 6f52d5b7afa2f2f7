// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/part_colours.h"

#include <utility>

#include "core/parallel_for.h"

namespace livegs {

std::shared_ptr<const GaussianAsset> in_part_colours(const GaussianAsset& asset,
                                                     const Similarity& object_from_asset,
                                                     const PartPlaces& places) {
  auto coloured = std::make_shared<GaussianAsset>();
  coloured->positions = asset.positions;
  coloured->log_scales = asset.log_scales;
  coloured->rotations = asset.rotations;
  coloured->opacity_logits = asset.opacity_logits;
  coloured->antialiased = asset.antialiased;
  coloured->sh_dc.resize(asset.size());
  parallel_for(asset.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Eigen::Vector3f own = (0.5f + kShBand0 * asset.sh_dc[i].array()).max(0.0f).min(1.0f).matrix();
      const size_t part = places.at(object_from_asset * asset.positions[i].cast<double>());
      coloured->sh_dc[i] = ((shaded_part_rgb(part, own).array() - 0.5f) / kShBand0).matrix();
    }
  });
  return coloured;
}

void PartColours::show(const StreamedObject* object, SceneView& view) {
  std::optional<PartPlaces> places;
  if (object) places.emplace(object->physics.parts());
  if (places && !places->divided()) places.reset();
  if (shown_) {
    const bool drawn = view.asset(shown_->object_id) == shown_->coloured;
    if (drawn && places && object->id == shown_->object_id && *places == shown_->places) return;
    if (drawn) view.recolour(shown_->object_id, shown_->own);
    shown_.reset();
  }
  if (!places) return;
  auto own = view.asset(object->id);
  if (!own) return;
  auto coloured = in_part_colours(*own, object->rest.object_from_asset, *places);
  view.recolour(object->id, coloured);
  shown_ = Shown{object->id, *std::move(places), std::move(own), std::move(coloured)};
}

}  // namespace livegs
