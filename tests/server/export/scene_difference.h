// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "export/portable_scene.h"

namespace livegs {

// The first difference of two scenes beyond `tolerance`, relative to max(1, magnitude) for positions and to
// the magnitude for masses, inertias and moduli; empty if there is none. Bodies are compared by name, kernels
// by number, and motion within `motion_tolerance`.
std::string scene_difference(const PortableScene& a, const PortableScene& b, double tolerance,
                             double motion_tolerance);

}  // namespace livegs
