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
#include "viewer/assets/rest_of_part.h"

namespace livegs {

// Shows objects with the received part of their assets, and refines them as more arrives. Kernels are bound
// to their drivers on internal threads. Use on the renderer's thread, except for request().
class ProgressiveObjects {
 public:
  // The library must outlive this object. Objects are refined only if the library returns incomplete assets
  // (AssetLibrary::show_parts). The destructor waits for running bindings.
  explicit ProgressiveObjects(AssetLibrary& assets) : assets_(assets) {}

  // Any thread.
  void request(const StreamedObject& object) { assets_.request(object); }

  // An object with bound kernels: those of its asset that had arrived.
  struct Binding {
    StreamedObject object;
    BoundObject bound;
    size_t step = 0;  // as in AssetLibrary::Arrived
    bool whole = true;
  };
  // Binds the first kernels of an asset that was requested. Errors: those of the fetch, of the decoder and of
  // bind_object().
  // `whole` true: waits for the complete asset and binds all kernels.
  std::future<Result<Binding>> bind(const StreamedObject& object, bool whole = false);
  // Shows a binding without blocking. `added` true: calls SceneView::add(); false: SceneView::change().
  void show(Binding binding, SceneView& view, bool added);
  // bind() and show(); blocks until the first kernels are bound. Errors: those of bind().
  Result<void> add(const StreamedObject& object, SceneView& view);
  void remove(uint32_t object_id, SceneView& view);

  // Shows kernels received and bound since the last call, without blocking. Returns the ids of the changed
  // objects, whose kernels are renumbered. Errors: those of bind(), for the first object that fails.
  Result<std::vector<uint32_t>> refine(SceneView& view);

  // Progress of the incomplete objects.
  struct Progress {
    size_t objects = 0;
    uint64_t kernels_shown = 0, kernels_total = 0;  // sums over these objects
  };
  Progress progress() const;

 private:
  // An incomplete object.
  struct Coarse {
    StreamedObject object;
    size_t shown = 0, step = 0;
    std::future<Result<Binding>> finer;  // valid while more of its kernels are being bound
  };
  std::future<Result<Binding>> bind_more(const StreamedObject& object, size_t than_step, bool whole = false);
  void remove_coarse(uint32_t object_id);

  AssetLibrary& assets_;
  std::map<uint32_t, Coarse> coarse_;                   // by object id
  std::vector<std::future<Result<Binding>>> unwanted_;  // of objects that were removed or fractured meanwhile
};

}  // namespace livegs
