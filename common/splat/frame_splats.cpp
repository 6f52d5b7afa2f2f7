// SPDX-License-Identifier: Apache-2.0
#include "splat/frame_splats.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/assert.h"
#include "splat/project_splats.h"
#include "splat/spherical_harmonics.h"

namespace livegs {
namespace {

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

}  // namespace

FrameSplats::~FrameSplats() { release(); }

void FrameSplats::release() {
  sorter_.reset();
  for (BufferId* buffer : {&views_, &rows_[0], &rows_[1]}) {
    if (*buffer != BufferId{}) (void)backend_->destroy_buffer(*buffer);
    *buffer = {};
  }
  rows_held_[0] = rows_held_[1] = 0;
}

Result<void> FrameSplats::make_room(uint32_t kernels, size_t eyes) {
  const uint32_t wanted[2] = {kernels, eyes == 2 ? kernels : 1};
  if (sorter_ && sorter_->capacity() >= kernels && rows_held_[0] >= wanted[0] && rows_held_[1] >= wanted[1])
    return {};
  // A quarter more than asked for where something grows, so that a scene that breaks apart settles soon. All
  // goes before anything is made: the old and the new together might not fit.
  const bool grows = sorter_.has_value();
  release();
  const auto with_spare = [&](uint32_t count) {
    return count > 1 && grows ? std::min(count + count / 4, KeySorter::kMaxKeys) : count;
  };
  const auto failed = [&](const Error& error) {
    release();
    return Error{error.code, "a frame of " + std::to_string(kernels) + " kernels: " + error.message};
  };
  auto views = backend_->create_buffer(sizeof(FrameViews));
  if (!views) return failed(views.error());
  views_ = *views;
  device_bytes_ = sizeof(FrameViews);
  for (int e = 0; e < 2; ++e) {
    const uint32_t count = with_spare(wanted[e]);
    auto rows = backend_->create_buffer(count * sizeof(SplatRow));
    if (!rows) return failed(rows.error());
    rows_[e] = *rows;
    rows_held_[e] = count;
    device_bytes_ += count * sizeof(SplatRow);
  }
  auto sorter = KeySorter::create(*backend_, with_spare(kernels));
  if (!sorter) return failed(sorter.error());
  sorter_.emplace(*std::move(sorter));
  device_bytes_ += size_t{16} * sorter_->capacity();
  return {};
}

Result<void> FrameSplats::project(std::span<const DeviceKernels* const> objects, std::span<const Camera> eyes,
                                  const Options& options) {
  if (auto done = prepare(objects, eyes, options); !done) return done;
  return project_prepared(objects, options);
}

Result<void> FrameSplats::prepare(std::span<const DeviceKernels* const> objects, std::span<const Camera> eyes,
                                  const Options& options) {
  LIVEGS_ASSERT(eyes.size() == 1 || eyes.size() == 2);
  uint64_t total = 0;
  for (const DeviceKernels* object : objects) total += object->size();
  if (total > KeySorter::kMaxKeys) {
    return Error{ErrorCode::TooLarge, "a frame of " + std::to_string(total) + " kernels; the most is " +
                                          std::to_string(KeySorter::kMaxKeys)};
  }
  kernel_count_ = static_cast<uint32_t>(total);
  if (auto made = make_room(std::max(1u, kernel_count_), eyes.size()); !made) return made;
  const FrameViews views = frame_views(eyes, options);
  return backend_->upload(views_, std::as_bytes(std::span(&views, 1)));
}

Result<void> FrameSplats::project_prepared(std::span<const DeviceKernels* const> objects, const Options& options) {
  uint32_t first_row = 0;
  for (const DeviceKernels* object : objects) {
    const int degree = std::clamp(options.max_sh_degree, 0, std::min(object->sh_degree(), kMaxShDegree));
    for (const DeviceKernels::Part& part : object->parts()) {
      const ProjectSplatsConstants constants{part.count, first_row, static_cast<uint32_t>(degree),
                                             object->sh_row_words(), object->antialiased() ? 1u : 0u};
      const std::array buffers{views_,   part.posed, part.looks,     part.bands,
                               rows_[0], rows_[1],   sorter_->keys()};
      if (auto done = backend_->dispatch(project_splats_pass(), buffers,
                                         std::as_bytes(std::span(&constants, 1)), part.count);
          !done) {
        return done;
      }
      first_row += part.count;
    }
  }
  return {};
}

Result<void> FrameSplats::sort() {
  LIVEGS_ASSERT(sorter_.has_value());
  return sorter_->sort(kernel_count_, {.index_values = true, .drops_keys = true});
}

}  // namespace livegs
