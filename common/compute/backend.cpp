// SPDX-License-Identifier: Apache-2.0
#include "compute/backend.h"

#include <string>

namespace livegs {

Result<void> check_buffer_size(size_t bytes) {
  if (bytes == 0 || bytes % 4 != 0) {
    return invalid_argument("buffer: " + std::to_string(bytes) +
                            " bytes; request a multiple of 4, at least 4");
  }
  if (bytes > kMaxBufferBytes) {
    return Error{ErrorCode::TooLarge, "buffer: " + std::to_string(bytes) + " bytes exceed the limit of " +
                                          std::to_string(kMaxBufferBytes)};
  }
  return {};
}

Result<void> check_transfer(size_t bytes, size_t buffer_bytes) {
  if (bytes % 4 != 0 || bytes > buffer_bytes) {
    return invalid_argument("buffer transfer: " + std::to_string(bytes) +
                            " bytes; transfer a multiple of 4, at most the " + std::to_string(buffer_bytes) +
                            " bytes of the buffer");
  }
  return {};
}

Result<void> check_dispatch(const Pass& pass, std::span<const BufferId> buffers,
                            std::span<const std::byte> constants) {
  const std::string name = "pass " + std::string(pass.name) + ": ";
  if (pass.group_size == 0 || pass.group_size > kMaxPassGroupSize || pass.buffer_count == 0 ||
      pass.buffer_count > kMaxPassBuffers || pass.constants_bytes > kMaxPassConstantsBytes ||
      pass.constants_bytes % 4 != 0) {
    return invalid_argument(name + "group size, buffer count or constants exceed the limits of pass.h");
  }
  if (buffers.size() != pass.buffer_count) {
    return invalid_argument(name + std::to_string(buffers.size()) + " buffers instead of " +
                            std::to_string(pass.buffer_count));
  }
  if (constants.size() != pass.constants_bytes) {
    return invalid_argument(name + std::to_string(constants.size()) + " bytes of constants instead of " +
                            std::to_string(pass.constants_bytes));
  }
  for (size_t i = 0; i < buffers.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (buffers[i] == buffers[j])
        return invalid_argument(name + "a buffer is bound twice; bind different buffers");
    }
  }
  return {};
}

Error unknown_buffer(BufferId buffer) {
  return not_found("buffer " + std::to_string(static_cast<uint64_t>(buffer)) +
                   ": was destroyed or belongs to another backend");
}

}  // namespace livegs
