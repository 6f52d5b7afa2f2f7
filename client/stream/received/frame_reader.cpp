// SPDX-License-Identifier: Apache-2.0
#include "stream/received/frame_reader.h"

#include <utility>

#include "wire/frame_codec.h"
#include "wire/kernel_codec.h"

namespace livegs {
namespace {

constexpr float kMinRotationLength = 1e-3f;  // a shorter quaternion has no usable direction

DriverFrame as_drivers(KernelFrame frame) {
  DriverFrame drivers{frame.tick, frame.simulated_ns, {}};
  for (ObjectKernels& object : frame.objects) {
    for (Eigen::Quaternionf& turn : object.kernels.world_from_asset) {
      const float length = turn.norm();
      turn = length > kMinRotationLength ? Eigen::Quaternionf(turn.coeffs() / length)
                                         : Eigen::Quaternionf::Identity();
    }
    ObjectDrivers& one = drivers.objects.emplace_back();
    one.object_id = object.object_id;
    one.revision = object.revision;
    one.kernels = std::make_shared<const PosedKernels>(std::move(object.kernels));
  }
  return drivers;
}

}  // namespace

Result<DriverFrame> FrameReader::read(std::span<const std::byte> bytes) {
  if (encoding_ == v1::JoinRequest::DRIVERS) return stream_.read(bytes);
  if (encoding_ == v1::JoinRequest::DRIVERS_RAW) return decode_frame(bytes);
  auto kernels = decode_kernels(bytes);
  if (!kernels) return kernels.error();
  return as_drivers(*std::move(kernels));
}

}  // namespace livegs
