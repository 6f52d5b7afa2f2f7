// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compute/buffer.h"
#include "gaussian/posed_kernels.h"

namespace livegs {

// The kernels of one asset on a backend. They are split into parts, so that no buffer exceeds the binding
// limit of a device (lavapipe: 128 MiB, or 1.4 million kernels with three bands). Takes 16 bytes per kernel,
// up to 92 for its bands, and 52 if the host computes the poses.
class DeviceKernels {
 public:
  // `backend` must outlive the kernels. `kept` lists the used kernels of the asset, ascending; empty: all.
  static Result<DeviceKernels> create(Backend& backend, const GaussianAsset& asset,
                                      std::vector<uint32_t> kept = {});

  // Uploads the poses of all kernels of the asset, including those that are not kept. For kernels that no
  // pass skins.
  Result<void> pose(const PosedKernels& kernels);

  // Input of project_splats for kernels [first, first + count). `posed` is empty before pose().
  struct Part {
    uint32_t first = 0, count = 0;
    Buffer posed, looks, bands;
  };
  const std::vector<Part>& parts() const { return parts_; }

  uint32_t size() const { return size_; }  // kernels kept
  int sh_degree() const { return sh_degree_; }
  uint32_t sh_row_words() const { return sh_row_words_; }
  bool antialiased() const { return antialiased_; }
  size_t device_bytes() const;

  static constexpr uint32_t kMaxPartKernels = uint32_t{1} << 20;

 private:
  explicit DeviceKernels(Backend& backend) : backend_(&backend) {}
  Result<void> make_part(const GaussianAsset& asset, uint32_t first, uint32_t count);

  Backend* backend_;
  std::vector<Part> parts_;
  size_t kernel_of(size_t place) const { return kept_.empty() ? place : kept_[place]; }

  std::vector<uint32_t> kept_;
  size_t asset_size_ = 0;
  uint32_t size_ = 0;
  int sh_degree_ = 0;
  uint32_t sh_row_words_ = 0;
  bool antialiased_ = false;
};

}  // namespace livegs
