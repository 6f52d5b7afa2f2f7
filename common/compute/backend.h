// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "compute/pass.h"
#include "core/result.h"

namespace livegs {

// A buffer of one backend. Never 0 and never used again once its buffer is destroyed.
enum class BufferId : uint64_t {};

// The most one buffer may hold on any backend; a device may hold less (lavapipe: 128 MiB a storage buffer).
inline constexpr size_t kMaxBufferBytes = size_t{1} << 31;

// Where passes run. Calls take effect in the order they are made: a dispatch sees what was uploaded and
// dispatched before it. One thread at a time uses a backend. Every call fails on an unknown BufferId
// (NotFound) and on sizes that do not fit (InvalidArgument, TooLarge) and then changes nothing; a lost device
// is Unavailable.
class Backend {
 public:
  virtual ~Backend() = default;

  // bytes: 1..kMaxBufferBytes, a multiple of 4. The contents are unspecified until they are written.
  virtual Result<BufferId> create_buffer(size_t bytes) = 0;
  // What one buffer may hold here: what passes and draws of this device can bind.
  virtual size_t max_buffer_bytes() const { return kMaxBufferBytes; }
  virtual Result<void> destroy_buffer(BufferId buffer) = 0;

  // Writes the front of a buffer; a multiple of 4 bytes, no more than it holds. `bytes` may be reused at
  // once.
  virtual Result<void> upload(BufferId buffer, std::span<const std::byte> bytes) = 0;

  // Runs `pass` for items [0, count), soon: at the latest when its result is read. One buffer for each
  // binding, all different; constants as long as the pass says. count 0 does nothing.
  virtual Result<void> dispatch(const Pass& pass, std::span<const BufferId> buffers,
                                std::span<const std::byte> constants, uint32_t count) = 0;

  // Returns when everything dispatched is done.
  virtual Result<void> submit() = 0;

  // Submits, then reads the front of a buffer; a multiple of 4 bytes, no more than it holds.
  virtual Result<void> read(BufferId buffer, std::span<std::byte> bytes) = 0;
};

// Inside the room: what both backends check alike.
Result<void> check_buffer_size(size_t bytes);
Result<void> check_transfer(size_t bytes, size_t buffer_bytes);
Result<void> check_dispatch(const Pass& pass, std::span<const BufferId> buffers,
                            std::span<const std::byte> constants);
Error unknown_buffer(BufferId buffer);

}  // namespace livegs
