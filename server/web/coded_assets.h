// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "web/content_coding.h"

namespace livegs {

// Memory for compressed assets, bytes. An asset that does not fit is compressed for each fetch.
inline constexpr size_t kMaxKeptAssets = 256u << 20;

// Assets as browsers receive them (gaussian/stored_blocks.h), compressed once. Used by one thread.
class CodedAssets {
 public:
  struct Coded {
    std::shared_ptr<const std::vector<std::byte>> bytes;
    uint64_t total = 0;  // bytes of the whole stored form
  };
  // The asset or edit `name`, whose transfer form is `progressive`, from byte `from` of its stored form on.
  Result<Coded> get(const std::string& name, std::span<const std::byte> progressive, uint64_t from,
                    ContentCoding coding);

 private:
  struct Kept {
    std::string key;
    Coded coded;
  };
  std::list<Kept> kept_;  // most recent first
  size_t kept_bytes_ = 0;
};

}  // namespace livegs
