// SPDX-License-Identifier: Apache-2.0
#include "compute/buffer.h"

#include <string>
#include <utility>

namespace livegs {

Result<Buffer> Buffer::create(Backend& backend, size_t bytes) {
  auto made = backend.create_buffer(bytes);
  if (!made) return made.error();
  Buffer buffer;
  buffer.backend_ = &backend;
  buffer.id_ = *made;
  buffer.bytes_ = bytes;
  return Result<Buffer>(std::move(buffer));
}

Result<void> Buffer::reserve(Backend& backend, size_t bytes, const char* what) {
  if (bytes_ >= bytes) return {};
  reset();  // the old and the new one might not fit together
  auto made = create(backend, bytes);
  if (!made) return Error{made.error().code, std::string(what) + ": " + made.error().message};
  *this = *std::move(made);
  return {};
}

Buffer::Buffer(Buffer&& other) noexcept
    : backend_(std::exchange(other.backend_, nullptr)),
      id_(std::exchange(other.id_, BufferId{})),
      bytes_(std::exchange(other.bytes_, 0)) {}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  std::swap(backend_, other.backend_);
  std::swap(id_, other.id_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

void Buffer::reset() {
  if (*this) (void)backend_->destroy_buffer(id_);
  backend_ = nullptr;
  id_ = {};
  bytes_ = 0;
}

}  // namespace livegs
