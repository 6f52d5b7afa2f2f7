// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "compute/pass.h"
#include "core/result.h"

namespace livegs {

// A buffer of one backend. Ids are never 0 and are not reused after the buffer is destroyed.
enum class BufferId : uint64_t {};

// Maximum size of a buffer on any backend, bytes. A device may have a lower limit (lavapipe: 128 MiB per
// storage buffer).
inline constexpr size_t kMaxBufferBytes = size_t{1} << 31;

// Executes passes. Calls take effect in order: a dispatch sees all earlier uploads and dispatches. A backend
// is used by one thread at a time. Calls with an unknown BufferId (NotFound) or a wrong size
// (InvalidArgument, TooLarge) fail without effect. A lost device gives Unavailable.
class Backend {
 public:
  virtual ~Backend() = default;

  // `bytes`: 1..kMaxBufferBytes, a multiple of 4. The contents are undefined until written.
  virtual Result<BufferId> create_buffer(size_t bytes) = 0;
  // Maximum buffer size on this device, bytes: the limit of bindings in passes and draws.
  virtual size_t max_buffer_bytes() const { return kMaxBufferBytes; }
  virtual Result<void> destroy_buffer(BufferId buffer) = 0;

  // Writes to the start of a buffer: a multiple of 4 bytes, at most its size. `bytes` may be reused after the
  // call.
  virtual Result<void> upload(BufferId buffer, std::span<const std::byte> bytes) = 0;

  // Runs `pass` for items [0, count), at the latest when its result is read. Requires one buffer per binding,
  // all different, and constants of the size declared by the pass. count 0 has no effect.
  virtual Result<void> dispatch(const Pass& pass, std::span<const BufferId> buffers,
                                std::span<const std::byte> constants, uint32_t count) = 0;

  // Waits until everything dispatched has completed.
  virtual Result<void> submit() = 0;

  // Submits, then reads from the start of a buffer: a multiple of 4 bytes, at most its size.
  virtual Result<void> read(BufferId buffer, std::span<std::byte> bytes) = 0;
};

// Internal to this room: checks shared by both backends.
Result<void> check_buffer_size(size_t bytes);
Result<void> check_transfer(size_t bytes, size_t buffer_bytes);
Result<void> check_dispatch(const Pass& pass, std::span<const BufferId> buffers,
                            std::span<const std::byte> constants);
Error unknown_buffer(BufferId buffer);

}  // namespace livegs
