// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "export/portable_scene.h"

namespace livegs {

// A scene with all that a PortableScene can hold, random within plausible ranges and equal for a seed: bodies
// of every kind and shape at any pose, names of any characters, joints, lattices, regions, estimates and
// motion. Not a scene that can be simulated.
PortableScene made_up_scene(uint64_t seed);

}  // namespace livegs
