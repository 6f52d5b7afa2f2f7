// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "gaussian/gaussian_asset.h"
#include "material/part_places.h"
#include "render/scene_view.h"
#include "stream/received/received.h"

namespace livegs {

// A copy of an asset, each kernel in the colour of the part at its rest position, shaded by its own
// brightness and without view dependence. Precondition: places.divided().
std::shared_ptr<const GaussianAsset> in_part_colours(const GaussianAsset& asset,
                                                     const Similarity& object_from_asset,
                                                     const PartPlaces& places);

// Draws one object of a view in the colours of its parts. Renderer thread.
class PartColours {
 public:
  // Recolours this object, and the one before in its own colours again. Null, or not divided: none. Call once
  // a picture: an object that was refined or whose parts changed is recoloured again, and without a change
  // the view stays as it is. The copy takes a pass over the kernels.
  void show(const StreamedObject* object, SceneView& view);

 private:
  struct Shown {
    uint32_t object_id;
    PartPlaces places;
    std::shared_ptr<const GaussianAsset> own, coloured;
  };
  std::optional<Shown> shown_;
};

}  // namespace livegs
