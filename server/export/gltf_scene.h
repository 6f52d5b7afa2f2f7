// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "export/portable_scene.h"

// Scenes as glTF 2.0 (Khronos) with KHR_gaussian_splatting, KHR_physics_rigid_bodies, KHR_implicit_shapes and
// LIVEGS_physics; the last is specified in README.md of this room. Any thread.

namespace livegs {

struct GltfWriteOptions {
  bool spz = false;  // splats as .spz (KHR_gaussian_splatting_compression_spz_2); lossy
};

struct GltfFiles {
  std::string json;               // with buffer 0 at `binary_name`
  std::vector<std::byte> binary;  // buffer 0
};

// The document; `binary_name`: URI of its buffer, empty for the chunk of a .glb. Fails if the buffer exceeds
// 4 GiB or an asset does not fit .spz.
Result<GltfFiles> encode_gltf_scene(const PortableScene& scene, std::string_view binary_name,
                                    const GltfWriteOptions& options = {});
// Joins the two into a .glb. Precondition: binary_name was empty.
Result<std::vector<std::byte>> encode_glb(const GltfFiles& files);

// Writes a .glb, or a .gltf with a .bin of the same name next to it. Returns the written files.
Result<std::vector<std::filesystem::path>> write_gltf_scene(const std::filesystem::path& path,
                                                            const PortableScene& scene,
                                                            const GltfWriteOptions& options = {});

struct GltfReadOptions {
  bool kernels = true;  // false: kernels are counted, not decoded, and bodies have no asset
};

// Reads bodies, joints and animation; also of documents without LIVEGS_physics, as far as they have physics.
// A document without any gives a scene without bodies. Kernels of a body that are stretched, or of several
// nodes, are counted, not read (read_asset reads them). Accepts any bytes. `folder`: of the buffers of a
// .gltf; empty: there are none.
Result<PortableScene> decode_gltf_scene(std::span<const std::byte> bytes, const std::filesystem::path& folder,
                                        std::string_view name, const GltfReadOptions& options = {});
Result<PortableScene> read_gltf_scene(const std::filesystem::path& path, const GltfReadOptions& options = {});

}  // namespace livegs
