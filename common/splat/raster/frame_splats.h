// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <span>

#include "splat/camera.h"
#include "splat/passes/device_kernels.h"
#include "splat/passes/key_sorter.h"
#include "splat/rasterise.h"

namespace livegs {

// The splats of all objects of one frame in one set, for one eye or two, and the draw order shared by both
// eyes. Buffers are kept and sized by the scene: 52 bytes per kernel for one eye, 88 for two, and 13 for
// kernels posed by passes, which are posed and projected a quarter of the frame at a time, besides the
// shadows. The rows of an eye are in up to kRowParts buffers, each within the binding limit of the device
// (lavapipe: 128 MiB, or 3.7 million kernels).
class FrameSplats {
 public:
  struct Options {
    DepthOrder order = DepthOrder::Distance;  // from the midpoint between the eyes
    int max_sh_degree = 3;
    float max_radius_px = 0, min_contribution_px = 0;  // as in eye_view
    const ShadowTable* shadows = nullptr;              // of one SceneShadows; null: none
    std::vector<uint32_t> environments = {};           // object ids, see kEnvironmentOrderBias
  };

  // An object of the frame.
  struct Object {
    const DeviceKernels* kernels = nullptr;
    // Records a pass that writes PosedKernelRow of the kernels [first, first + count), all of one part, to
    // the front of `posed`. Empty: kernels->pose() has set the poses.
    std::function<Result<void>(uint32_t first, uint32_t count, BufferId posed)> pose;
    uint32_t object_id = 0;  // as in the options
  };

  // `max_part_rows`: kernels whose rows share a buffer; 0: the maximum that the backend can bind.
  explicit FrameSplats(Backend& backend, uint32_t max_part_rows = 0);
  FrameSplats(const FrameSplats&) = delete;
  FrameSplats& operator=(const FrameSplats&) = delete;

  // Allocates space for these objects and sets the eyes for project_prepared(). TooLarge if the device cannot
  // hold them all.
  Result<void> prepare(std::span<const Object> objects, std::span<const Camera> eyes, const Options& options);
  // Poses, culls, projects and shades all prepared kernels for one eye or two.
  Result<void> project_prepared(std::span<const Object> objects, const Options& options);
  // prepare() and project_prepared().
  Result<void> project(std::span<const Object> objects, std::span<const Camera> eyes, const Options& options);
  // Sorts nearest first. Call after project().
  Result<void> sort();

  // Releases all buffers until the next frame.
  void release_buffers() { release(); }

  // After sort(): indices into rows(), and the number that are drawn.
  BufferId order() const { return sorter_->values(); }
  BufferId counted() const { return sorter_->counted(); }
  // SplatRow of eye 0 or 1: part p has the indices from p * part_rows() on. A missing part is replaced by the
  // first. With one eye, the second eye has one row.
  BufferId rows(int eye, int part = 0) const {
    return (rows_[eye][part] ? rows_[eye][part] : rows_[eye][0]).id();
  }
  uint32_t part_rows() const { return part_rows_; }
  // three per eye and the order are seven buffers; a device binds at least eight (pass.h)
  static constexpr int kRowParts = 3;
  uint64_t max_kernels() const {
    return std::min<uint64_t>(std::min<uint64_t>(KeySorter::kMaxKeys, backend_->max_buffer_bytes() / 4),
                              uint64_t{kRowParts} * part_rows_);
  }

  uint32_t kernel_count() const { return kernel_count_; }
  size_t device_bytes() const { return device_bytes_; }

 private:
  Result<void> make_room(uint32_t kernels, size_t eyes, bool poses);
  Result<void> upload_shadows(const ShadowTable* shadows);
  void release();
  Result<void> project_rows(const Object& object, const Options& options, BufferId posed,
                            const DeviceKernels::Part& part, uint32_t first, uint32_t count,
                            uint32_t first_place);

  Backend* backend_;
  std::optional<KeySorter> sorter_;
  uint32_t part_rows_;
  Buffer views_, rows_[2][kRowParts], posed_, shadows_;
  uint32_t rows_held_[2]{}, posed_held_ = 0;
  uint32_t kernel_count_ = 0;
  // The table in `shadows_`.
  const ShadowTable* shadows_of_ = nullptr;
  uint64_t shadows_version_ = 0;
  size_t device_bytes_ = 0;
};

}  // namespace livegs
