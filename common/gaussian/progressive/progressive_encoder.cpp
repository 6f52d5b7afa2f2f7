// SPDX-License-Identifier: Apache-2.0
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "core/assert.h"
#include "gaussian/opacity.h"
#include "gaussian/progressive/compare_assets.h"
#include "gaussian/progressive/progressive_layout.h"
#include "gaussian/progressive_asset.h"

namespace livegs {
namespace {

using namespace progressive_layout;

// zstd level. Higher levels take more than twice the time for a gain of about one percent.
constexpr int kZstdLevel = 3;

// Contribution of a kernel: opacity times mean projected area, up to a common factor.
double contribution(const GaussianAsset& asset, size_t kernel) {
  const Eigen::Array3d s = asset.log_scales[kernel].cast<double>().array().exp();
  return static_cast<double>(opacity_of_logit(asset.opacity_logits[kernel])) *
         (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]);
}

std::vector<uint32_t> by_contribution(const GaussianAsset& asset, std::vector<uint32_t> order) {
  std::vector<double> adds(asset.size());
  for (const uint32_t i : order) {
    adds[i] = contribution(asset, i);
    if (!(adds[i] >= 0)) adds[i] = 0;  // only for an asset that violates its invariants
  }
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return adds[a] > adds[b]; });
  return order;
}

// Writes one zstd frame. Every plane of a column starts a new zstd block with its own statistics.
class FrameWriter {
 public:
  FrameWriter() : context_(ZSTD_createCCtx(), &ZSTD_freeCCtx) {
    LIVEGS_ASSERT(context_ != nullptr);
    set(ZSTD_c_compressionLevel, kZstdLevel);
    set(ZSTD_c_checksumFlag, 1);
  }

  void begin(size_t max_raw) {
    frame_.resize(ZSTD_compressBound(max_raw) + 64 * 1024);
    size_ = 0;
  }
  void add(std::span<const uint32_t> words) {
    const ColumnBytes column = encode_column(words);
    size_t at = 0;
    for (const size_t end : column.ends) {
      compress(Bytes(column.bytes).subspan(at, end - at), ZSTD_e_flush);
      at = end;
    }
  }
  Bytes end() {
    compress({}, ZSTD_e_end);
    return Bytes(frame_).first(size_);
  }

 private:
  void set(ZSTD_cParameter parameter, int value) {
    LIVEGS_ASSERT(!ZSTD_isError(ZSTD_CCtx_setParameter(context_.get(), parameter, value)));
  }
  void compress(Bytes bytes, ZSTD_EndDirective how) {
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    ZSTD_outBuffer out{frame_.data(), frame_.size(), size_};
    LIVEGS_ASSERT(ZSTD_compressStream2(context_.get(), &out, &in, how) == 0);
    size_ = out.pos;
  }

  std::unique_ptr<ZSTD_CCtx, size_t (*)(ZSTD_CCtx*)> context_;
  std::vector<std::byte> frame_;
  size_t size_ = 0;
};

class Encoder {
 public:
  // `kernels`: those to encode, ascending.
  Encoder(const GaussianAsset& asset, std::vector<uint32_t> kernels)
      : asset_(asset), order_(by_contribution(asset, std::move(kernels))) {}

  void add_head(const std::array<uint8_t, 8>& magic) {
    for (const uint8_t byte : magic) append(out_, byte);
    append(out_, static_cast<uint32_t>(asset_.size()));
    append(out_, static_cast<uint8_t>(asset_.sh_degree));
    append(out_, static_cast<uint8_t>(asset_.antialiased ? kAntialiased : 0));
    append(out_, uint16_t{0});
  }

  void add_runs(std::span<const KeptRun> runs) {
    append(out_, static_cast<uint32_t>(asset_.size() - order_.size()));
    KeptRun before;
    for (size_t at = 0; at < runs.size(); at += kMaxBlockKernels) {
      const auto block = runs.subspan(at, std::min(kMaxBlockKernels, runs.size() - at));
      std::array<std::vector<uint32_t>, kRunColumns> columns;
      for (const KeptRun& run : block) {
        const auto step = static_cast<int32_t>(run.of_base - (before.of_base + before.length));
        columns[0].push_back((static_cast<uint32_t>(step) << 1) ^ static_cast<uint32_t>(step >> 31));
        columns[1].push_back(run.of_asset - (before.of_asset + before.length));
        columns[2].push_back(run.length);
        before = run;
      }
      frame_.begin(max_raw_bytes(kRunColumns, block.size()));
      for (const auto& column : columns) frame_.add(column);
      add_block(block.size(), kRunColumns);
    }
  }

  std::vector<std::byte> run() {
    std::vector<std::span<uint32_t>> blocks;
    for (size_t at = 0, size = kFirstBlockKernels; at < order_.size();
         size = std::min(2 * size, kMaxBlockKernels)) {
      const auto block = std::span(order_).subspan(at, std::min(size, order_.size() - at));
      // Kernels keep the order of the asset within a block: neighbours there are often neighbours in space,
      // and gaps between ascending indices are small.
      std::sort(block.begin(), block.end());
      blocks.push_back(block);
      at += block.size();
    }
    for (const auto block : blocks) add_kernels(block);
    if (asset_.sh_degree == 0) return std::move(out_);
    for (const auto block : blocks) add_harmonics(block);
    return std::move(out_);
  }

 private:
  template <class Value>
  void add_column(std::span<const uint32_t> block, const Value& value) {
    column_.resize(block.size());
    for (size_t i = 0; i < block.size(); ++i) column_[i] = std::bit_cast<uint32_t>(value(block[i]));
    frame_.add(column_);
  }

  void add_kernels(std::span<const uint32_t> block) {
    frame_.begin(max_raw_bytes(kKernelColumns, block.size()));
    column_.resize(block.size());
    for (size_t i = 0; i < block.size(); ++i) column_[i] = i == 0 ? block[0] : block[i] - block[i - 1] - 1;
    frame_.add(column_);
    for (int k = 0; k < 3; ++k) add_column(block, [&](uint32_t i) { return asset_.positions[i][k]; });
    for (int k = 0; k < 3; ++k) add_column(block, [&](uint32_t i) { return asset_.log_scales[i][k]; });
    for (int k = 0; k < 4; ++k)
      add_column(block, [&](uint32_t i) { return asset_.rotations[i].coeffs()[k]; });
    add_column(block, [&](uint32_t i) { return asset_.opacity_logits[i]; });
    for (int k = 0; k < 3; ++k) add_column(block, [&](uint32_t i) { return asset_.sh_dc[i][k]; });
    add_block(block.size(), kKernelColumns);
  }

  void add_harmonics(std::span<const uint32_t> block) {
    const size_t rest = asset_.sh_rest_count();
    frame_.begin(max_raw_bytes(3 * rest, block.size()));
    for (size_t k = 0; k < rest; ++k) {
      for (int channel = 0; channel < 3; ++channel)
        add_column(block, [&](uint32_t i) { return asset_.sh_rest[i * rest + k][channel]; });
    }
    add_block(block.size(), 3 * rest);
  }

  void add_block(size_t kernels, size_t columns) {
    const Bytes frame = frame_.end();
    const size_t payload = std::max(frame.size(), min_payload_bytes(columns, kernels));
    append(out_, static_cast<uint32_t>(payload));
    append(out_, static_cast<uint32_t>(kernels));
    out_.insert(out_.end(), frame.begin(), frame.end());
    out_.resize(out_.size() + payload - frame.size());
  }

  const GaussianAsset& asset_;
  std::vector<uint32_t> order_, column_;
  FrameWriter frame_;
  std::vector<std::byte> out_;
};

}  // namespace

std::vector<std::byte> encode_progressive(const GaussianAsset& asset) {
  LIVEGS_ASSERT(asset.size() > 0);
  std::vector<uint32_t> all(asset.size());
  std::iota(all.begin(), all.end(), 0u);
  Encoder encoder(asset, std::move(all));
  encoder.add_head(kMagic);
  return encoder.run();
}

std::optional<std::vector<std::byte>> encode_edit(const GaussianAsset& base, const GaussianAsset& asset) {
  LIVEGS_ASSERT(asset.size() > 0);
  if (base.sh_degree != asset.sh_degree || base.antialiased != asset.antialiased) return std::nullopt;
  auto [runs, added] = compare_assets(base, asset);
  if (runs.empty()) return std::nullopt;
  Encoder encoder(asset, std::move(added));
  encoder.add_head(kEditMagic);
  encoder.add_runs(runs);
  return encoder.run();
}

}  // namespace livegs
