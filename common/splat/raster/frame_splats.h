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

// What one frame draws: the splats of all objects in one set, for one eye or two, and the one order in which
// both eyes draw them. Buffers are kept and go with the scene's size: 52 bytes a kernel for one eye, 88 for
// two, and 6.5 for kernels that passes pose: those are posed and projected an eighth of the frame at a time.
// An eye's rows lie in up to kRowParts buffers, so that each is one that the device binds: 128 MiB on
// lavapipe are 3.7 million kernels.
class FrameSplats {
 public:
  struct Options {
    DepthOrder order = DepthOrder::Distance;  // from between the eyes
    int max_sh_degree = 3;
    float max_radius_px = 0, min_contribution_px = 0;  // as eye_view has them
  };

  // What a frame knows of an object.
  struct Object {
    const DeviceKernels* kernels = nullptr;
    // Records a pass that writes PosedKernelRow of the kernels [first, first + count) to the front of
    // `posed`; they are of one part. None: kernels->pose() has said where they are.
    std::function<Result<void>(uint32_t first, uint32_t count, BufferId posed)> pose;
  };

  // `max_part_rows`: kernels whose rows share a buffer; 0: as many as the backend binds.
  explicit FrameSplats(Backend& backend, uint32_t max_part_rows = 0);
  FrameSplats(const FrameSplats&) = delete;
  FrameSplats& operator=(const FrameSplats&) = delete;

  // Makes room for these objects and sets the eyes, for the passes of project. TooLarge when the device
  // cannot hold them all.
  Result<void> prepare(std::span<const Object> objects, std::span<const Camera> eyes, const Options& options);
  // Poses, culls, projects and shades all kernels for one eye or two, those that were prepared.
  Result<void> project_prepared(std::span<const Object> objects, const Options& options);
  // Both.
  Result<void> project(std::span<const Object> objects, std::span<const Camera> eyes, const Options& options);
  // Nearest first. Call after project.
  Result<void> sort();

  // Gives all buffers back until the next frame.
  void release_buffers() { release(); }

  // After sort: places in rows(), and how many of them are drawn.
  BufferId order() const { return sorter_->values(); }
  BufferId counted() const { return sorter_->counted(); }
  // SplatRow of eye 0 or 1: part p has those of the places from p * part_rows() on. A part that is not there
  // is the first; with one eye the second has one row.
  BufferId rows(int eye, int part = 0) const {
    return (rows_[eye][part] ? rows_[eye][part] : rows_[eye][0]).id();
  }
  uint32_t part_rows() const { return part_rows_; }
  static constexpr int kRowParts =
      3;  // two eyes' and the order are seven buffers; a device binds eight or more (pass.h)
  uint64_t max_kernels() const {
    return std::min<uint64_t>(KeySorter::kMaxKeys, uint64_t{kRowParts} * part_rows_);
  }

  uint32_t kernel_count() const { return kernel_count_; }
  size_t device_bytes() const { return device_bytes_; }

 private:
  Result<void> make_room(uint32_t kernels, size_t eyes, bool poses);
  void release();
  Result<void> project_rows(const Object& object, const Options& options, BufferId posed,
                            const DeviceKernels::Part& part, uint32_t first, uint32_t count,
                            uint32_t first_place);

  Backend* backend_;
  std::optional<KeySorter> sorter_;
  uint32_t part_rows_;
  Buffer views_, rows_[2][kRowParts], posed_;
  uint32_t rows_held_[2]{}, posed_held_ = 0;
  uint32_t kernel_count_ = 0;
  size_t device_bytes_ = 0;
};

}  // namespace livegs
