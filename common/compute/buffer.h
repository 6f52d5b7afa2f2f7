// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"

namespace livegs {

// Owns one buffer of a backend. The backend must outlive it. A moved-from or default Buffer is empty.
class Buffer {
 public:
  Buffer() = default;
  static Result<Buffer> create(Backend& backend, size_t bytes);  // errors: as Backend::create_buffer
  ~Buffer() { reset(); }
  Buffer(Buffer&& other) noexcept;
  Buffer& operator=(Buffer&& other) noexcept;

  // Makes the buffer at least this large, a multiple of 4. A buffer that grows loses its content, also if it
  // fails. Errors: as Backend::create_buffer, with `what` in front.
  Result<void> reserve(Backend& backend, size_t bytes, const char* what);

  void reset();                        // destroys the buffer, if any
  BufferId id() const { return id_; }  // BufferId{} if empty
  size_t bytes() const { return bytes_; }
  explicit operator bool() const { return id_ != BufferId{}; }

 private:
  Backend* backend_ = nullptr;
  BufferId id_{};
  size_t bytes_ = 0;
};

}  // namespace livegs
