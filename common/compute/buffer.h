// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"

namespace livegs {

// Owns one buffer of a backend, which outlives it. A moved-from or default one is empty.
class Buffer {
 public:
  Buffer() = default;
  static Result<Buffer> create(Backend& backend, size_t bytes);  // fails as Backend::create_buffer
  ~Buffer() { reset(); }
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  void reset();                        // destroys the buffer, if any
  BufferId id() const { return id_; }  // BufferId{} of an empty one
  size_t bytes() const { return bytes_; }
  explicit operator bool() const { return id_ != BufferId{}; }

 private:
  Backend* backend_ = nullptr;
  BufferId id_{};
  size_t bytes_ = 0;
};

}  // namespace livegs
