// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/rigid_setup.h"

// The rigid scenes of the catalogue. Each fails where the engine cannot run it (no joints), with its reason.
// Sleep is off but where it is measured. Of several runs in one scene the worst counts.

namespace livegs::study {

// Scene 2. A slab of 0.2 x 0.05 x 0.2 m on a slope, friction 0.1, 0.3, 0.5, 0.7 and 1:
// `threshold` (degrees) between the angle at which it starts to slide and atan(mu), found by halving to 0.003
// degrees; `creep` (m) in 10 s, one degree below; `acceleration` ten degrees above against g (sin - mu cos).
Result<RigidOutcome> incline(const RigidSetup& setup);

// Scene 3. The slab slides off at 2 m/s along x and along the diagonal, friction 0.2, 0.4, 0.7: `distance`
// against v² / (2 mu g), `drift` (m/s) once it has stopped.
Result<RigidOutcome> stopping(const RigidSetup& setup);

// Scene 6. After half a second at rest 150 N push a box of 10 kg, with 25 balls of 1 kg on it, over a floor
// of friction 0.4 (0.8 under the balls): `speed` after 1 s of it along x, z and the diagonal against the
// closed form, `isotropy` between them.
Result<RigidOutcome> rolling_box(const RigidSetup& setup);

// Scene 8. A ball of 5 cm on an arm of 1 m swings for 10 s from `parameter` degrees: `period` against the
// physical pendulum's, `energy_lost` of that of the swing.
Result<RigidOutcome> ball_pendulum(const RigidSetup& setup);
double ball_pendulum_period_s(double amplitude_rad);

// Scene 9. Moments 1, 2, 3 kg m², turning at 10 rad/s about the middle one with 0.01 about the others, 60 s:
// `energy` and `momentum`, the farthest that they stray, and `flip_time` of the first turn-over against Runge
// and Kutta.
Result<RigidOutcome> tumbling(const RigidSetup& setup);

// Scene 13. Twenty cubes of 1 m, friction 0.6, 30 s: `sag` of the top in parts of the height, `lean` (m) of
// the top, `asleep_after` (s) of a second run that may sleep.
Result<RigidOutcome> box_stack(const RigidSetup& setup);

// Scene 14. A cube of 1 m on another, `parameter` times as heavy, 10 s: `sag` in parts of a cube.
Result<RigidOutcome> heavy_on_light(const RigidSetup& setup);

// Scene 15. Twenty links of 0.1 m, each on the one before, and at the end `parameter` times a link's mass, 10
// s: `stretch` of the length, mean over the last second.
Result<RigidOutcome> loaded_chain(const RigidSetup& setup);

// Scene 16. Twenty dominoes of 0.2 x 0.02 x 0.1 m, 50 mm apart; the first is let go 10 degrees over:
// `wave_speed` between the sixth and the sixteenth against our own solver's at 256 substeps.
Result<RigidOutcome> dominoes(const RigidSetup& setup);

// Scene 19. Cubes of 1 m, 3 s, the highest speed (m/s) but for falling: `column_speed` of ten in a column
// without gravity, each half within the next; `pyramid_speed` of ten in a pyramid on the floor, each half
// within its up to six neighbours; `coincident_speed` of two at the very same place without gravity, infinite
// where they do not part.
Result<RigidOutcome> overlap(const RigidSetup& setup);

// Breaking. A box of 0.08 x 0.1 x 0.08 m and 0.25 kg falls onto a floor, flat or, with a `parameter` of 1, on
// a corner without friction; it is to break at what stops 3 m/s there: m v, or v / (1 / m + (r x n) . I⁻¹ (r
// x n)) at the corner. `height` is the drop farthest from 3² / 2g, in parts of it, that broke below or held
// above, of a hundred from a half to one and a half.
Result<RigidOutcome> break_height(const RigidSetup& setup);

// Scene 29. A sphere of 5 cm and 1 kg on a soft block of 0.2 x 0.1 x 0.2 m, 4 kg, 20 kPa and nu 0.3, in cells
// of `parameter` (m; 0: as the program chooses): `depth` in the last of three seconds against our own
// solver's in cells of 6.25 mm (soft_depth_nightly_test has how it converges).
Result<RigidOutcome> soft_depth(const RigidSetup& setup);

}  // namespace livegs::study
