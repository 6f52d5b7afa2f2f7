// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Soft things with a texture that can be tracked, in the frame of GaussianAsset, metres; the base is at y =
// 0.
GaussianAsset make_spiral_cord();  // seven turns 6 cm across of a cord of 1 cm, upright; 0.30 m high
GaussianAsset make_flowers();      // three heads on stems out of one foot; 0.30 m high
GaussianAsset make_large_leaf();   // an arching blade 0.16 m wide on a short stalk; 0.40 m long

}  // namespace livegs
