// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <utility>

#include "gaussian/asset/establish_invariants.h"
#include "gaussian/progressive/progressive_layout.h"
#include "gaussian/progressive/zstd_frame.h"
#include "gaussian/progressive_asset.h"

namespace livegs {
namespace {

using namespace progressive_layout;

Error bad(const char* what) { return invalid_data(std::string("asset: ") + what); }

// Reads the columns of a block in order.
class Columns {
 public:
  Columns(Bytes raw, size_t count) : raw_(raw), words_(count) {}
  // False after a column was invalid.
  template <class Take>
  bool each(const Take& take) {
    good_ = good_ && decode_column(raw_, words_);
    for (size_t i = 0; good_ && i < words_.size(); ++i) take(i, words_[i]);
    return good_;
  }
  template <class Take>
  bool each_float(const Take& take) {
    return each([&](size_t i, uint32_t word) { take(i, std::bit_cast<float>(word)); });
  }
  bool at_end() const { return good_ && raw_.empty(); }

 private:
  Bytes raw_;
  std::vector<uint32_t> words_;
  bool good_ = true;
};

bool begins_with(Bytes bytes, const std::array<uint8_t, 8>& magic) {
  return std::equal(magic.begin(), magic.end(), bytes.begin(),
                    [](uint8_t a, std::byte b) { return a == std::to_integer<uint8_t>(b); });
}

}  // namespace

// The kernels listed in `order` by arrival index. Harmonics that have not arrived are zero.
GaussianAsset ProgressiveDecoder::gathered(std::span<const uint32_t> order, int degree) const {
  GaussianAsset to;
  to.sh_degree = degree;
  to.antialiased = asset_.antialiased;
  to.resize(order.size());
  const auto rest = static_cast<std::ptrdiff_t>(to.sh_rest_count());
  std::fill(to.sh_rest.begin(), to.sh_rest.end(), Eigen::Vector3f::Zero());
  for (size_t i = 0; i < order.size(); ++i) {
    const size_t at = order[i];
    to.positions[i] = asset_.positions[at];
    to.log_scales[i] = asset_.log_scales[at];
    to.rotations[i] = asset_.rotations[at];
    to.opacity_logits[i] = asset_.opacity_logits[at];
    to.sh_dc[i] = asset_.sh_dc[at];
    if (at < with_harmonics_)
      std::copy_n(harmonics_.begin() + static_cast<std::ptrdiff_t>(at) * rest, rest,
                  to.sh_rest.begin() + static_cast<std::ptrdiff_t>(i) * rest);
  }
  return to;
}

bool ProgressiveDecoder::complete() const {
  return !failed_ && has_head_ && indices_.size() == count_ && (degree_ == 0 || with_harmonics_ == count_) &&
         waiting_.empty();
}

Result<void> ProgressiveDecoder::take(std::span<const std::byte> bytes) {
  if (failed_) return *failed_;
  const auto fail = [&](Error error) -> Result<void> {
    failed_ = error;
    waiting_ = {};
    return error;
  };
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  Bytes left = waiting_;
  if (!has_head_) {
    if (left.size() < kHeadBytes) return {};
    const size_t head = begins_with(left, kEditMagic) ? kEditHeadBytes : kHeadBytes;
    if (left.size() < head) return {};
    if (auto taken = take_head(left.first(head)); !taken) return fail(taken.error());
    left = left.subspan(head);
  }
  const size_t harmonics = harmonic_columns(degree_);
  while (!left.empty()) {
    const bool brings_kernels = indices_.size() < count_;
    if (!brings_kernels && (degree_ == 0 || with_harmonics_ == count_))
      return fail(bad("bytes follow the last block"));
    if (left.size() < kBlockHeadBytes) break;
    const auto size = load<uint32_t>(left, 0), kernels = load<uint32_t>(left, 4);
    const bool brings_runs = indices_.size() < kept_;
    const size_t columns = brings_runs ? kRunColumns : brings_kernels ? kKernelColumns : harmonics;
    const size_t missing = (brings_runs ? kept_ : count_) - indices_.size();
    if (kernels == 0 || kernels > kMaxBlockKernels ||
        (brings_kernels ? kernels > missing : kernels != block_counts_[harmonic_blocks_])) {
      return fail(bad("a block has a wrong number of kernels"));
    }
    if (size < min_payload_bytes(columns, kernels) || size > max_payload_bytes(columns, kernels))
      return fail(bad("a block has a size that does not fit its kernels"));
    if (left.size() - kBlockHeadBytes < size) break;
    if (auto taken = take_block(left.subspan(kBlockHeadBytes, size), kernels); !taken)
      return fail(taken.error());
    left = left.subspan(kBlockHeadBytes + size);
  }
  waiting_.erase(waiting_.begin(), waiting_.end() - static_cast<std::ptrdiff_t>(left.size()));
  return {};
}

Result<void> ProgressiveDecoder::take_head(Bytes head) {
  const bool edit = begins_with(head, kEditMagic);
  if (!edit && !begins_with(head, kMagic))
    return bad("wrong magic number or version; use client and server of the same version");
  count_ = load<uint32_t>(head, 8);
  degree_ = static_cast<int>(byte_at(head, 12));
  const unsigned flags = byte_at(head, 13);
  if (count_ == 0 || degree_ > 3 || flags > kAntialiased || load<uint16_t>(head, 14) != 0)
    return bad("no kernels, or unknown harmonics or flags");
  if (uint64_t{count_} * sizeof(float) * (kFloatColumns + harmonic_columns(degree_)) > kMaxDecodedBytes)
    return bad("larger than 4 GiB");
  asset_.antialiased = flags != 0;
  if (edit) {
    kept_ = load<uint32_t>(head, kHeadBytes);
    if (!base_ || base_->sh_degree != degree_ || base_->antialiased != asset_.antialiased)
      return bad("an edit of another asset");
    if (kept_ == 0 || kept_ > std::min<size_t>(count_, base_->size()))
      return bad("an edit has a wrong number of kernels");
  }
  has_head_ = true;
  return {};
}

Result<void> ProgressiveDecoder::take_block(Bytes payload, uint32_t count) {
  const bool brings_kernels = indices_.size() < count_, brings_runs = indices_.size() < kept_;
  const auto frame = zstd_frame_size(payload);
  if (!frame) return bad("a block is not a zstd frame");
  const Bytes padding = payload.subspan(*frame);
  if (std::any_of(padding.begin(), padding.end(), [](std::byte byte) { return byte != std::byte{0}; }))
    return bad("bytes follow the zstd frame of a block");
  const size_t column_count = brings_runs      ? kRunColumns
                              : brings_kernels ? kKernelColumns
                                               : harmonic_columns(degree_);
  std::vector<std::byte> raw(max_raw_bytes(column_count, count));
  const auto size = zstd_frame_content(payload.first(*frame), raw);
  if (!size) return bad("a block is damaged");
  const Bytes columns = Bytes(raw).first(*size);
  if (brings_runs) return take_runs(columns, count) ? Result<void>() : bad("the runs of an edit are damaged");
  if (brings_kernels ? !take_kernels(columns, count) : !take_harmonics(columns, count))
    return bad("the columns of a block are damaged");
  ++blocks_;
  return {};
}

bool ProgressiveDecoder::take_runs(Bytes raw, size_t runs) {
  std::vector<uint32_t> words(kRunColumns * runs);
  Columns columns(raw, runs);
  for (size_t column = 0; column < kRunColumns; ++column)
    columns.each([&](size_t i, uint32_t word) { words[column * runs + i] = word; });
  if (!columns.at_end()) return false;
  const size_t rest = harmonic_columns(degree_) / 3;
  for (size_t run = 0; run < runs; ++run) {
    const uint32_t step = words[run];
    const int64_t half = step >> 1, length = words[2 * runs + run];
    const int64_t from = base_end_ + ((step & 1) != 0 ? -half - 1 : half);
    const int64_t to = asset_end_ + words[runs + run];
    base_end_ = from + length;
    asset_end_ = to + length;
    const size_t first = indices_.size(), count = static_cast<size_t>(length);
    if (count == 0 || from < 0 || base_end_ > static_cast<int64_t>(base_->size()) ||
        asset_end_ > static_cast<int64_t>(count_) || count > kept_ - first)
      return false;
    indices_.resize(first + count);
    asset_.resize(first + count);
    harmonics_.resize((first + count) * rest);
    for (size_t i = 0; i < count; ++i) {
      const size_t at = first + i, of = static_cast<size_t>(from) + i;
      indices_[at] = static_cast<uint32_t>(to) + static_cast<uint32_t>(i);
      asset_.positions[at] = base_->positions[of];
      asset_.log_scales[at] = base_->log_scales[of];
      asset_.rotations[at] = base_->rotations[of];
      asset_.opacity_logits[at] = base_->opacity_logits[of];
      asset_.sh_dc[at] = base_->sh_dc[of];
      for (size_t k = 0; k < rest; ++k) harmonics_[at * rest + k] = base_->sh_rest[of * rest + k];
    }
  }
  with_harmonics_ = degree_ > 0 ? indices_.size() : 0;
  if (indices_.size() == kept_) base_.reset();
  return true;
}

bool ProgressiveDecoder::take_kernels(Bytes raw, size_t count) {
  const size_t first = indices_.size();
  Columns columns(raw, count);
  indices_.resize(first + count);
  asset_.resize(first + count);
  uint64_t next = 0;
  bool in_range = true;
  columns.each([&](size_t i, uint32_t gap) {
    next += gap;
    in_range = in_range && next < count_;
    indices_[first + i] = static_cast<uint32_t>(next);
    ++next;
  });
  for (int k = 0; k < 3; ++k)
    columns.each_float([&](size_t i, float value) { asset_.positions[first + i][k] = value; });
  for (int k = 0; k < 3; ++k)
    columns.each_float([&](size_t i, float value) { asset_.log_scales[first + i][k] = value; });
  for (int k = 0; k < 4; ++k)
    columns.each_float([&](size_t i, float value) { asset_.rotations[first + i].coeffs()[k] = value; });
  columns.each_float([&](size_t i, float value) { asset_.opacity_logits[first + i] = value; });
  for (int k = 0; k < 3; ++k)
    columns.each_float([&](size_t i, float value) { asset_.sh_dc[first + i][k] = value; });
  block_counts_.push_back(static_cast<uint32_t>(count));
  return in_range && columns.at_end();
}

bool ProgressiveDecoder::take_harmonics(Bytes raw, size_t count) {
  const size_t rest = harmonic_columns(degree_) / 3, first = with_harmonics_ * rest;
  harmonics_.resize(first + count * rest);
  Columns columns(raw, count);
  for (size_t k = 0; k < rest; ++k) {
    for (int channel = 0; channel < 3; ++channel) {
      columns.each_float([&](size_t i, float value) { harmonics_[first + i * rest + k][channel] = value; });
    }
  }
  ++harmonic_blocks_;
  with_harmonics_ += count;
  return columns.at_end();
}

AssetPart ProgressiveDecoder::part() const {
  const auto rest = static_cast<std::ptrdiff_t>(harmonic_columns(degree_) / 3);
  const auto drawable = [&](uint32_t i) {
    if (!meets_invariants(asset_, i)) return false;
    if (i >= with_harmonics_) return true;
    const auto own = harmonics_.begin() + static_cast<std::ptrdiff_t>(i) * rest;
    return std::all_of(own, own + rest, [](const Eigen::Vector3f& one) { return one.allFinite(); });
  };
  std::vector<uint32_t> order;
  for (uint32_t i = 0; !failed_ && i < indices_.size(); ++i) {
    if (drawable(i)) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return indices_[a] < indices_[b]; });
  AssetPart part;
  part.asset = gathered(order, with_harmonics_ > 0 ? degree_ : 0);
  part.indices.reserve(order.size());
  for (const uint32_t i : order) part.indices.push_back(indices_[i]);
  return part;
}

std::optional<GaussianAsset> ProgressiveDecoder::whole() const {
  if (!complete()) return std::nullopt;
  constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> order(count_, kNone);
  for (uint32_t i = 0; i < count_; ++i) {
    if (std::exchange(order[indices_[i]], i) != kNone) return std::nullopt;
  }
  return gathered(order, degree_);
}

Result<GaussianAsset> decode_progressive(std::span<const std::byte> bytes) {
  ProgressiveDecoder decoder;
  if (auto taken = decoder.take(bytes); !taken) return taken.error();
  if (!decoder.complete()) return bad("truncated");
  auto whole = decoder.whole();
  if (!whole) return bad("a kernel is repeated");
  return std::move(*whole);
}

}  // namespace livegs
