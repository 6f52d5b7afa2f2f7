// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace livegs {

// The buffer files of a .gltf, relative to its folder, each once. Empty if the file cannot be read or has all
// in one file.
std::vector<std::string> gltf_buffer_files(const std::filesystem::path& gltf);

}  // namespace livegs
