// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "export/portable_scene.h"

// Scenes as text of OpenUSD (.usda) with UsdPhysics, ParticleField3DGaussianSplat (26.03 and later) and
// attributes livegs:*, which README.md of this room lists. Any thread.

namespace livegs {

std::string encode_usda_scene(const PortableScene& scene);

// Returns the written file.
Result<std::vector<std::filesystem::path>> write_usda_scene(const std::filesystem::path& path,
                                                            const PortableScene& scene);

// Reads the bodies, joints, kernels and animation of a file in the form that is written here. Accepts any
// bytes. References, payloads, variants and other units than metres with +Y up are errors.
Result<PortableScene> decode_usda_scene(std::string_view text, std::string_view name);
Result<PortableScene> read_usda_scene(const std::filesystem::path& path);

}  // namespace livegs
