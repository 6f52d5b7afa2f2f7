// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/sample_scene.h"

#include <iterator>

#include "core/parallel_for.h"

namespace livegs {

std::vector<SampleAsset> make_sample_assets(uint64_t seed) {
  constexpr struct {
    const char* name;
    GaussianAsset (*make)(uint64_t);
  } kMakers[] = {{"cup", make_cup},         {"pillow", make_pillow},
                 {"hat", make_felt_hat},    {"plant", make_potted_plant},
                 {"duck", make_toy_duck},   {"stool", make_wooden_stool},
                 {"room", make_room_corner}};
  std::vector<SampleAsset> assets(std::size(kMakers));
  parallel_for(assets.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) assets[i] = {kMakers[i].name, kMakers[i].make(seed)};
  });
  return assets;
}

}  // namespace livegs
