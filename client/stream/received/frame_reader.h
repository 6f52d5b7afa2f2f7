// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "skin/driver_frame.h"
#include "wire/frame_stream.h"

namespace livegs {

// Decodes the frames of one stream in any encoding. One thread.
class FrameReader {
 public:
  explicit FrameReader(v1::JoinRequest::Encoding encoding) : encoding_(encoding) {}
  // Whether frames hold kernels, which are large, instead of drivers.
  static bool is_kernel_encoding(v1::JoinRequest::Encoding encoding) {
    return encoding == v1::JoinRequest::KERNELS || encoding == v1::JoinRequest::KERNELS_EXACT;
  }

  // Accepts any bytes. Frames of kernels yield objects that have `kernels` and no drivers.
  Result<DriverFrame> read(std::span<const std::byte> bytes);
  // Whether the stream can continue only with a keyframe: at the start, and after a frame that could not be
  // read. Never true if frames do not depend on each other.
  bool needs_keyframe() const { return encoding_ == v1::JoinRequest::DRIVERS && stream_.needs_keyframe(); }

 private:
  const v1::JoinRequest::Encoding encoding_;
  StreamReader stream_;
};

}  // namespace livegs
