// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "gaussian/gaussian_asset.h"
#include "gaussian/gltf/gltf_document.h"

namespace livegs {

class GltfSplats;  // gltf_reader.cpp

// Reads the kernels of single meshes of a document, which outlives it. The kernels of all calls together are
// bounded by the size of the file. One thread.
class GltfMeshReader {
 public:
  explicit GltfMeshReader(const GltfDocument& document);
  ~GltfMeshReader();

  // The kernels of all splat primitives of a mesh, in the frame of GaussianAsset: half a turn about x from
  // that of the mesh. Empty if the mesh has none. Errors name the file.
  Result<GaussianAsset> read(const nlohmann::json& index);
  // The number of these kernels, as the accessors state it; an .spz without accessors is decoded.
  Result<size_t> count(const nlohmann::json& index);

 private:
  std::unique_ptr<GltfSplats> splats_;
};

}  // namespace livegs
