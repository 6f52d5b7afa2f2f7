// SPDX-License-Identifier: Apache-2.0
#include "splat/passes/device_kernels.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/passes/kernel_looks.h"

namespace livegs {
namespace {

constexpr size_t kUploadBlock = 4096;  // kernels

}  // namespace

Result<DeviceKernels> DeviceKernels::create(Backend& backend, const GaussianAsset& asset,
                                            std::vector<uint32_t> kept) {
  if (asset.size() > UINT32_MAX) {
    return Error{ErrorCode::TooLarge,
                 "asset: " + std::to_string(asset.size()) + " kernels exceed the limit of a device, 2^32"};
  }
  DeviceKernels kernels(backend);
  LIVEGS_ASSERT(kept.empty() || kept.back() < asset.size());
  kernels.asset_size_ = asset.size();
  kernels.size_ = static_cast<uint32_t>(kept.empty() ? asset.size() : kept.size());
  kernels.kept_ = std::move(kept);
  kernels.sh_degree_ = asset.sh_degree;
  kernels.sh_row_words_ = livegs::sh_row_words(asset);
  kernels.antialiased_ = asset.antialiased;
  for (uint32_t first = 0; first < kernels.size_; first += kMaxPartKernels) {
    const uint32_t count = std::min(kMaxPartKernels, kernels.size_ - first);
    if (auto made = kernels.make_part(asset, first, count); !made) return made.error();
  }
  return Result<DeviceKernels>(std::move(kernels));
}

size_t DeviceKernels::device_bytes() const {
  size_t bytes = 0;
  for (const Part& part : parts_) bytes += part.posed.bytes() + part.looks.bytes() + part.bands.bytes();
  return bytes;
}

Result<void> DeviceKernels::make_part(const GaussianAsset& asset, uint32_t first, uint32_t count) {
  Part& part = parts_.emplace_back();
  part.first = first;
  part.count = count;
  const size_t band_words = std::max<size_t>(1, size_t{count} * sh_row_words_);
  auto looks = Buffer::create(*backend_, count * sizeof(KernelLookRow));
  if (!looks) return looks.error();
  part.looks = *std::move(looks);
  auto bands = Buffer::create(*backend_, 4 * band_words);
  if (!bands) return bands.error();
  part.bands = *std::move(bands);

  std::vector<KernelLookRow> look_rows(count);
  std::vector<uint32_t> words(band_words, 0);
  parallel_for(count, kUploadBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t kernel = kernel_of(first + i);
      look_rows[i] = look_row(asset, kernel);
      pack_bands(asset, kernel, std::span(words).subspan(i * sh_row_words_, sh_row_words_));
    }
  });
  if (auto done = backend_->upload(part.looks.id(), std::as_bytes(std::span(look_rows))); !done) return done;
  return backend_->upload(part.bands.id(), std::as_bytes(std::span(words)));
}

Result<void> DeviceKernels::pose(const PosedKernels& kernels) {
  LIVEGS_ASSERT(kernels.positions_m.size() == asset_size_);
  std::vector<PosedKernelRow> rows;
  for (Part& part : parts_) {
    if (!part.posed) {
      auto made = Buffer::create(*backend_, part.count * sizeof(PosedKernelRow));
      if (!made) return made.error();
      part.posed = *std::move(made);
    }
    rows.resize(part.count);
    parallel_for(part.count, kUploadBlock, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const size_t kernel = kernel_of(part.first + i);
        const Eigen::Vector3f& x = kernels.positions_m[kernel];
        const Symmetric3f& s = kernels.covariances_m2[kernel];
        const Eigen::Quaternionf& q = kernels.world_from_asset[kernel];
        rows[i] = {x.x(), x.y(), x.z(), s[0], s[1], s[2], s[3], s[4], s[5], q.x(), q.y(), q.z(), q.w()};
      }
    });
    if (auto done = backend_->upload(part.posed.id(), std::as_bytes(std::span(rows))); !done) return done;
  }
  return {};
}

}  // namespace livegs
