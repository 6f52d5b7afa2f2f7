// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/result.h"
#include "gaussian/progressive_asset.h"
#include "skin/driver_rows.h"
#include "skin/rest_body.h"
#include "splat/passes/project_splats_layout.h"

namespace livegs {

// Binds objects of a browser client to the parts of their assets that have arrived, and packs their kernels.
// This takes seconds for a large asset, so it runs in a second worker (page/binder.js). Its results are
// passed to LiveScene. One thread.
class AssetBinder {
 public:
  // An object's kernels. The arrays have the layouts of the passes.
  struct Bound {
    uint32_t description = 0;
    uint32_t reserved = 0;  // kernels of the whole asset
    int sh_degree = 0;
    bool antialiased = false;
    std::vector<RestKernelRow> rest;
    std::vector<KernelLookRow> looks;
    std::vector<uint32_t> bands;
    // Lattice, as in KernelBindings.
    std::vector<NodeGradientTerm> node_terms;
    std::vector<uint32_t> node_terms_begin;
  };

  // Assets, by a number of the caller.
  Result<void> take_asset(uint32_t asset, std::span<const std::byte> bytes);  // the next bytes
  // The next bytes of `asset` are the first, and may be an edit of `base`. Returns false if the base is not
  // finished, or lacks kernels that cannot be drawn.
  bool edit_asset(uint32_t asset, uint32_t base);
  // After the last bytes, once they are known to be right: until then, objects are bound to parts only.
  // Returns false, and changes nothing, if bytes are missing.
  bool finish_asset(uint32_t asset);
  void drop_asset(uint32_t asset) { assets_.erase(asset); }

  // An object to bind; `description` is an ascending number of the caller.
  Result<void> describe(uint32_t description, uint32_t asset, std::span<const std::byte> rest_body);
  void forget(uint32_t description) { descriptions_.erase(description); }
  // Binds the first object that is due: one without kernels, or one whose asset has doubled or is finished.
  // Returns false if none is due. After an error, the object is no longer bound; bound() then has its number
  // only.
  Result<bool> bind_next();
  const Bound& bound() const { return bound_; }  // of the last bind_next()
  void release() { bound_ = {}; }

 private:
  struct Asset {
    ProgressiveDecoder decoder;
    uint32_t kernel_count = 0;               // of the whole asset; 0 before its head
    std::shared_ptr<const AssetPart> whole;  // once it is finished; the decoder is then empty
    size_t arrived() const { return whole ? SIZE_MAX : decoder.arrived() + decoder.arrived_harmonics(); }
  };
  struct Description {
    uint32_t asset = 0;
    RestBody rest;
    size_t bound = 0;  // Asset::arrived() when it was bound
  };

  Result<void> bind(const Description& description, const Asset& asset);

  std::map<uint32_t, Asset> assets_;
  std::map<uint32_t, Description> descriptions_;  // whose kernels are not all bound
  Bound bound_;
};

}  // namespace livegs
