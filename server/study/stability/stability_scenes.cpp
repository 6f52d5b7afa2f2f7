// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stability/stability_scenes.h"

namespace livegs::study {

std::span<const StabilityScene> stability_scenes() {
  static const std::vector<StabilityScene> scenes = {
      {"soft_landing", "seven soft bodies fall tilted from 0.3 m", true, false, soft_landing},
      {"limp_spin", "sheets of 2 mm spin at 30 rad/s", true, false, limp_spin},
      {"soft_collision", "a soft cube hits another", true, false, soft_collision},
      {"couple", "couples on boxes of 1 to 6 cells", true, false, couple},
      {"soft_flight", "a soft box spins freely", true, false, soft_flight},
      {"soft_rolling", "balls and a cylinder roll down slopes", true, false, soft_rolling},
      {"resting_block", "a soft cube settles under its weight", true, false, resting_block},
      {"held_bar", "a held bar under a small load", true, false, held_bar},
      {"loaded_pillow", "heavy boxes on very soft pillows", true, true, loaded_pillow},
      {"soft_heap", "twelve soft boxes fall into a bin", true, false, soft_heap},
      {"thin_shelf", "a soft block falls on a shelf of 4 mm", true, false, thin_shelf},
      {"overstretched_strip", "100 N pull at a strip of 3 mm", true, false, overstretched_strip},
      {"scrambled_block", "blocks start scrambled", true, false, scrambled_block},
      {"impaled_block", "blocks start scrambled around a bar", true, true, impaled_block},
      {"jerked_plant", "a plant with thin leaves is jerked", true, false, jerked_plant},
      {"haze", "a soft ball in nearly weightless particles falls", true, false, haze},
      {"fast_plate", "fast cards, rods and balls hit a plate of 5 mm", false, true, fast_plate},
      {"coincident_bodies", "two rigid bodies at the same place", false, true, coincident_bodies},
      {"fragment_heap", "a cup breaks into 64", false, true, fragment_heap},
      {"snapping_chain", "a chain with a heavy end snaps tight", false, true, snapping_chain},
      {"heavy_on_light_box", "a cube on one of a thousandth of its mass", false, true, heavy_on_light_box},
      {"pile_of_books", "30 kg on five light books", false, true, pile_of_books},
  };
  return scenes;
}

}  // namespace livegs::study
