// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/result.h"
#include "skin/kernel_positions.h"
#include "skin/rest_body.h"
#include "splat/passes/key_order.h"
#include "splat/passes/order_depth.h"
#include "viewer/live/frame_playout.h"
#include "wire/frame_stream.h"

namespace livegs {

// The scene of a browser client: objects with their bound kernels (AssetBinder), their drivers at the moment
// of playout, and the order of all kernels. The rules are those of the native client (SceneView,
// ProgressiveObjects, FrameQueue); drawing is left to the page. No step takes longer than a pose of all
// kernels, so the same thread can serve a stream. One thread. Times are nanoseconds of the caller's clock.
class LiveScene {
 public:
  // Kernels of an object have global indices [base, base + size()); a range is reserved for all kernels of
  // the asset, so that more kernels do not move other objects.
  struct Object {
    uint32_t description = 0, base = 0, reserved = 0;
    bool environment = false;
    RestBody rest;
    KernelBindings bindings;  // only the terms of nodes
    std::vector<PlacedKernel> kernels;
    std::vector<RestKernelRow> rows_at_rest;  // environment only, whose order depends on its covariances
    std::vector<uint32_t> outside;            // kernels_outside
    bool fresh = true;                        // bound, and the page does not have its kernels yet
    std::optional<ObjectDrivers> posed_by;
    DriverRows rows;
    bool moved = false;  // since the last play()
    KernelPositions positions;
    std::array<std::vector<float>, 6> covariances_m2;  // environment only: xx xy xz yy yz zz
    std::vector<uint32_t> keys;
    bool keys_stale = true;
    size_t size() const { return kernels.size(); }
  };

  // A new or changed description. `description`: its number, ascending. `added`: replaces an object with the
  // same id, once its kernels are bound. Otherwise a new revision of the rest body is shown with the first
  // frame that moves it, and without one only `hidden` changes. Returns whether its kernels must be bound.
  Result<bool> describe(uint32_t description, uint32_t id, bool added, bool environment, bool hidden,
                        std::span<const std::byte> rest_body);
  void remove(uint32_t id);
  size_t waiting() const;  // descriptions without kernels yet

  // Kernels of a description, in parts: begin_bound(), take_rows() until all are there, end_bound(). The
  // latter returns whether they are used: false if the description was removed or replaced. A part that is
  // begun again starts over; a failure leaves the object as it was.
  void begin_bound(uint32_t description, uint32_t reserved);
  void take_rows(std::span<const RestKernelRow> rows);
  Result<bool> end_bound(std::span<const NodeGradientTerm> node_terms,
                         std::span<const uint32_t> node_terms_begin);
  void bind_failed(uint32_t description);

  // The stream. After a failed read, only a keyframe can be read.
  void begin_stream() { reader_ = StreamReader(); }
  bool needs_keyframe() const { return reader_.needs_keyframe(); }
  // Decoded by StreamReader (wire/frame_stream.h).
  Result<void> take_frame(std::span<const std::byte> bytes, int64_t received_ns);
  // Discards all frames, after a restart of the server or a seek in a recording.
  void restart() { playout_.reset(); }

  // Moves all objects to the playout moment. Returns whether the drivers, kernels or the set of drawn objects
  // changed.
  bool play(int64_t now_ns);
  uint64_t shown_tick() const { return playout_.shown() ? playout_.shown()->drivers->tick : 0; }
  std::span<const uint32_t> drawn() const { return drawn_; }  // ids, as in the last frame, ascending
  const Object* find(uint32_t id) const;
  // 98 % of the kernels of a sample of a drawn object, m.
  Eigen::AlignedBox3f bounds_m(uint32_t id) const;
  void kernels_sent(uint32_t id);  // clears `fresh`

  void set_view(const OrderView& view);
  // Depth keys of all drawn kernels; then their global indices, nearest first. Equal depths keep the order of
  // objects and kernels, as the native sort does. Invisible kernels are included; the page culls them.
  void update_keys();
  std::span<const uint32_t> sort();
  std::span<const uint32_t> order() const { return order_.order(); }  // of the last sort()

 private:
  struct Description {
    uint32_t id = 0;
    bool added = false, environment = false, bound = false;
    RestBody rest;
  };
  struct Frame {
    std::shared_ptr<const DriverFrame> drivers;
    int64_t received_ns = 0;
  };
  using Revisions = std::map<uint32_t, Object>;  // bound, by revision

  static void pose(Object& object, const ObjectDrivers& drivers);
  Object* shown(uint32_t id);
  uint32_t reserve(uint32_t kernels) const;

  std::map<uint32_t, Revisions> objects_;
  std::map<uint32_t, bool> hidden_;
  std::map<uint32_t, Description> descriptions_;  // by number
  Object bound_;                                  // between begin_bound() and end_bound()
  StreamReader reader_;
  FramePlayout<Frame> playout_;
  std::vector<uint32_t> drawn_;
  bool drawn_changed_ = false;
  OrderView view_{{0, 0, 0}, {0, 0, -1}, false};
  KeyOrder order_;
};

}  // namespace livegs
