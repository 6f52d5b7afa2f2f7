// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"

namespace livegs {

struct SmallComponents {
  int count = 0;
  double volume_share = 0.0;  // of the whole, before
};

// Takes away the separate pieces of a closed mesh that are neither large nor long: less than a thousandth of
// the volume and less than a twentieth of the bounding-box diagonal. Leaves of a plant stay, floaters go. The
// largest piece always stays.
SmallComponents remove_small_components(TriangleMesh& mesh);

// The mesh without vertices that no triangle uses; order is kept.
void remove_unused_vertices(TriangleMesh& mesh);

}  // namespace livegs
