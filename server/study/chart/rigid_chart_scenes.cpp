// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/rigid_chart.h"
#include "study/harness/rigid_scenes.h"

namespace livegs::study {

std::span<const RigidChartScene> rigid_chart_scenes() {
  static const std::vector<RigidChartScene> scenes = {
      {.name = "incline",
       .title = "Slab on a slope",
       .what = "A slab of 0.2 x 0.05 x 0.2 m on an inclined plane with friction 0.1, 0.3, 0.5, 0.7 and 1; "
               "the worst of the five counts. Figures: difference between the sliding angle (found to "
               "0.003 degrees) and atan(mu); creep in 10 s one degree below; acceleration ten degrees "
               "above, compared with g (sin - mu cos).",
       .settings = "0.2 x 0.05 x 0.2 m, mu 0.1 to 1",
       .run = incline,
       .quantities = {"threshold", "creep", "acceleration"},
       .quick_substeps = {1, 2, 4, 8, 16}},
      {.name = "stopping",
       .title = "Stopping distance",
       .what = "The slab starts at 2 m/s along x and along the diagonal with friction 0.2, 0.4 and 0.7; "
               "the worst of the six counts. Figures: stopping distance compared with v^2 / (2 mu g), and "
               "speed after the stop.",
       .settings = "2 m/s, mu 0.2, 0.4, 0.7, along x and the diagonal",
       .run = stopping,
       .quantities = {"distance", "drift"}},
      {.name = "rolling_box",
       .title = "Pushed box under 25 balls",
       .what = "After half a second at rest, 150 N push a box of 10 kg, carrying 25 balls of 1 kg, over a "
               "floor of friction 0.4. Figures: speed after 1 s compared with the closed form, the worst "
               "of x, z and the diagonal, and the difference between the three. The push is 9 % above the "
               "friction of the floor, so one per cent of friction is eleven per cent of speed.",
       .settings = "10 kg, 150 N, 25 balls of 1 kg, mu 0.4 below and 0.8 above",
       .run = rolling_box,
       .quantities = {"speed", "isotropy"},
       .max_exact_substeps = 4},
      {.name = "tumbling",
       .title = "Dzhanibekov's tumbling",
       .what = "A free body with moments 1, 2, 3 kg m^2 rotates at 10 rad/s about the middle axis for 60 "
               "s. Figures: largest drift of energy and angular momentum, and time of the first flip "
               "compared with Runge-Kutta at 0.1 ms.",
       .settings = "moments 1, 2, 3 kg m^2, spin (0.01, 10, 0.01) rad/s, 60 s",
       .run = tumbling,
       .quantities = {"energy", "momentum", "flip_time"},
       .max_exact_substeps = 0},
      {.name = "box_stack",
       .title = "Stack of twenty",
       .what = "Twenty cubes of 1 m and 1 kg in a stack, friction 0.6, 30 s. Figures: sag of the top "
               "relative to the height, lean, and sleep time in a second run with sleep enabled.",
       .settings = "20 cubes of 1 m, mu 0.6, 30 s",
       .run = box_stack,
       .quantities = {"sag", "lean", "asleep_after"},
       .max_exact_substeps = 0,
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "heavy_on_light",
       .title = "Heavy on light",
       .what = "A cube of 1 m on another with a tenth, a hundredth or a thousandth of its mass, 10 s. "
               "Figure: penetration relative to the lower cube.",
       .settings = "two cubes of 1 m, mu 0.6, 10 s",
       .run = heavy_on_light,
       .quantities = {"sag"},
       .parameters = {10, 100, 1000},
       .parameter_text = "1:%g"},
      {.name = "dominoes",
       .title = "Dominoes",
       .what = "Twenty dominoes of 0.2 x 0.02 x 0.1 m, 50 mm apart; the first is released at a tilt of 10 "
               "degrees. Figure: speed of the wave between the sixth and the sixteenth compared with "
               "LiveGS at 256 substeps per frame. The peers may converge to other limits.",
       .settings = "20 of 0.2 x 0.02 x 0.1 m, 50 mm apart, mu 0.5",
       .run = dominoes,
       .quantities = {"wave_speed"},
       .max_exact_substeps = 0,
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "overlap",
       .title = "Overlap",
       .what = "Cubes of 1 m for 3 s. Figures: highest speed without falling, for ten cubes in a column "
               "without gravity, each overlapping the next by half; for ten in a pyramid on the floor, "
               "each overlapping up to six neighbours by half; and for two at the same place without "
               "gravity, at the upper edge if they do not separate.",
       .settings = "cubes of 1 m, mu 0.6, half or complete overlap",
       .run = overlap,
       .quantities = {"column_speed", "pyramid_speed", "coincident_speed"},
       .max_exact_substeps = 0},
      {.name = "ball_pendulum",
       .title = "Pendulum on a joint",
       .what = "A ball of 5 cm and 1 kg on an arm of 1 m swings on a ball joint for 10 s from 5 and from "
               "60 degrees. Figures: period compared with the physical pendulum, and energy lost or gained"
               " by the swing.",
       .settings = "ball of 5 cm, arm 1 m, 10 s",
       .run = ball_pendulum,
       .quantities = {"period", "energy_lost"},
       .parameters = {5, 60},
       .parameter_text = "%g degrees"},
      {.name = "loaded_chain",
       .title = "Chain with a heavy end",
       .what = "Twenty links of 0.1 m and 0.1 kg hang from the world on ball joints, with a load of 100, "
               "1000 or 50000 times the mass of a link, 10 s. Figure: extension in the last second. The "
               "bar of the heaviest load is only that the chain holds.",
       .settings = "20 links of 0.1 m and 0.1 kg, 10 s",
       .run = loaded_chain,
       .quantities = {"stretch"},
       .parameters = {100, 1000, 50000},
       .parameter_text = "1:%g",
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "break_height",
       .title = "Breaking height",
       .what = "A box of 0.08 x 0.1 x 0.08 m and 0.25 kg, which breaks at the impulse that stops 3 m/s, "
               "falls flat or on a corner without friction. Figure: of a hundred drops from 0.5 to 1.5 "
               "times 3^2 / 2g, the largest distance of a wrong result (a break below or none above). "
               "Bullet does not break bodies; there, all contacts of one frame must reach the impulse. ODE"
               " is not connected.",
       .settings = "0.25 kg, flat and on a corner, no restitution",
       .run = break_height,
       .quantities = {"height"},
       .parameters = {0, 1},
       .parameter_text = "flat|on a corner",
       .max_exact_substeps = 0},
      {.name = "soft_depth",
       .title = "Sphere on a soft block",
       .what = "A sphere of 5 cm and 1 kg on a block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3, in "
               "chosen cells and in cells of 25 and 12.5 mm. Figure: depth in the third second compared "
               "with LiveGS in cells of 6.25 mm. The soft bodies of the peers are not connected to rigid "
               "ones here.",
       .settings = "1 kg, radius 5 cm, on 4 kg of 20 kPa",
       .run = soft_depth,
       .quantities = {"depth"},
       .parameters = {0, 0.025, 0.0125},
       .parameter_text = "chosen cells|cells of 25 mm|cells of 12.5 mm",
       .max_exact_substeps = 0},
  };
  return scenes;
}

}  // namespace livegs::study
