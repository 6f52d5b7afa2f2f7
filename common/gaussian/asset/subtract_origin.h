// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gaussian/asset/decoded_asset.h"

namespace livegs {

// Moves an asset that lies far from zero (UTM and earth-centred coordinates) to zero: there the spacing of
// floats is no longer small against its kernels. The moved length, a whole number of units, is added to the
// frame's origin, and a note reports it. An asset near zero keeps its bits.
//
// `exact`: the positions in double precision, if the file has them; else those of the asset are used, and the
// note reports the loss of precision. With `exact`, the asset's positions are always written.
void subtract_origin(AssetFile& file, const std::vector<Eigen::Vector3d>* exact = nullptr);

}  // namespace livegs
