// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "export/gltf_scene.h"

namespace livegs {

// Violations of the glTF 2.0 specification in a document: lengths, alignment and bounds of buffer views and
// accessors, indices, the tree of nodes, unit rotations, the extensions that are used. Independent of the
// reader.
std::vector<std::string> gltf_violations(const GltfFiles& files);

}  // namespace livegs
