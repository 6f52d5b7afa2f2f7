// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "core/result.h"
#include "livegs/v1/session.pb.h"
#include "skin/driver_frame.h"
#include "wire/frame_stream.h"

namespace livegs {

// The frames of one stream, whatever the client asked for when it joined. One thread.
class FrameReader {
 public:
  explicit FrameReader(v1::JoinRequest::Encoding encoding) : encoding_(encoding) {}
  // Of kernels, which are large; or else of drivers.
  static bool is_kernel_encoding(v1::JoinRequest::Encoding encoding) {
    return encoding == v1::JoinRequest::KERNELS || encoding == v1::JoinRequest::KERNELS_EXACT;
  }

  // Accepts any bytes. Kernels come as objects that have `kernels`, which can be drawn, and no drivers.
  Result<DriverFrame> read(std::span<const std::byte> bytes);
  // Only a key frame helps (ask for one): before the first, and after a frame that could not be read. Never
  // where each frame is by itself.
  bool needs_key_frame() const { return encoding_ == v1::JoinRequest::DRIVERS && stream_.needs_key_frame(); }

 private:
  const v1::JoinRequest::Encoding encoding_;
  StreamReader stream_;
};

}  // namespace livegs
