// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// The surface in a Wavefront .obj: `v` and `f` lines (indices from 1, or negative from the end; polygons are
// cut into fans), all groups together, everything else passed over. Units are taken as metres. Fails on
// values that are not finite, indices that name no vertex and files without a face; the message names file
// and line. Memory is bounded by the size of the file, which may be at most 256 MiB.
Result<TriangleMesh> read_obj(const std::filesystem::path& path);

}  // namespace livegs
