// SPDX-License-Identifier: Apache-2.0
#include "compute/cpu_backend.h"

#include <array>
#include <cstring>
#include <new>
#include <string>

#include "core/parallel_for.h"

namespace livegs {

namespace {

// Items per block: tens of microseconds of a light pass, far above the scheduling cost of a block.
constexpr size_t kBlock = 2048;
static_assert(kBlock % kMaxPassGroupSize == 0);

static_assert(__STDCPP_DEFAULT_NEW_ALIGNMENT__ >= 16);

}  // namespace

Result<BufferId> CpuBackend::create_buffer(size_t bytes) {
  if (auto checked = check_buffer_size(bytes); !checked) return checked.error();
  std::unique_ptr<std::byte[]> memory(new (std::nothrow) std::byte[bytes]);
  if (!memory)
    return Error{ErrorCode::TooLarge,
                 "buffer: " + std::to_string(bytes) + " bytes exceed the free memory; load fewer kernels"};
  const BufferId id{++last_id_};
  buffers_[id] = {std::move(memory), bytes};
  return id;
}

Result<void> CpuBackend::destroy_buffer(BufferId buffer) {
  if (buffers_.erase(buffer) == 0) return unknown_buffer(buffer);
  return {};
}

Result<void> CpuBackend::upload(BufferId buffer, std::span<const std::byte> bytes) {
  const auto found = buffers_.find(buffer);
  if (found == buffers_.end()) return unknown_buffer(buffer);
  if (auto checked = check_transfer(bytes.size(), found->second.bytes); !checked) return checked;
  if (!bytes.empty()) std::memcpy(found->second.memory.get(), bytes.data(), bytes.size());
  return {};
}

Result<void> CpuBackend::dispatch(const Pass& pass, std::span<const BufferId> buffers,
                                  std::span<const std::byte> constants, uint32_t count) {
  if (auto checked = check_dispatch(pass, buffers, constants); !checked) return checked;
  std::array<std::span<std::byte>, kMaxPassBuffers> bound;
  for (size_t i = 0; i < buffers.size(); ++i) {
    const auto found = buffers_.find(buffers[i]);
    if (found == buffers_.end()) return unknown_buffer(buffers[i]);
    bound[i] = {found->second.memory.get(), found->second.bytes};
  }
  const PassArguments arguments{std::span(bound).first(buffers.size()), constants};
  parallel_for(count, kBlock, [&](size_t begin, size_t end) { pass.run(arguments, begin, end); });
  return {};
}

Result<void> CpuBackend::read(BufferId buffer, std::span<std::byte> bytes) {
  const auto found = buffers_.find(buffer);
  if (found == buffers_.end()) return unknown_buffer(buffer);
  if (auto checked = check_transfer(bytes.size(), found->second.bytes); !checked) return checked;
  if (!bytes.empty()) std::memcpy(bytes.data(), found->second.memory.get(), bytes.size());
  return {};
}

}  // namespace livegs
