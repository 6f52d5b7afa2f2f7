// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "compute/buffer.h"
#include "skin/skin_kernels.h"

namespace livegs {

// The kernels of one object on a backend, bound to their drivers: skin_kernels as a pass. Takes 40 bytes per
// kernel, 32 per cell, and 64 per lattice node or rigid body. Moving the drivers uploads only the node or
// body data.
class DeviceSkin {
 public:
  // Whether a pass skins this kind. Particles (livegs-v1) are skinned by skin_kernels only.
  static bool skins(DriverKind kind) { return kind != DriverKind::Particles; }

  // `backend` outlives the skin. `kept` lists the bound kernels to use, ascending; empty: all. Precondition:
  // skins(rest.kind).
  static Result<DeviceSkin> create(Backend& backend, const RestBody& rest, const KernelBindings& bindings,
                                   std::span<const uint32_t> kept = {});

  // Uploads the current drivers, 64 bytes each. Preconditions: as for skin_kernels, with the arguments of
  // create().
  Result<void> move(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers);

  // Records the pass that writes PosedKernelRow of the kept kernels [first, first + count) to the front of
  // `posed`. Preconditions: move() was called; the range is within size() and does not cross a multiple of
  // kMaxPartKernels.
  Result<void> pose(uint32_t first, uint32_t count, BufferId posed) const;

  uint32_t size() const { return size_; }
  size_t device_bytes() const;

  // 40 MiB, of the 128 MiB that lavapipe binds
  static constexpr uint32_t kMaxPartKernels = uint32_t{1} << 20;

 private:
  explicit DeviceSkin(Backend& backend) : backend_(&backend) {}
  Result<void> make_rest_rows(const KernelBindings& bindings, std::span<const uint32_t> kept);

  // Pass constants besides the kernel range.
  struct Lattice {
    uint32_t cell_count = 0, node_count = 0;
    float cell_width_m = 0;
    Eigen::Quaternionf lattice_from_asset = Eigen::Quaternionf::Identity();
    Eigen::Matrix3f body_gradient = Eigen::Matrix3f::Identity();
  };

  Backend* backend_;
  DriverKind kind_ = DriverKind::Rigid;
  uint32_t size_ = 0, body_count_ = 0;
  std::vector<Buffer> rest_;  // one per part
  Buffer cells_, drivers_;
  Lattice lattice_;
};

}  // namespace livegs
