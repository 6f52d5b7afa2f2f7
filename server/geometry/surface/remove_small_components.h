// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"

namespace livegs {

struct SmallComponents {
  int count = 0;
  double volume_share = 0.0;  // relative to the original volume
};

// Removes separate pieces of a closed mesh that are small and short: less than a thousandth of the volume and
// less than a twentieth of the bounding-box diagonal. Leaves of a plant are kept, floaters are removed. The
// largest piece is always kept.
SmallComponents remove_small_components(TriangleMesh& mesh);

// Removes vertices that no triangle uses; the order is kept.
void remove_unused_vertices(TriangleMesh& mesh);

}  // namespace livegs
