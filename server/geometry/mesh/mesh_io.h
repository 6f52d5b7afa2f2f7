// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Reads the surface in a Wavefront .obj file: `v` and `f` lines of all groups. Indices start at 1, or are
// negative from the end; polygons are split into fans. Other lines are ignored. Units are metres. Fails on
// values that are not finite, invalid indices and files without a face; the message names file and line.
// Memory is bounded by the file size, at most 256 MiB.
Result<TriangleMesh> read_obj(const std::filesystem::path& path);

}  // namespace livegs
