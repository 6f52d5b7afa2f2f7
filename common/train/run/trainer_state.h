// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/picture_store.h"
#include "train/loss/picture_loss.h"
#include "train/optimise/adam.h"
#include "train/optimise/camera_pose.h"
#include "train/render/trained_view.h"
#include "train/trainer.h"

namespace livegs {

struct Trainer::State {
  State(const Capture& one_capture, const TrainOptions& one_options, const PictureOptions& pictures_options)
      : capture(one_capture), options(one_options), pictures(one_capture, pictures_options) {}

  const Capture& capture;
  TrainOptions options;
  PictureStore pictures;
  std::vector<size_t> trained_views, held_out_views;
  double extent = 1;

  // Saved in a checkpoint.
  uint64_t step = 0;
  KernelParameters kernels;
  AdamState adam;
  std::vector<float> min_log_scales;  // by kernel, see TrainOptions::min_axis_px
  std::vector<float> errors;          // by kernel, see densify.h; halved at each growth
  std::vector<CameraPose> poses;      // by view
  double recent_loss = 0;

  // Buffers.
  TrainedView view;
  PictureLoss loss;
  PicturePlanes target, by_picture;
  std::vector<float> by_spread;  // by pixel; empty without the loss
  KernelParameters gradient, error_gradient;
  std::vector<size_t> order;  // views of the current epoch
  uint64_t order_epoch = ~uint64_t{0};

  int sh_degree() const;
  Camera camera_of(size_t index) const;
  size_t view_of_step();
  void update_min_scales();
  double spread_loss(std::span<const uint8_t> counts);
  double rate_factor() const;
  void add_errors(std::span<const uint8_t> counts);
  void place_held_out(size_t index, const CapturedPicture& photo, const TrainedViewOptions& view_options);
  Result<HeldOutScore> score();
};

// Writes a photo over a background as planes.
void planes_of(const CapturedPicture& picture, const Eigen::Vector3f& background, PicturePlanes& planes);

}  // namespace livegs
