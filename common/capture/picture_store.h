// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "capture/capture.h"

namespace livegs {

// A photo without distortion at the working size, four bytes of each pixel, rows from the top. Colour is
// multiplied with alpha, so the photo over a background b is colour + (1 - alpha) b.
struct CapturedPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  // 255: the pixel is used. 0: it is ignored, because it is beyond the edge of a distorted photo or its mask
  // is 0. Empty: all are used.
  std::vector<uint8_t> counts;
  bool opaque = true;  // all alpha are 255
};

struct PictureOptions {
  int longest_px = 0;  // longest edge of the working size; 0 or more than the photo's: that of the photo
  uint64_t max_bytes = uint64_t{1} << 30;  // of pictures kept in memory; others are read again when needed
  bool ignore_masked = false;              // ignores pixels whose mask is 0
};

// Reads, undistorts and reduces the photos of a capture when they are needed. Thread-safe. The capture must
// stay unchanged and outlive the store.
class PictureStore {
 public:
  PictureStore(const Capture& capture, const PictureOptions& options);

  // Reads every photo once, in parallel. Errors are one line: a photo that is damaged, has another size than
  // its pose file states, is black, or has a mask of another size.
  Result<void> check_all();

  // Camera at the working size.
  const Camera& camera(size_t view) const { return cameras_[view]; }
  Result<std::shared_ptr<const CapturedPicture>> picture(size_t view);

  uint64_t bytes_in_memory() const;

 private:
  Result<CapturedPicture> read(size_t view) const;

  const Capture& capture_;
  PictureOptions options_;
  std::vector<Camera> cameras_;
  mutable std::mutex mutex_;  // guards all below
  std::vector<std::shared_ptr<const CapturedPicture>> kept_;
  std::list<size_t> recent_;  // kept views, the most recently used first
  uint64_t kept_bytes_ = 0;
};

}  // namespace livegs
