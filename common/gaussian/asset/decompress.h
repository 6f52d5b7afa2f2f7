// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

namespace livegs {

// One gzip member (RFC 1952) that fills its whole input. It is inflated in pieces, so memory follows the real
// content of the stream, not a size claimed in a header.
class GunzipStream {
 public:
  // Both arguments outlive the stream. `name` is the name of the file in errors.
  GunzipStream(Bytes compressed, std::string_view name);
  ~GunzipStream();
  GunzipStream(const GunzipStream&) = delete;
  GunzipStream& operator=(const GunzipStream&) = delete;

  // Returns the next `size` bytes. An error if the stream ends before them or is damaged.
  Result<std::vector<std::byte>> take(size_t size);

  // Reads the rest of the stream and discards it, except for its first `kept_bytes`, which are appended to
  // `kept`. Returns the length of the rest in bytes. Verifies the checksum and the length. An error if bytes
  // follow the stream in the input.
  Result<size_t> drain(std::vector<std::byte>* kept = nullptr, size_t kept_bytes = 0);

 private:
  struct State;
  Result<size_t> inflate_into(std::byte* out, size_t size);
  std::unique_ptr<State> state_;
  std::string name_;
};

std::vector<std::byte> gzip(Bytes bytes);

// Decompresses one zstd frame of exactly `size` bytes. The caller has bounded `size`.
Result<std::vector<std::byte>> zstd_decompress(Bytes frame, size_t size, std::string_view name);
std::vector<std::byte> zstd_compress(Bytes bytes);

}  // namespace livegs
