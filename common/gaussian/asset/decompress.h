// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

namespace livegs {

// One gzip member (RFC 1952) that fills its whole input, inflated piece by piece, so that memory follows what
// the stream really holds and not what somebody says it holds.
class GunzipStream {
 public:
  // Both outlive the stream. `name` is what errors call the file.
  GunzipStream(Bytes compressed, std::string_view name);
  ~GunzipStream();
  GunzipStream(const GunzipStream&) = delete;
  GunzipStream& operator=(const GunzipStream&) = delete;

  // The next `size` bytes; an error if the stream ends before, or is damaged.
  Result<std::vector<std::byte>> take(size_t size);

  // How many bytes are left to the end of the stream. They are thrown away; checksum and length are verified,
  // and nothing may follow in the input.
  Result<size_t> drain();

 private:
  struct State;
  Result<size_t> inflate_into(std::byte* out, size_t size);
  std::unique_ptr<State> state_;
  std::string name_;
};

std::vector<std::byte> gzip(Bytes bytes);

// One zstd frame that decodes to exactly `size` bytes. The caller has bounded `size`.
Result<std::vector<std::byte>> zstd_decompress(Bytes frame, size_t size, std::string_view name);
std::vector<std::byte> zstd_compress(Bytes bytes);

}  // namespace livegs
