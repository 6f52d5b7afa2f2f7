// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/sample_scene.h"

namespace livegs {

std::vector<SampleAsset> make_sample_assets(uint64_t seed) {
  std::vector<SampleAsset> assets;
  assets.push_back({"cup", make_cup(seed)});
  assets.push_back({"pillow", make_pillow(seed)});
  assets.push_back({"hat", make_felt_hat(seed)});
  assets.push_back({"plant", make_potted_plant(seed)});
  assets.push_back({"duck", make_toy_duck(seed)});
  assets.push_back({"stool", make_wooden_stool(seed)});
  assets.push_back({"room", make_room_corner(seed)});
  return assets;
}

}  // namespace livegs
