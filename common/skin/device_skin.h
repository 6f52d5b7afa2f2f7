// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "compute/buffer.h"
#include "skin/skin_kernels.h"

namespace livegs {

// The kernels of one object where passes run, tied to their drivers: what skin_kernels does, on the device.
// 40 bytes a kernel, 32 a cell and 64 a node of a lattice or a body of a rigid object; of these the last
// alone are uploaded when the drivers move.
class DeviceSkin {
 public:
  // Whether a pass skins kernels of this kind; those of particles (livegs-v1) are skin_kernels' alone.
  static bool skins(DriverKind kind) { return kind != DriverKind::Particles; }

  // `backend` outlives the skin. `kept`: which of the bound kernels, ascending; empty: all.
  // Precondition: skins(rest.kind).
  static Result<DeviceSkin> create(Backend& backend, const RestBody& rest, const KernelBindings& bindings,
                                   std::span<const uint32_t> kept = {});

  // Where the drivers are now: uploads 64 bytes each. Preconditions: as skin_kernels, of what the skin was
  // made with.
  Result<void> move(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers);

  // Records the pass that writes PosedKernelRow of the kept kernels [first, first + count) to the front of
  // `posed`. Precondition: move() was called; the range is within size() and crosses no multiple of
  // kMaxPartKernels.
  Result<void> pose(uint32_t first, uint32_t count, BufferId posed) const;

  uint32_t size() const { return size_; }
  size_t device_bytes() const;

  static constexpr uint32_t kMaxPartKernels = uint32_t{1} << 20;  // 40 MiB, of the 128 that lavapipe binds

 private:
  explicit DeviceSkin(Backend& backend) : backend_(&backend) {}
  Result<void> make_rest_rows(const KernelBindings& bindings, std::span<const uint32_t> kept);
  Result<void> move_bodies(const RestBody& rest, const ObjectDrivers& drivers);
  Result<void> move_lattice(const RestBody& rest, const KernelBindings& bindings,
                            const ObjectDrivers& drivers);

  // What the passes are told besides which kernels.
  struct Lattice {
    uint32_t cell_count = 0, node_count = 0;
    float cell_width_m = 0;
    Eigen::Quaternionf lattice_from_asset = Eigen::Quaternionf::Identity();
    Eigen::Matrix3f body_gradient = Eigen::Matrix3f::Identity();
  };

  Backend* backend_;
  DriverKind kind_ = DriverKind::Rigid;
  uint32_t size_ = 0, body_count_ = 0;
  std::vector<Buffer> rest_;  // by part
  Buffer cells_, drivers_;
  Lattice lattice_;
};

}  // namespace livegs
