// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>

#include "compute/backend.h"

namespace livegs {

// Runs the CPU functions on the threads of parallel_for, in fixed blocks: the same bits for any thread count.
// A dispatch is complete when the call returns.
class CpuBackend final : public Backend {
 public:
  Result<BufferId> create_buffer(size_t bytes) override;
  Result<void> destroy_buffer(BufferId buffer) override;
  Result<void> upload(BufferId buffer, std::span<const std::byte> bytes) override;
  Result<void> dispatch(const Pass& pass, std::span<const BufferId> buffers,
                        std::span<const std::byte> constants, uint32_t count) override;
  Result<void> submit() override { return {}; }
  Result<void> read(BufferId buffer, std::span<std::byte> bytes) override;

 private:
  struct Buffer {
    std::unique_ptr<std::byte[]> memory;  // aligned to 16 by operator new
    size_t bytes = 0;
  };

  std::map<BufferId, Buffer> buffers_;
  uint64_t last_id_ = 0;
};

}  // namespace livegs
