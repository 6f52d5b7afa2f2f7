// SPDX-License-Identifier: Apache-2.0
#include "skin/device_skin.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/assert.h"
#include "skin/driver_rows.h"
#include "skin/passes/skin_lattice_pass.h"
#include "skin/passes/skin_rigid_pass.h"

namespace livegs {

Result<DeviceSkin> DeviceSkin::create(Backend& backend, const RestBody& rest, const KernelBindings& bindings,
                                      std::span<const uint32_t> kept) {
  LIVEGS_ASSERT(skins(rest.kind) && bindings.kind == rest.kind);
  LIVEGS_ASSERT(kept.empty() || kept.back() < bindings.kernels.size());
  DeviceSkin skin(backend);
  skin.kind_ = rest.kind;
  skin.size_ = static_cast<uint32_t>(kept.empty() ? bindings.kernels.size() : kept.size());
  if (auto made = skin.make_rest_rows(bindings, kept); !made) return made.error();
  size_t driver_bytes = rest.bodies.size() * sizeof(RigidPoseRow);
  if (rest.kind == DriverKind::Lattice) {
    auto cells = Buffer::create(backend, rest.cells.size() * sizeof(rest.cells[0]));
    if (!cells) return cells.error();
    skin.cells_ = *std::move(cells);
    if (auto done = backend.upload(skin.cells_.id(), std::as_bytes(std::span(rest.cells))); !done)
      return done.error();
    driver_bytes = rest.node_coordinates.size() * sizeof(NodeState);
  }
  auto drivers = Buffer::create(backend, driver_bytes);
  if (!drivers) return drivers.error();
  skin.drivers_ = *std::move(drivers);
  return Result<DeviceSkin>(std::move(skin));
}

size_t DeviceSkin::device_bytes() const {
  size_t bytes = cells_.bytes() + drivers_.bytes();
  for (const Buffer& part : rest_) bytes += part.bytes();
  return bytes;
}

Result<void> DeviceSkin::make_rest_rows(const KernelBindings& bindings, std::span<const uint32_t> kept) {
  std::vector<RestKernelRow> rows;
  for (uint32_t first = 0; first < size_; first += kMaxPartKernels) {
    const uint32_t count = std::min(kMaxPartKernels, size_ - first);
    rows.resize(count);
    pack_rest_rows(bindings, kept, first, rows);
    auto made = Buffer::create(*backend_, count * sizeof(RestKernelRow));
    if (!made) return made.error();
    rest_.push_back(*std::move(made));
    if (auto done = backend_->upload(rest_.back().id(), std::as_bytes(std::span(rows))); !done) return done;
  }
  return {};
}

Result<void> DeviceSkin::move(const RestBody& rest, const KernelBindings& bindings,
                              const ObjectDrivers& drivers) {
  LIVEGS_ASSERT(rest.kind == kind_ && drivers.kind == kind_);
  const DriverRows rows = pack_driver_rows(rest, bindings, drivers);
  if (kind_ == DriverKind::Rigid) {
    body_count_ = static_cast<uint32_t>(rows.bodies.size());
    return backend_->upload(drivers_.id(), std::as_bytes(std::span(rows.bodies)));
  }
  lattice_ = {static_cast<uint32_t>(rest.cells.size()), static_cast<uint32_t>(rows.nodes.size()),
              rows.lattice.cell_width_m, rows.lattice.lattice_from_asset, rows.lattice.gradient};
  return backend_->upload(drivers_.id(), std::as_bytes(std::span(rows.nodes)));
}

Result<void> DeviceSkin::pose(uint32_t first, uint32_t count, BufferId posed) const {
  LIVEGS_ASSERT(count > 0 && first + count <= size_);
  const uint32_t part = first / kMaxPartKernels, within = first % kMaxPartKernels;
  LIVEGS_ASSERT(within + count <= kMaxPartKernels);
  if (kind_ == DriverKind::Rigid) {
    LIVEGS_ASSERT(body_count_ > 0);
    const SkinRigidConstants constants{count, within, body_count_};
    const std::array buffers{rest_[part].id(), drivers_.id(), posed};
    return backend_->dispatch(skin_rigid_pass(), buffers, std::as_bytes(std::span(&constants, 1)), count);
  }
  LIVEGS_ASSERT(lattice_.node_count > 0);
  const Eigen::Quaternionf& q = lattice_.lattice_from_asset;
  const Eigen::Matrix3f& f = lattice_.body_gradient;
  const SkinLatticeConstants constants{count,
                                       within,
                                       lattice_.cell_count,
                                       lattice_.node_count,
                                       lattice_.cell_width_m,
                                       q.x(),
                                       q.y(),
                                       q.z(),
                                       q.w(),
                                       f(0, 0),
                                       f(0, 1),
                                       f(0, 2),
                                       f(1, 0),
                                       f(1, 1),
                                       f(1, 2),
                                       f(2, 0),
                                       f(2, 1),
                                       f(2, 2)};
  const std::array buffers{rest_[part].id(), cells_.id(), drivers_.id(), posed};
  return backend_->dispatch(skin_lattice_pass(), buffers, std::as_bytes(std::span(&constants, 1)), count);
}

}  // namespace livegs
