// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/result.h"
#include "gaussian/progressive_asset.h"
#include "skin/driver_rows.h"
#include "skin/rest_body.h"
#include "splat/passes/order_depth.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/passes/radix_sort.h"
#include "viewer/live/frame_playout.h"
#include "wire/frame_stream.h"

namespace livegs {

// The scene of a browser client: received objects, bound to the part of their assets that has arrived; their
// drivers at the moment of playout; and the order of all kernels. The rules are those of the native client
// (SceneView, ProgressiveObjects, FrameQueue); drawing is left to the page, which gets packed rows. One
// thread. Times are nanoseconds of the caller's clock.
class LiveScene {
 public:
  // Data of an object for the page. Kernels of an object have global indices [base, base + kernel_count); a
  // range is reserved for all kernels of the asset, so that more kernels do not move other objects.
  struct Object {
    uint32_t base = 0, reserved = 0;
    bool environment = false;
    int sh_degree = 0;
    bool antialiased = false;
    RestBody rest;  // of the arrived kernels
    KernelBindings bindings;
    // Set by a binding, until packed() was called.
    std::shared_ptr<const AssetPart> unpacked;
    std::optional<ObjectDrivers> posed_by;
    DriverRows rows;
    bool moved = false;  // since the last play()
    std::vector<Eigen::Vector3f> positions_m;
    std::vector<PosedKernelRow> posed;  // environment only, whose order depends on its covariances
    std::vector<uint32_t> keys;
    bool keys_stale = true;
    size_t size() const { return bindings.kernels.size(); }
  };
  struct Packed {
    std::vector<RestKernelRow> rest;
    std::vector<KernelLookRow> looks;
    std::vector<uint32_t> bands;
    Eigen::AlignedBox3f bounds_m;  // robust_bounds
  };

  // Assets, by a number of the caller.
  Result<void> take_asset(uint32_t asset, std::span<const std::byte> bytes);  // the next bytes
  bool asset_complete(uint32_t asset) const;
  size_t asset_arrived(uint32_t asset) const;  // grows with what can be drawn
  void drop_asset(uint32_t asset) { assets_.erase(asset); }

  // A new or changed description. `added`: replaces an object with the same id, once its kernels are bound.
  // Otherwise a new revision of the rest body is shown with the first frame that moves it, and without one
  // only `hidden` changes.
  Result<void> describe(uint32_t id, bool added, bool environment, bool hidden, uint32_t asset,
                        std::span<const std::byte> rest_body);
  void remove(uint32_t id);
  // Binds what has arrived for objects that wait for it; a bound part grows when its asset has doubled or is
  // complete. Returns whether anything was bound. An object that cannot be bound is left out, with an error.
  Result<bool> bind_arrived();
  size_t waiting() const { return waiting_.size(); }  // descriptions without kernels yet

  // The stream. After a failed read, only a keyframe can be read.
  void begin_stream() { reader_ = StreamReader(); }
  bool needs_keyframe() const { return reader_.needs_keyframe(); }
  Result<void> take_frame(std::span<const std::byte> bytes, int64_t received_ns);
  // Forgets the frames of a server that was restarted.
  void restart() { playout_.reset(); }

  // Moves all objects to the playout moment. Returns whether the drivers, kernels or the set of drawn objects
  // changed.
  bool play(int64_t now_ns);
  uint64_t shown_tick() const { return playout_.shown() ? playout_.shown()->drivers->tick : 0; }
  std::span<const uint32_t> drawn() const { return drawn_; }  // ids, as in the last frame, ascending
  const Object* find(uint32_t id) const;
  Packed packed(uint32_t id);  // once after each binding

  void set_view(const OrderView& view);
  // Depth keys of all drawn kernels; then their global indices, nearest first. Equal depths keep the order of
  // objects and kernels, as the native sort does. Kernels that no eye sees are included: the page culls them.
  void update_keys();
  std::span<const uint32_t> sort();
  std::span<const uint32_t> order() const { return order_; }  // of the last sort()

 private:
  struct Asset {
    ProgressiveDecoder decoder;
    uint32_t kernel_count = 0;               // of the whole asset; 0 before its head
    std::shared_ptr<const AssetPart> whole;  // once it is complete; the decoder is then empty
    size_t arrived() const { return whole ? SIZE_MAX : decoder.arrived() + decoder.arrived_harmonics(); }
  };
  struct Description {
    bool added = false, environment = false;
    uint32_t asset = 0;
    std::shared_ptr<const RestBody> rest;
    size_t bound = 0;  // Asset::arrived() when it was bound
  };
  struct Frame {
    std::shared_ptr<const DriverFrame> drivers;
    int64_t received_ns = 0;
  };
  using ObjectRevision = std::pair<uint32_t, uint32_t>;  // id, revision
  using Revisions = std::map<uint32_t, Object>;

  Result<void> bind(uint32_t id, const Description& description);
  static void pose(Object& object, const ObjectDrivers& drivers);
  uint32_t reserve(uint32_t kernels) const;

  std::map<uint32_t, Asset> assets_;
  std::map<uint32_t, Revisions> objects_;  // bound
  std::map<uint32_t, bool> hidden_;
  std::map<ObjectRevision, Description> waiting_;  // without kernels
  std::map<ObjectRevision, Description> coarse_;   // bound to a part of their asset
  StreamReader reader_;
  FramePlayout<Frame> playout_;
  std::vector<uint32_t> drawn_;
  bool drawn_changed_ = false;
  OrderView view_{{0, 0, 0}, {0, 0, -1}, false};
  std::vector<KeyedIndex> items_, scratch_;
  std::vector<uint32_t> order_;
};

}  // namespace livegs
