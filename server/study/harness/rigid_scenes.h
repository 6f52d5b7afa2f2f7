// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/rigid_setup.h"

// The rigid scenes of the catalogue. Each returns an error with the reason if the engine does not support it
// (no joints). Sleep is off except where it is measured. If a scene has several runs, the worst counts.

namespace livegs::study {

// Scene 2. A slab of 0.2 x 0.05 x 0.2 m on a slope, friction 0.1, 0.3, 0.5, 0.7 and 1. `threshold` (degrees):
// difference of the sliding angle, bisected to 0.003 degrees, to atan(mu). `creep` (m): in 10 s, one degree
// below. `acceleration`: ten degrees above, compared with g (sin - mu cos).
Result<RigidOutcome> incline(const RigidSetup& setup);

// Scene 3. The slab starts at 2 m/s along x and along the diagonal, friction 0.2, 0.4, 0.7. `distance`:
// compared with v² / (2 mu g). `drift` (m/s): after the stop.
Result<RigidOutcome> stopping(const RigidSetup& setup);

// Scene 6. After half a second at rest, 150 N push a box of 10 kg, carrying 25 balls of 1 kg, over a floor of
// friction 0.4 (0.8 under the balls). `speed`: after 1 s along x, z and the diagonal, compared with the
// closed form. `isotropy`: difference between the directions.
Result<RigidOutcome> rolling_box(const RigidSetup& setup);

// Scene 8. A ball of 5 cm on an arm of 1 m swings for 10 s from `parameter` degrees. `period`: compared with
// the physical pendulum. `energy_lost`: relative to that of the swing.
Result<RigidOutcome> ball_pendulum(const RigidSetup& setup);
double ball_pendulum_period_s(double amplitude_rad);

// Scene 9. Moments 1, 2, 3 kg m², rotating at 10 rad/s about the middle axis and at 0.01 about the others, 60
// s. `energy` and `momentum`: largest drift. `flip_time`: of the first flip, compared with Runge-Kutta.
Result<RigidOutcome> tumbling(const RigidSetup& setup);

// Scene 13. Twenty cubes of 1 m, friction 0.6, 30 s. `sag`: of the top, relative to the height. `lean` (m):
// of the top. `asleep_after` (s): of a second run with sleep enabled.
Result<RigidOutcome> box_stack(const RigidSetup& setup);

// Scene 14. A cube of 1 m on another, `parameter` times as heavy, 10 s. `sag`: relative to a cube.
Result<RigidOutcome> heavy_on_light(const RigidSetup& setup);

// Scene 15. A chain of twenty links of 0.1 m with a load of `parameter` times the mass of a link, 10 s.
// `stretch`: relative extension, mean over the last second.
Result<RigidOutcome> loaded_chain(const RigidSetup& setup);

// Scene 16. Twenty dominoes of 0.2 x 0.02 x 0.1 m, 50 mm apart; the first is released at a tilt of 10
// degrees. `wave_speed`: between the sixth and the sixteenth, compared with LiveGS at 256 substeps.
Result<RigidOutcome> dominoes(const RigidSetup& setup);

// Scene 19. Cubes of 1 m, 3 s, highest speed (m/s) without falling. `column_speed`: ten in a column without
// gravity, each overlapping the next by half. `pyramid_speed`: ten in a pyramid on the floor, each
// overlapping up to six neighbours by half. `coincident_speed`: two at the same place without gravity;
// infinite if they do not separate.
Result<RigidOutcome> overlap(const RigidSetup& setup);

// Breaking. A box of 0.08 x 0.1 x 0.08 m and 0.25 kg falls onto a floor, flat or, with a `parameter` of 1, on
// a corner without friction. It should break at the impulse that stops 3 m/s: m v, or v / (1 / m + (r x n) .
// I⁻¹ (r x n)) at the corner. `height`: of a hundred drops from 0.5 to 1.5 times 3² / 2g, the largest
// relative distance of a wrong result (a break below or none above).
Result<RigidOutcome> break_height(const RigidSetup& setup);

// Scene 29. A sphere of 5 cm and 1 kg on a soft block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3, in cells
// of `parameter` (m; 0: chosen by the program). `depth`: in the last of three seconds, compared with LiveGS
// in cells of 6.25 mm (convergence: soft_depth_nightly_test).
Result<RigidOutcome> soft_depth(const RigidSetup& setup);

}  // namespace livegs::study
