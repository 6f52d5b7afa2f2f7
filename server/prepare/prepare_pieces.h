// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "core/result.h"
#include "geometry/triangle_mesh.h"
#include "physics/breakable_pieces.h"
#include "physics/material.h"

namespace livegs {

struct BreakableOptions {
  size_t piece_count = 32;  // requested, 1 to 64
  uint64_t seed = 1;
  std::stop_token stop{};
};

// Cuts a closed mesh (object frame). Mass is distributed over the volume, or evenly over the outer surface if
// `fill` is a shell and the mesh has no inner wall. May be called from any thread; takes seconds for a fine
// mesh. The result does not depend on the thread count. Errors describe the defect of the mesh.
Result<std::shared_ptr<const BreakablePieces>> prepare_pieces(const TriangleMesh& mesh, Fill fill,
                                                              const BreakableOptions& options = {});

}  // namespace livegs
