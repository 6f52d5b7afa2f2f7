// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/rigid_chart.h"
#include "study/harness/rigid_scenes.h"

namespace livegs::study {

std::span<const RigidChartScene> rigid_chart_scenes() {
  static const std::vector<RigidChartScene> scenes = {
      {.name = "incline",
       .title = "Slab on a slope",
       .what = "A slab of 0.2 x 0.05 x 0.2 m on a plane, friction 0.1, 0.3, 0.5, 0.7 and 1, the worst of the "
               "five: between "
               "the angle at which it starts to slide (found to 0.003 degrees) and atan(mu); how far it "
               "creeps in 10 s one degree below; its "
               "acceleration ten degrees above against g (sin - mu cos).",
       .settings = "0.2 x 0.05 x 0.2 m, mu 0.1 to 1",
       .run = incline,
       .quantities = {"threshold", "creep", "acceleration"},
       .quick_substeps = {1, 2, 4, 8, 16}},
      {.name = "stopping",
       .title = "Stopping distance",
       .what = "The slab slides off at 2 m/s along x and along the diagonal, friction 0.2, 0.4 and 0.7, the "
               "worst of the "
               "six: its way against v^2 / (2 mu g), and how fast it still moves once it has stopped.",
       .settings = "2 m/s, mu 0.2, 0.4, 0.7, along x and the diagonal",
       .run = stopping,
       .quantities = {"distance", "drift"}},
      {.name = "rolling_box",
       .title = "Pushed box under 25 balls",
       .what = "After half a second at rest, 150 N push a box of 10 kg, with 25 balls of 1 kg on it, over a "
               "floor of friction 0.4: its speed 1 s later "
               "against the closed form, the worst of x, z and the diagonal, and how much the three differ. "
               "The push is 9 % "
               "more than the floor's friction, so one per cent of friction is eleven of speed.",
       .settings = "10 kg, 150 N, 25 balls of 1 kg, mu 0.4 below and 0.8 above",
       .run = rolling_box,
       .quantities = {"speed", "isotropy"},
       .max_exact_substeps = 4},
      {.name = "tumbling",
       .title = "Dzhanibekov's tumbling",
       .what = "A free body with moments 1, 2, 3 kg m^2 turns at 10 rad/s about the middle one, 60 s: the "
               "farthest that energy "
               "and angular momentum stray, and the time of the first turn-over against Runge and Kutta's at "
               "0.1 ms.",
       .settings = "moments 1, 2, 3 kg m^2, spin (0.01, 10, 0.01) rad/s, 60 s",
       .run = tumbling,
       .quantities = {"energy", "momentum", "flip_time"},
       .max_exact_substeps = 0},
      {.name = "box_stack",
       .title = "Stack of twenty",
       .what = "Twenty cubes of 1 m and 1 kg on each other, friction 0.6, 30 s: how far the top sinks, in "
               "parts of the height; how "
               "far it leans; and when a second run that may sleep is asleep.",
       .settings = "20 cubes of 1 m, mu 0.6, 30 s",
       .run = box_stack,
       .quantities = {"sag", "lean", "asleep_after"},
       .max_exact_substeps = 0,
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "heavy_on_light",
       .title = "Heavy on light",
       .what = "A cube of 1 m on another that has a tenth, a hundredth or a thousandth of its mass, 10 s: "
               "how far it sinks, in "
               "parts of the lower cube.",
       .settings = "two cubes of 1 m, mu 0.6, 10 s",
       .run = heavy_on_light,
       .quantities = {"sag"},
       .parameters = {10, 100, 1000},
       .parameter_text = "1:%g"},
      {.name = "dominoes",
       .title = "Dominoes",
       .what = "Twenty dominoes of 0.2 x 0.02 x 0.1 m, 50 mm apart, the first let go 10 degrees over: the "
               "speed of the wave between "
               "the sixth and the sixteenth against our own solver's at 256 substeps a frame; the peers' own "
               "limits may lie "
               "elsewhere.",
       .settings = "20 of 0.2 x 0.02 x 0.1 m, 50 mm apart, mu 0.5",
       .run = dominoes,
       .quantities = {"wave_speed"},
       .max_exact_substeps = 0,
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "overlap",
       .title = "Overlap",
       .what = "Cubes of 1 m, 3 s, the highest speed with falling left out: ten in a column without gravity, "
               "each half within the "
               "next; ten in a pyramid on the floor, each half within its up to six neighbours; two at the "
               "very same place without "
               "gravity, on the upper edge where they do not part.",
       .settings = "cubes of 1 m, mu 0.6, half within each other or all",
       .run = overlap,
       .quantities = {"column_speed", "pyramid_speed", "coincident_speed"},
       .max_exact_substeps = 0},
      {.name = "ball_pendulum",
       .title = "Pendulum on a joint",
       .what = "A ball of 5 cm and 1 kg on an arm of 1 m, swinging on a ball joint for 10 s from 5 and from "
               "60 degrees: its period "
               "against the physical pendulum's, and the energy of the swing that is lost or gained.",
       .settings = "ball of 5 cm, arm 1 m, 10 s",
       .run = ball_pendulum,
       .quantities = {"period", "energy_lost"},
       .parameters = {5, 60},
       .parameter_text = "%g degrees"},
      {.name = "loaded_chain",
       .title = "Chain with a heavy end",
       .what = "Twenty links of 0.1 m and 0.1 kg hang from the world on ball joints, and at the end 100, "
               "1000 or 50000 times a "
               "link's mass, 10 s: how much longer it is in the last second. The bar of the last is that it "
               "hangs at all.",
       .settings = "20 links of 0.1 m and 0.1 kg, 10 s",
       .run = loaded_chain,
       .quantities = {"stretch"},
       .parameters = {100, 1000, 50000},
       .parameter_text = "1:%g",
       .quick_substeps = {1, 2, 4, 8}},
      {.name = "break_height",
       .title = "Height that breaks",
       .what = "A box of 0.08 x 0.1 x 0.08 m and 0.25 kg that breaks at the impulse which stops 3 m/s falls "
               "flat or "
               "on a corner without friction: of a hundred drops from a half to one and a half of 3^2 / 2g, "
               "the one "
               "farthest from it that broke below or held above. Bullet breaks nothing: there it counts "
               "whether all contacts of "
               "one frame gave as much. ODE is not connected.",
       .settings = "0.25 kg, flat and on a corner, no restitution",
       .run = break_height,
       .quantities = {"height"},
       .parameters = {0, 1},
       .parameter_text = "flat|on a corner",
       .max_exact_substeps = 0},
      {.name = "soft_depth",
       .title = "Sphere on a soft block",
       .what = "A sphere of 5 cm and 1 kg on a block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3, in cells "
               "that the program "
               "chooses, of 25 and of 12.5 mm: how deep it lies in the third second, against our own "
               "solver's in cells of "
               "6.25 mm. Neither peer's soft bodies are connected to its rigid ones here.",
       .settings = "1 kg, radius 5 cm, on 4 kg of 20 kPa",
       .run = soft_depth,
       .quantities = {"depth"},
       .parameters = {0, 0.025, 0.0125},
       .parameter_text = "cells left to it|cells of 25 mm|cells of 12.5 mm",
       .max_exact_substeps = 0},
  };
  return scenes;
}

}  // namespace livegs::study
