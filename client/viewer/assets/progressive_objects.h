// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <future>
#include <map>
#include <span>
#include <vector>

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/asset_library.h"

namespace livegs {

// Shows objects with what has come of their assets, coarse at first, and anew when there is more: a person
// sees the scene while it is still being fetched. Kernels are tied to their drivers on threads of their own.
// The drawer's thread, except for request().
class ProgressiveObjects {
 public:
  // The library outlives this; objects come coarse if it shows parts. The end waits for kernels that are
  // being tied.
  explicit ProgressiveObjects(AssetLibrary& assets) : assets_(assets) {}

  // Any thread.
  void request(const StreamedObject& object) { assets_.request(object); }

  // An object with as much of its asset as there was.
  struct Binding {
    StreamedObject object;
    BoundObject bound;
    size_t step = 0;  // as AssetLibrary::Arrived has it
    bool whole = true;
  };
  // Ties the first kernels that come of an asset, which was asked for.
  std::future<Result<Binding>> bind(const StreamedObject& object);
  // Waits for nothing. `added`: as SceneView::add, else as its change().
  void show(Binding binding, SceneView& view, bool added);
  // Both; it waits for those kernels.
  Result<void> add(const StreamedObject& object, SceneView& view);
  void remove(uint32_t object_id, SceneView& view);

  // Shows what has come since and is tied by now; the ids of the objects that have other kernels now, under
  // other numbers. Waits for nothing.
  Result<std::vector<uint32_t>> refine(SceneView& view);

  // Of the objects that are not whole yet.
  struct Progress {
    size_t objects = 0;
    uint64_t kernels = 0, of = 0;
  };
  Progress progress() const;

 private:
  // An object that is not whole yet.
  struct Coarse {
    StreamedObject object;
    size_t shown = 0, step = 0;
    std::future<Result<Binding>> finer;  // while more of it is being tied
  };
  std::future<Result<Binding>> bind_more(const StreamedObject& object, size_t than_step);
  void remove_coarse(uint32_t object_id);

  AssetLibrary& assets_;
  std::map<uint32_t, Coarse> coarse_;                   // by object id
  std::vector<std::future<Result<Binding>>> unwanted_;  // of objects that went, or broke, meanwhile
};

// The rest body of those kernels of an asset alone: which body each goes with.
RestBody rest_of_part(const RestBody& rest, std::span<const uint32_t> indices);

}  // namespace livegs
