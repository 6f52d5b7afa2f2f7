// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/result.h"

// Admission control: estimates the memory of a scene before it is loaded and compares it with the free
// memory. A scene that does not fit is refused, since an allocation that fails later ends the process.

namespace livegs {

namespace v1 {
class Scene;
}

// The size of a scene as its files state it; no asset is decoded.
struct SceneSize {
  uint64_t kernels = 0;  // in all assets; exact for .ply, else from the file's size
  size_t bodies = 0;     // objects of the scene file
  size_t clients = 0;    // sessions that may be open at once
};
// `folder` is the base of the file's paths. An asset that cannot be read counts as empty; loading reports it.
SceneSize scene_size(const v1::Scene& file, const std::filesystem::path& folder, size_t clients);

// Peak bytes, reached while the scene is loaded. Normal values: 0.2 GB for a scene of shapes with 64 clients;
// a million kernels add 0.8 GB.
uint64_t scene_bytes(const SceneSize& size);

// Free bytes for this process: MemAvailable of /proc/meminfo (the machine's total memory if that file is not
// available), or the rest of the memory limit of its control group, v1 or v2, if that is less. `root`
// replaces / in tests.
uint64_t free_bytes(const std::filesystem::path& root = "/");

// Unavailable, with both sizes and a remedy, if `needed_bytes` exceeds `free_bytes`.
Result<void> check_memory(uint64_t needed_bytes, uint64_t free_bytes);
// The same check for the scene file or asset folder at `path`. A scene that cannot be read passes; loading
// reports it.
Result<void> check_scene_memory(const std::filesystem::path& path, size_t clients);

}  // namespace livegs
