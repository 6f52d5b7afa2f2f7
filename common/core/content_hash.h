// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace livegs {

// Lower-case hexadecimal digits, two per byte.
std::string hexadecimal(std::span<const std::byte> bytes);

// SHA-256 of the bytes as 64 lower-case hexadecimal digits. Assets are cached and compared by this name.
std::string content_hash(std::span<const std::byte> bytes);

// content_hash() of bytes that arrive in pieces.
class ContentHasher {
 public:
  ContentHasher();
  void add(std::span<const std::byte> piece);
  std::string hash();  // of all pieces; once

 private:
  struct Free {
    void operator()(void* context) const;
  };
  std::unique_ptr<void, Free> context_;
};

}  // namespace livegs
