// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "capture/capture.h"
#include "compute/backend.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "splat/image.h"
#include "train/kernel_parameters.h"
#include "train/train_options.h"

namespace livegs {

// Means over the held-out views, which are never trained on. SSIM is 0 to 1.
struct HeldOutScore {
  double psnr_db = 0, ssim = 0;
  size_t views = 0;
};

// Trains a splat from photos with poses (Kerbl et al. 2023) with a fixed limit of kernels (Kheradmand et al.
// 2024). The result is in the frame and unit of the pose file.
//
// The same capture and options give the same bits for any number of threads, also after a resume. One thread
// at a time may call a trainer; its work is spread over parallel_for. The capture must stay unchanged and
// outlive it.
class Trainer {
 public:
  // Reads every photo once. Errors are those of PictureStore::check_all, and a capture without a view to
  // train.
  static Result<Trainer> start(const Capture& capture, const TrainOptions& options);
  ~Trainer();
  Trainer(Trainer&&) noexcept;
  Trainer& operator=(Trainer&&) noexcept;

  // Pictures and gradients are blended on this device from now on. The same device gives the same bits again;
  // they differ from those of the CPU by rounding. If it fails, a warning is logged and the CPU continues.
  void use_device(std::unique_ptr<Backend> backend);

  size_t steps_done() const;
  bool done() const;
  // One step: draws one view and corrects all kernels. Fails if a photo can no longer be read.
  Result<void> step();

  const KernelParameters& kernels() const;
  GaussianAsset asset() const;
  double extent() const;       // of the scene, see robust_extent
  double recent_loss() const;  // mean over about the last hundred steps
  // Of a view, with the corrections so far. The size is that of the photos in training.
  Camera camera(size_t view) const;

  Result<HeldOutScore> score();
  // The photo of a view and the same view of the kernels next to it.
  Result<Image> compare(size_t view);

  // The whole state, for resume() of a trainer with the same capture and options. An error leaves the trainer
  // as it was.
  std::vector<std::byte> checkpoint() const;
  Result<void> resume(std::span<const std::byte> checkpoint);

 private:
  struct State;
  explicit Trainer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace livegs
