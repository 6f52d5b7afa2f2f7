// SPDX-License-Identifier: Apache-2.0
// Streamed assets and edits (proto/asset_format.md). Bits 1 and 2 of the first byte are the degree of the
// base. Even first byte: the rest is the received data, decoded in pieces. Odd first byte: the rest is a head
// and the columns of blocks. The target adds the zstd frames, which otherwise stop most damaged data before
// the decoders behind them.
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>

#include "fuzz/fuzz_target.h"
#include "gaussian/progressive/progressive_layout.h"
#include "gaussian/progressive_asset.h"

namespace livegs::fuzz::asset_fuzz {
namespace {

using namespace progressive_layout;

void append(Bytes& to, std::span<const std::byte> bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

size_t head_bytes(std::span<const std::byte> sent) {
  const bool edit = sent.size() >= kEditMagic.size() &&
                    std::equal(kEditMagic.begin(), kEditMagic.end(), sent.begin(),
                               [](uint8_t a, std::byte b) { return std::byte{a} == b; });
  return edit ? kEditHeadBytes : kHeadBytes;
}

// The first part is the head. Each other part is a u32 kernel count and the columns of a block.
Bytes framed(std::span<const std::byte> input) {
  Bytes sent;
  bool head = true;
  for (const auto part : parts_of(input)) {
    if (std::exchange(head, false)) {
      append(sent, part);
      sent.resize(head_bytes(sent));
      continue;
    }
    ByteReader in(part);
    const auto kernels = in.read<uint32_t>();
    const auto columns = part.subspan(std::min<size_t>(4, part.size()));
    Bytes frame(ZSTD_compressBound(columns.size()));
    frame.resize(ZSTD_compress(frame.data(), frame.size(), columns.data(), columns.size(), 1));
    frame.resize(
        std::max(frame.size(), min_payload_bytes(3 * 15, std::min<size_t>(kernels, kMaxBlockKernels))));
    ByteWriter block;
    block.write(static_cast<uint32_t>(frame.size()));
    block.write(kernels);
    append(sent, std::move(block).take());
    append(sent, frame);
  }
  return sent;
}

void use(std::span<const std::byte> sent, const std::shared_ptr<const GaussianAsset>& base) {
  ProgressiveDecoder decoder(base);
  for (size_t at = 0; at < sent.size();) {
    const size_t length = std::min<size_t>(4096, sent.size() - at);
    const bool taken = decoder.take(sent.subspan(at, length)).has_value();
    at += length;
    check(decoder.arrived() <= decoder.kernel_count() && decoder.arrived_harmonics() <= decoder.arrived(),
          "arrived kernels and harmonics are at most all kernels");
    if (!taken) {
      check(!decoder.complete() && !decoder.take({}), "the decoder stays failed after an error");
      return;
    }
  }
  const AssetPart part = decoder.part();
  check(part.indices.size() == part.asset.size(), "each kernel has an index");
  for (size_t i = 0; i < part.asset.size(); ++i) {
    check(part.asset.positions[i].allFinite() && part.asset.log_scales[i].allFinite() &&
              part.asset.sh_dc[i].allFinite(),
          "drawn values are finite");
    check(part.indices[i] < decoder.kernel_count() && (i == 0 || part.indices[i] >= part.indices[i - 1]),
          "indices are in range and ascend");
  }
  if (const auto whole = decoder.whole())
    check(whole->size() == decoder.kernel_count(), "a whole asset has all kernels");
}

GaussianAsset made_up(size_t count, int degree) {
  GaussianAsset asset;
  asset.sh_degree = degree;
  asset.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const auto number = static_cast<float>(i);
    asset.positions[i] = {0.01f * number, static_cast<float>(i % 7), -0.5f * number};
    asset.log_scales[i] = {-3.0f, -4.0f - 0.1f * static_cast<float>(i % 3), -5.0f};
    asset.rotations[i] = Eigen::Quaternionf(1, 0.1f * static_cast<float>(i % 5), 0, 0).normalized();
    asset.opacity_logits[i] = static_cast<float>(i % 11) - 4.0f;
    asset.sh_dc[i] = {0.1f, 0.2f, static_cast<float>(i % 2)};
  }
  for (size_t i = 0; i < asset.sh_rest.size(); ++i)
    asset.sh_rest[i] = {0.0f, 0.01f * static_cast<float>(i % 13), 0.0f};
  return asset;
}

Bytes columns_of(std::span<const std::byte> sent) {
  const size_t begin = head_bytes(sent);
  std::vector<Bytes> parts{Bytes(sent.begin(), sent.begin() + static_cast<std::ptrdiff_t>(begin))};
  for (size_t at = begin; at < sent.size();) {
    ByteReader head(sent.subspan(at, kBlockHeadBytes));
    const auto size = head.read<uint32_t>(), kernels = head.read<uint32_t>();
    ByteWriter part;
    part.write(kernels);
    Bytes block = std::move(part).take(), columns(max_raw_bytes(3 * 15, kernels));
    const auto frame = sent.subspan(at + kBlockHeadBytes, size);
    columns.resize(ZSTD_decompress(columns.data(), columns.size(), frame.data(),
                                   ZSTD_findFrameCompressedSize(frame.data(), frame.size())));
    append(block, columns);
    parts.push_back(std::move(block));
    at += kBlockHeadBytes + size;
  }
  return joined(parts);
}

// The base of edits, by degree.
const std::shared_ptr<const GaussianAsset>& base_of(size_t degree) {
  static const std::array<std::shared_ptr<const GaussianAsset>, 4> all = [] {
    std::array<std::shared_ptr<const GaussianAsset>, 4> made;
    for (int i = 0; i < 4; ++i)
      made[static_cast<size_t>(i)] = std::make_shared<GaussianAsset>(made_up(50, i));
    return made;
  }();
  return all[degree];
}

void add_seeds(const Bytes& sent, int degree, std::vector<Bytes>& seeds) {
  const auto bits = static_cast<uint8_t>(degree << 1);
  Bytes raw{std::byte{bits}};
  append(raw, sent);
  seeds.push_back(std::move(raw));
  if (sent.size() > 16'000) return;
  Bytes columns{static_cast<std::byte>(bits | 1)};
  append(columns, columns_of(sent));
  seeds.push_back(std::move(columns));
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  if (input.empty()) return;
  const auto first = std::to_integer<uint8_t>(input[0]);
  const auto& base = base_of((first >> 1) & 3u);
  if ((first & 1) != 0)
    use(framed(input.subspan(1)), base);
  else
    use(input.subspan(1), base);
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (const auto& [count, degree] : {std::pair<size_t, int>{1, 0}, {30, 0}, {40, 1}, {25, 3}, {1100, 0}})
    add_seeds(encode_progressive(made_up(count, degree)), degree, seeds);
  for (const int degree : {0, 1, 3}) {
    for (const size_t count : {30, 60})
      add_seeds(*encode_edit(*base_of(static_cast<size_t>(degree)), made_up(count, degree)), degree, seeds);
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"asset", look_at, seeds});

}  // namespace livegs::fuzz::asset_fuzz
