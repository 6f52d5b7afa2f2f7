// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "compute/pass.h"
#include "device/passes/elastic_layout.h"

// The passes of a step of elastic bodies, in their order. The text of a pass is compiled as the shader and as
// the CPU function. Buffers, in the order of the bindings, are of the rows of elastic_layout.h. Bodies are
// concatenated; the nodes of each fill whole blocks of kElasticBlock, and a node belongs to the body of its
// block. Rows are trusted: indices outside the buffers are errors of the caller.

namespace livegs {

// One item per node. Bodies, state, previous state, NodeSolveRow, NodeDriftRow, loads (N), body by block.
const Pass& elastic_predict_pass();
// One item per cell from `first` on; acts on those of the colour `rank`. Bodies, CellRow, rotations,
// NodeSolveRow, constants, gains.
const Pass& elastic_cells_pass();
// One item per surface cell, likewise. Bodies, SurfaceCellRow, SurfacePointRow, state, NodeSolveRow,
// NodeDriftRow, ContactSumsRow, ColliderRow.
const Pass& elastic_contact_pass();
// One item per node. Writes the new state over the previous one. Bodies, state, previous state, NodeSolveRow,
// NodeDriftRow, loads, NodeSumsRow by block, body by block.
const Pass& elastic_advance_pass();
// kElasticBlock items per body. Bodies, NodeSumsRow, ContactSumsRow.
const Pass& elastic_ledger_pass();

}  // namespace livegs
