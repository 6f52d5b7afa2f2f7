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
// `folder` is the base of the file's paths. An asset that cannot be read counts as empty: loading reports it.
SceneSize scene_size(const v1::Scene& file, const std::filesystem::path& folder, size_t clients);

// Bytes at the peak, which is while the scene is loaded. Usual: 0.2 GB for a scene of shapes with 64 clients;
// a million kernels add 0.8 GB.
uint64_t scene_bytes(const SceneSize& size);

// Bytes that the process may still take: MemAvailable of /proc/meminfo (the whole memory of the machine where
// that file is hidden), or what the memory limit of a control group, v1 or v2, leaves if that is less. `root`
// stands in for / in tests.
uint64_t free_bytes(const std::filesystem::path& root = "/");

// Unavailable, with sizes and remedy in one line, when `needed_bytes` are more than `free_bytes`.
Result<void> check_memory(uint64_t needed_bytes, uint64_t free_bytes);
// The same for the scene or folder of assets at `path`. A scene that cannot be read passes: loading reports
// it.
Result<void> check_scene_memory(const std::filesystem::path& path, size_t clients);

}  // namespace livegs
