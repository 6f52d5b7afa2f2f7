// SPDX-License-Identifier: Apache-2.0
#include "gaussian/stored_blocks.h"

#include <algorithm>
#include <cstring>

#include "gaussian/asset/bytes.h"
#include "gaussian/progressive/progressive_layout.h"
#include "gaussian/progressive/zstd_frame.h"

namespace livegs {
namespace {

using namespace progressive_layout;

// A zstd frame (RFC 8878, section 3.1.1): a single segment with its content size in eight bytes, no checksum,
// raw blocks.
constexpr uint32_t kZstdMagic = 0xfd2fb528;
constexpr uint8_t kFrameDescriptor = 0b1110'0000;
constexpr size_t kMaxRawBlock = 128u << 10;

void put(std::vector<std::byte>& out, uint64_t value, size_t width) {
  for (size_t i = 0; i < width; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}

Error damaged(const char* what) { return invalid_data(std::string("asset: ") + what); }

}  // namespace

Result<std::vector<std::byte>> store_blocks(Bytes progressive) {
  const bool edit = progressive.size() >= kEditHeadBytes &&
                    std::memcmp(progressive.data(), kEditMagic.data(), kEditMagic.size()) == 0;
  const size_t asset_head = edit ? kEditHeadBytes : kHeadBytes;
  if (progressive.size() < asset_head) return damaged("is shorter than its head");
  const Bytes begin = progressive.first(asset_head);
  std::vector<std::byte> out(begin.begin(), begin.end()), raw;
  for (Bytes left = progressive.subspan(asset_head); !left.empty();) {
    if (left.size() < kBlockHeadBytes) return damaged("ends within the head of a block");
    const auto size = load<uint32_t>(left, 0), kernels = load<uint32_t>(left, 4);
    if (left.size() - kBlockHeadBytes < size) return damaged("ends within a block");
    if (kernels == 0 || kernels > kMaxBlockKernels) return damaged("a block has a wrong number of kernels");
    const Bytes payload = left.subspan(kBlockHeadBytes, size);
    left = left.subspan(kBlockHeadBytes + size);
    raw.resize(max_raw_bytes(std::max(kKernelColumns, harmonic_columns(3)), kernels));
    const auto frame = zstd_frame_size(payload);
    if (!frame) return damaged("a block is not a zstd frame");
    const auto content = zstd_frame_content(payload.first(*frame), raw);
    if (!content) return damaged("a block is damaged");
    const size_t raw_size = *content;

    const size_t head = out.size();
    put(out, 0, kBlockHeadBytes);
    put(out, kZstdMagic, 4);
    put(out, kFrameDescriptor, 1);
    put(out, raw_size, 8);
    size_t at = 0;
    do {
      const size_t part = std::min(kMaxRawBlock, raw_size - at);
      const bool last = at + part == raw_size;
      put(out, (part << 3) | (last ? 1 : 0), 3);
      out.insert(out.end(), raw.begin() + static_cast<std::ptrdiff_t>(at),
                 raw.begin() + static_cast<std::ptrdiff_t>(at + part));
      at += part;
    } while (at < raw_size);
    const auto stored = static_cast<uint32_t>(out.size() - head - kBlockHeadBytes);
    std::memcpy(out.data() + head, &stored, sizeof stored);
    std::memcpy(out.data() + head + 4, &kernels, sizeof kernels);
  }
  return out;
}

}  // namespace livegs
