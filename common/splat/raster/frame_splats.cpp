// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/frame_splats.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/assert.h"
#include "gaussian/spherical_harmonics.h"
#include "splat/passes/project_splats.h"
#include "splat/shadow/shadow_layout.h"

namespace livegs {
namespace {

constexpr uint32_t kMinPoseBatch = 4096;

FrameViews frame_views(std::span<const Camera> eyes, const FrameSplats::Options& options) {
  FrameViews views{};
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::Zero();
  for (size_t e = 0; e < eyes.size(); ++e) {
    views.eye[e] = eye_view(eyes[e], options.max_radius_px, options.min_contribution_px);
    const Pose& pose = eyes[e].world_from_camera;
    origin += pose.position_m / static_cast<double>(eyes.size());
    axis -= pose.orientation.normalized() * Eigen::Vector3d::UnitZ();
  }
  const Eigen::Vector3f o = origin.cast<float>(), a = axis.normalized().cast<float>();
  views.origin_x_m = o.x();
  views.origin_y_m = o.y();
  views.origin_z_m = o.z();
  views.axis_x = a.x();
  views.axis_y = a.y();
  views.axis_z = a.z();
  views.eye_count = static_cast<uint32_t>(eyes.size());
  views.by_distance = options.order == DepthOrder::Distance ? 1 : 0;
  return views;
}

// Kernels posed per dispatch: a quarter of the frame keeps two eyes within 256 bytes per kernel and fills a
// large device (an H200 runs 270 000 threads at once).
uint32_t rows_posed_at_once(uint32_t kernels) {
  return std::min(kernels, std::max((kernels + 3) / 4, kMinPoseBatch));
}

// Maximum spare capacity of a buffer. A buffer with more is allocated again.
uint32_t most_spare(uint32_t wanted) { return std::max(wanted / 16, 256u); }

}  // namespace

FrameSplats::FrameSplats(Backend& backend, uint32_t max_part_rows)
    : backend_(&backend), part_rows_(static_cast<uint32_t>(backend.max_buffer_bytes() / sizeof(SplatRow))) {
  if (max_part_rows > 0) part_rows_ = std::min(part_rows_, max_part_rows);
}

void FrameSplats::release() {
  sorter_.reset();
  views_.reset();
  posed_.reset();
  shadows_.reset();
  for (auto& parts : rows_) {
    for (Buffer& part : parts) part.reset();
  }
  rows_held_[0] = rows_held_[1] = posed_held_ = 0;
  device_bytes_ = 0;
}

Result<void> FrameSplats::make_room(uint32_t kernels, size_t eyes, bool poses) {
  const uint32_t wanted[4] = {kernels, kernels, eyes == 2 ? kernels : 1,
                              poses ? rows_posed_at_once(kernels) : 0};
  const uint32_t held[4] = {sorter_ ? sorter_->capacity() : 0, rows_held_[0], rows_held_[1], posed_held_};
  bool fits = true;
  for (int i = 0; i < 4; ++i)
    fits = fits && held[i] >= wanted[i] && held[i] <= wanted[i] + most_spare(wanted[i]);
  if (fits) return {};
  // Growing buffers get spare capacity, so that a few more kernels fit. All buffers are released before new
  // ones are allocated, because old and new might not fit together.
  const bool grows = sorter_.has_value();
  release();
  const auto with_spare = [&](uint32_t count) {
    return count > 1 && grows
               ? static_cast<uint32_t>(std::min<uint64_t>(count + most_spare(count) / 2, max_kernels()))
               : count;
  };
  const auto failed = [&](const Error& error) {
    release();
    return Error{error.code, "frame: " + std::to_string(kernels) + " kernels; " + error.message};
  };
  const auto make = [&](Buffer& buffer, size_t bytes) -> Result<void> {
    auto made = Buffer::create(*backend_, bytes);
    if (!made) return failed(made.error());
    buffer = *std::move(made);
    device_bytes_ += bytes;
    return {};
  };
  if (auto made = make(views_, sizeof(FrameViews)); !made) return made;
  for (int e = 0; e < 2; ++e) {
    const uint32_t count = with_spare(wanted[1 + e]);
    for (uint32_t part = 0, first = 0; first < count; ++part, first += part_rows_) {
      if (auto made = make(rows_[e][part], std::min(part_rows_, count - first) * sizeof(SplatRow)); !made)
        return made;
    }
    rows_held_[e] = count;
  }
  if (poses) {
    posed_held_ = with_spare(wanted[3]);
    if (auto made = make(posed_, posed_held_ * sizeof(PosedKernelRow)); !made) return made;
  }
  auto sorter = KeySorter::create(*backend_, with_spare(kernels));
  if (!sorter) return failed(sorter.error());
  sorter_.emplace(*std::move(sorter));
  device_bytes_ += sorter_->device_bytes();
  return {};
}

Result<void> FrameSplats::project(std::span<const Object> objects, std::span<const Camera> eyes,
                                  const Options& options) {
  if (auto done = prepare(objects, eyes, options); !done) return done;
  return project_prepared(objects, options);
}

Result<void> FrameSplats::prepare(std::span<const Object> objects, std::span<const Camera> eyes,
                                  const Options& options) {
  LIVEGS_ASSERT(eyes.size() == 1 || eyes.size() == 2);
  uint64_t total = 0;
  bool poses = false;
  for (const Object& object : objects) {
    total += object.kernels->size();
    poses = poses || object.pose;
  }
  if (total > max_kernels()) {
    return Error{ErrorCode::TooLarge, "frame: " + std::to_string(total) +
                                          " kernels exceed the limit of the device, " +
                                          std::to_string(max_kernels())};
  }
  kernel_count_ = static_cast<uint32_t>(total);
  if (auto made = make_room(std::max(1u, kernel_count_), eyes.size(), poses); !made) return made;
  if (auto done = upload_shadows(options.shadows); !done) return done;
  const FrameViews views = frame_views(eyes, options);
  return backend_->upload(views_.id(), std::as_bytes(std::span(&views, 1)));
}

// A device reads at least a header. The buffer grows with half of its size to spare.
Result<void> FrameSplats::upload_shadows(const ShadowTable* shadows) {
  if (shadows_ && shadows == shadows_of_ && (!shadows || shadows->version == shadows_version_)) return {};
  const std::vector<uint32_t> none(kShadowHeaderWords, 0);
  const std::vector<uint32_t>& words = shadows && !shadows->words.empty() ? shadows->words : none;
  const size_t bytes = 4 * words.size();
  if (!shadows_ || shadows_.bytes() < bytes) {
    device_bytes_ -= shadows_.bytes();
    shadows_.reset();
    auto made = Buffer::create(*backend_, words.size() > none.size() ? bytes + bytes / 2 / 4 * 4 : bytes);
    if (!made) return Error{made.error().code, "shadows: " + made.error().message};
    shadows_ = *std::move(made);
    device_bytes_ += shadows_.bytes();
  }
  shadows_of_ = shadows;
  shadows_version_ = shadows ? shadows->version : 0;
  return backend_->upload(shadows_.id(), std::as_bytes(std::span(words)));
}

Result<void> FrameSplats::project_rows(const Object& object, const Options& options, BufferId posed,
                                       const DeviceKernels::Part& part, uint32_t first, uint32_t count,
                                       uint32_t first_place) {
  const DeviceKernels& kernels = *object.kernels;
  const int degree = std::clamp(options.max_sh_degree, 0, std::min(kernels.sh_degree(), kMaxShDegree));
  const auto row_part = static_cast<int>(first_place / part_rows_);
  const ProjectSplatsConstants constants{.kernel_count = count,
                                         .first_kernel = first,
                                         .first_posed = posed == part.posed.id() ? first : 0,
                                         .first_key = first_place,
                                         .first_row = first_place % part_rows_,
                                         .sh_degree = static_cast<uint32_t>(degree),
                                         .sh_row_words = kernels.sh_row_words(),
                                         .antialiased = kernels.antialiased() ? 1u : 0u,
                                         .object_id = object.object_id,
                                         .order_bias = order_bias(object.object_id, options.environments)};
  const std::array buffers{
      views_.id(),       posed,           part.looks.id(), part.bands.id(), rows(0, row_part),
      rows(1, row_part), sorter_->keys(), shadows_.id()};
  return backend_->dispatch(project_splats_pass(), buffers, std::as_bytes(std::span(&constants, 1)), count);
}

Result<void> FrameSplats::project_prepared(std::span<const Object> objects, const Options& options) {
  uint32_t place = 0;
  for (const Object& object : objects) {
    for (const DeviceKernels::Part& part : object.kernels->parts()) {
      const uint32_t at_once = object.pose ? posed_held_ : part.count;
      for (uint32_t first = 0, count = 0; first < part.count; first += count) {
        count = std::min(
            {at_once, part.count - first, part_rows_ - place % part_rows_});  // within one part of both
        if (object.pose) {
          if (auto done = object.pose(part.first + first, count, posed_.id()); !done) return done;
        }
        if (auto done = project_rows(object, options, object.pose ? posed_.id() : part.posed.id(), part,
                                     first, count, place);
            !done)
          return done;
        place += count;
      }
    }
  }
  return {};
}

Result<void> FrameSplats::sort() {
  LIVEGS_ASSERT(sorter_.has_value());
  return sorter_->sort(kernel_count_, {.index_values = true, .drops_keys = true});
}

}  // namespace livegs
