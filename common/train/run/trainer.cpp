// SPDX-License-Identifier: Apache-2.0
// Kerbl et al. 2023, 3D Gaussian Splatting; Kheradmand et al. 2024, 3D Gaussian Splatting as MCMC.
#include "train/trainer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel_for.h"
#include "core/text/format_text.h"
#include "train/optimise/densify.h"
#include "train/optimise/random_number.h"
#include "train/run/initial_kernels.h"
#include "train/run/scene_extent.h"
#include "train/run/trainer_state.h"

namespace livegs {
namespace {

// Near limit of the cameras as a share of the extent.
constexpr double kNearShare = 0.02;
// Weight of the difference of alpha for photos with transparent parts; without it the background grows into
// them.
constexpr float kAlphaWeight = 0.1f;
// Steps between updates of the smallest axes, at most.
constexpr uint64_t kMinScaleInterval = 100;
constexpr double kRecentShare = 0.01;  // weight of a step in the recent loss
// Fit of the pose of a held-out photo: number of steps, step in rad (positions: times the extent) at the
// start, and the share of it at the end.
constexpr int kPlacingSteps = 12;
constexpr double kPlacingRate = 3e-4, kLastPlacingShare = 0.1;
constexpr uint64_t kOrderStream = 2000, kBackgroundStream = 2001;
constexpr size_t kKernelBlock = 1024, kRowBlock = 16, kPlaneBlock = 16384;
// Steps between views whose errors are measured for the densification. Smaller: slower steps. Larger: growth
// follows fewer views.
constexpr uint64_t kErrorInterval = 3;

uint64_t densify_interval(size_t steps) { return std::max<uint64_t>(10, steps / 100); }

Result<void> check_options(const TrainOptions& options) {
  if (options.steps < 1 || options.steps > kMaxTrainSteps)
    return invalid_argument("training: steps must be from 1 to 1000000");
  if (options.max_kernels < 100 || options.max_kernels > kMaxTrainedKernels)
    return invalid_argument("training: the limit of kernels must be from 100 to 10000000");
  if (options.longest_px != 0 && (options.longest_px < 32 || options.longest_px > 16384))
    return invalid_argument("training: the longest edge must be from 32 to 16384 px");
  if (!(options.spread_weight >= 0) || !(options.spread_edge > 0) || !(options.spread_error > 0))
    return invalid_argument(
        "training: the spread is out of range; use a weight of 0 or more, and an edge and an error above 0");
  return {};
}

}  // namespace

void planes_of(const CapturedPicture& picture, const Eigen::Vector3f& background, PicturePlanes& planes) {
  planes.resize(picture.width, picture.height);
  parallel_for(planes.pixels(), kPlaneBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint8_t* rgba = &picture.rgba[4 * i];
      const float alpha = static_cast<float>(rgba[3]) / 255.0f, through = 1 - alpha;
      planes.red[i] = static_cast<float>(rgba[0]) / 255.0f + through * background.x();
      planes.green[i] = static_cast<float>(rgba[1]) / 255.0f + through * background.y();
      planes.blue[i] = static_cast<float>(rgba[2]) / 255.0f + through * background.z();
      planes.alpha[i] = alpha;
    }
  });
}

int Trainer::State::sh_degree() const {
  const double phase =
      static_cast<double>(step) / (options.harmonics_interval * static_cast<double>(options.steps));
  return std::min(3, static_cast<int>(phase));
}

Camera Trainer::State::camera_of(size_t index) const {
  Camera camera = pictures.camera(index);
  camera.world_from_camera = poses[index].world_from_camera;
  camera.near_m = kNearShare * extent;
  return camera;
}

// The loss of the spread of depths in the last view, and its derivative by each pixel in by_spread.
double Trainer::State::spread_loss(std::span<const uint8_t> counts) {
  const auto factor =
      static_cast<float>(options.spread_weight / (extent * static_cast<double>(target.pixels())));
  const auto over_edge = static_cast<float>(1 / (options.spread_edge * options.spread_edge));
  const auto over_error = static_cast<float>(1 / (options.spread_error * options.spread_error));
  const int width = target.width, height = target.height;
  by_spread.resize(target.pixels());
  parallel_for(static_cast<size_t>(height), kRowBlock, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      const int up = std::max(y - 1, 0), down = std::min(y + 1, height - 1);
      for (int x = 0; x < width; ++x) {
        const int left = std::max(x - 1, 0), right = std::min(x + 1, width - 1);
        const size_t i = static_cast<size_t>(y) * width + x;
        float change = 0, error = 0;
        for (const auto plane : {&PicturePlanes::red, &PicturePlanes::green, &PicturePlanes::blue}) {
          const std::vector<float>& photo = target.*plane;
          const auto at = [&](int px, int py) { return photo[static_cast<size_t>(py) * width + px]; };
          const float across = 0.5f * (at(right, y) - at(left, y)), along = 0.5f * (at(x, down) - at(x, up));
          const float off = (view.picture().*plane)[i] - photo[i];
          change += across * across + along * along;
          error += off * off;
        }
        const float seen = counts.empty() || counts[i] != 0 ? target.alpha[i] : 0.0f;
        by_spread[i] = seen * factor / (1 + change * over_edge + error * over_error);
      }
    }
  });
  double sum = 0;
  for (size_t i = 0; i < by_spread.size(); ++i) sum += double{by_spread[i]} * view.spreads()[i];
  return sum;
}

// Every view once in each epoch, in an order that depends on the seed and the epoch only.
size_t Trainer::State::view_of_step() {
  const uint64_t epoch = step / trained_views.size();
  if (epoch != order_epoch) {
    order = trained_views;
    for (size_t i = order.size(); i > 1; --i) {
      const uint64_t pick = random_bits(options.seed, kOrderStream, epoch << 20 | i) % i;
      std::swap(order[i - 1], order[pick]);
    }
    order_epoch = epoch;
  }
  return order[step % order.size()];
}

void Trainer::State::update_min_scales() {
  min_log_scales.resize(kernels.size());
  std::vector<Projection> projections;
  for (size_t index : trained_views) projections.emplace_back(camera_of(index));
  parallel_for(kernels.size(), kKernelBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const Eigen::Vector3d position =
          Eigen::Map<const Eigen::Vector3f>(kernels.row(Family::Position, k)).cast<double>();
      double nearest = std::numeric_limits<double>::infinity();
      for (const Projection& one : projections) {
        const Eigen::Vector3d t = one.image_from_world * (position - one.position_m);
        if (!(t.z() > one.near_m)) continue;
        const double slope_x = t.x() / t.z(), slope_y = t.y() / t.z();
        if (slope_x < one.min_slope_x || slope_x > one.max_slope_x || slope_y < one.min_slope_y ||
            slope_y > one.max_slope_y)
          continue;
        nearest = std::min(nearest, t.z() / std::max(one.focal_x_px, one.focal_y_px));
      }
      min_log_scales[k] = std::isfinite(nearest) ? static_cast<float>(std::log(options.min_axis_px * nearest))
                                                 : -std::numeric_limits<float>::infinity();
    }
  });
}

Trainer::Trainer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Trainer::~Trainer() = default;
Trainer::Trainer(Trainer&&) noexcept = default;
Trainer& Trainer::operator=(Trainer&&) noexcept = default;

Result<Trainer> Trainer::start(const Capture& capture, const TrainOptions& options) {
  if (auto good = check_options(options); !good) return good.error();
  auto state = std::make_unique<State>(
      capture, options, PictureOptions{options.longest_px, options.max_picture_bytes, options.ignore_masked});
  for (size_t i = 0; i < capture.views.size(); ++i)
    (capture.views[i].held_out ? state->held_out_views : state->trained_views).push_back(i);
  if (state->trained_views.size() < 2) {
    return invalid_data(format_text("%s: has %zu photos to train on; give two or more",
                                    capture.folder.c_str(), state->trained_views.size()));
  }
  if (auto checked = state->pictures.check_all(); !checked) return checked.error();
  std::vector<CapturedView> views;
  for (size_t i : state->trained_views) views.push_back(capture.views[i]);
  state->extent = robust_extent(views);
  state->poses.resize(capture.views.size());
  for (size_t i = 0; i < capture.views.size(); ++i)
    state->poses[i].world_from_camera = capture.views[i].camera.world_from_camera;
  state->kernels = initial_kernels(capture, state->extent, options.max_kernels, options.seed);
  state->adam.resize(state->kernels.size());
  state->errors.resize(state->kernels.size());
  state->update_min_scales();
  return Trainer(std::move(state));
}

void Trainer::use_device(std::unique_ptr<Backend> backend) { state_->view.use_device(std::move(backend)); }
size_t Trainer::steps_done() const { return state_->step; }
bool Trainer::done() const { return state_->step >= state_->options.steps; }
const KernelParameters& Trainer::kernels() const { return state_->kernels; }
double Trainer::extent() const { return state_->extent; }
double Trainer::recent_loss() const { return state_->recent_loss; }
Camera Trainer::camera(size_t view) const { return state_->camera_of(view); }

GaussianAsset Trainer::asset() const {
  // Until the first band is trained, the others are zero.
  return asset_of(state_->kernels, 3);
}

Result<void> Trainer::step() {
  State& s = *state_;
  const TrainOptions& options = s.options;
  const size_t index = s.view_of_step();
  auto photo = s.pictures.picture(index);
  if (!photo) return photo.error();
  TrainedViewOptions view_options;
  view_options.sh_degree = s.sh_degree();
  view_options.spread = options.spread_weight > 0;
  float alpha_weight = 0;
  if (!(*photo)->opaque) {
    // A fixed background would be trained into transparent parts.
    for (int i = 0; i < 3; ++i) {
      view_options.background[i] = static_cast<float>(
          random_share(options.seed, kBackgroundStream, 3 * s.step + static_cast<uint64_t>(i)));
    }
    alpha_weight = kAlphaWeight;
  }
  planes_of(**photo, view_options.background, s.target);
  s.view.draw(s.kernels, s.camera_of(index), view_options);
  double loss = s.loss.evaluate(s.view.picture(), s.target, (*photo)->counts, alpha_weight, s.by_picture);
  if (view_options.spread) loss += s.spread_loss((*photo)->counts);
  const CameraGradient by_camera = s.view.backward(s.kernels, s.by_picture, s.gradient, s.by_spread);
  const double progress = static_cast<double>(s.step) / static_cast<double>(options.steps);
  if (progress < options.grow_until && s.step % kErrorInterval == 0) s.add_errors((*photo)->counts);
  loss += add_shape_loss(s.kernels, options.shape, s.extent, s.gradient);

  const double factor = s.rate_factor();
  const double position_rate = factor * s.extent * options.position_rate *
                               std::pow(options.last_position_rate / options.position_rate, progress);
  const double anneal = factor * std::pow(options.last_rate_share, std::max(0.0, 2 * progress - 1));
  Rates rates{position_rate,
              anneal * options.scale_rate,
              anneal * options.rotation_rate,
              anneal * options.opacity_rate,
              anneal * options.colour_rate,
              anneal * options.harmonics_rate};
  adam_step(s.gradient, rates, s.view.visible(), s.adam, s.kernels);
  if (options.refine_poses && progress >= options.poses_from) {
    const double rate = factor * options.pose_rate * std::pow(options.last_pose_share, progress);
    step_camera_pose(by_camera, rate * s.extent, rate, s.poses[index]);
  }
  for (size_t k = 0; k < s.kernels.size(); ++k) {
    float* log_scale = s.kernels.row(Family::LogScale, k);
    for (int i = 0; i < 3; ++i) log_scale[i] = std::max(log_scale[i], s.min_log_scales[k]);
  }
  ++s.step;
  s.recent_loss += (s.step == 1 ? 1 : kRecentShare) * (loss - s.recent_loss);
  const uint64_t interval = densify_interval(options.steps);
  const bool grows = progress >= options.grow_from && progress < options.grow_until;
  if (grows && s.step % interval == 0) {
    relocate_dead(options.seed, s.step, s.errors, s.kernels, s.adam);
    grow(options.seed, s.step, options.max_kernels, s.errors, s.kernels, s.adam);
    for (float& error : s.errors) error *= 0.5f;
    s.update_min_scales();
  } else if (s.step % kMinScaleInterval == 0) {
    s.update_min_scales();
  }
  if (progress < options.grow_until) add_noise(options.seed, s.step, position_rate, s.kernels);
  return {};
}

// Adds the errors of the last view to those of the kernels: the derivative by the colour, of a picture that
// has the error in one channel, is the sum of the weights times the error.
void Trainer::State::add_errors(std::span<const uint8_t> counts) {
  const PicturePlanes& drawn = view.picture();
  by_picture.resize(drawn.width, drawn.height);
  parallel_for(drawn.pixels(), kPlaneBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const bool seen = counts.empty() || counts[i] != 0;
      by_picture.red[i] = seen ? std::abs(drawn.red[i] - target.red[i]) +
                                     std::abs(drawn.green[i] - target.green[i]) +
                                     std::abs(drawn.blue[i] - target.blue[i])
                               : 0.0f;
      by_picture.green[i] = by_picture.blue[i] = by_picture.alpha[i] = 0;
    }
  });
  view.backward(kernels, by_picture, error_gradient);
  for (size_t k = 0; k < kernels.size(); ++k) errors[k] += error_gradient.row(Family::Colour, k)[0];
}

double Trainer::State::rate_factor() const {
  return std::clamp(std::sqrt(kFullSteps / static_cast<double>(options.steps)), 1.0, kMaxRateFactor);
}

// Fits the pose of a held-out photo to the kernels. Continues from the last call.
void Trainer::State::place_held_out(size_t index, const CapturedPicture& photo,
                                    const TrainedViewOptions& view_options) {
  CameraPose& pose = poses[index];
  pose = {.world_from_camera = pose.world_from_camera};
  for (int k = 0; k < kPlacingSteps; ++k) {
    view.draw(kernels, camera_of(index), view_options);
    loss.evaluate(view.picture(), target, photo.counts, 0.0f, by_picture);
    const CameraGradient by_camera = view.backward(kernels, by_picture, gradient);
    const double rate =
        kPlacingRate * std::pow(kLastPlacingShare, static_cast<double>(k) / (kPlacingSteps - 1));
    step_camera_pose(by_camera, rate * extent, rate, pose);
  }
}

Result<HeldOutScore> Trainer::State::score() {
  HeldOutScore score;
  TrainedViewOptions view_options;
  view_options.sh_degree = 3;
  for (size_t index : held_out_views) {
    auto photo = pictures.picture(index);
    if (!photo) return photo.error();
    planes_of(**photo, view_options.background, target);
    if (options.refine_poses && step >= options.poses_from * static_cast<double>(options.steps))
      place_held_out(index, **photo, view_options);
    view.draw(kernels, camera_of(index), view_options);
    score.psnr_db += livegs::psnr_db(view.picture(), target, (*photo)->counts);
    score.ssim += loss.ssim(view.picture(), target);
    ++score.views;
  }
  if (score.views > 0) {
    score.psnr_db /= static_cast<double>(score.views);
    score.ssim /= static_cast<double>(score.views);
  }
  return score;
}

Result<HeldOutScore> Trainer::score() { return state_->score(); }

Result<Image> Trainer::compare(size_t index) {
  State& s = *state_;
  auto photo = s.pictures.picture(index);
  if (!photo) return photo.error();
  planes_of(**photo, Eigen::Vector3f::Zero(), s.target);
  s.view.draw(s.kernels, s.camera_of(index), TrainedViewOptions{});
  const PicturePlanes& drawn = s.view.picture();
  Image image;
  image.width = 2 * drawn.width;
  image.height = drawn.height;
  image.pixels.resize(size_t{8} * drawn.pixels());
  for (int y = 0; y < drawn.height; ++y) {
    for (int x = 0; x < drawn.width; ++x) {
      const size_t i = static_cast<size_t>(y) * static_cast<size_t>(drawn.width) + static_cast<size_t>(x);
      const float left[4] = {s.target.red[i], s.target.green[i], s.target.blue[i], 1};
      const float right[4] = {drawn.red[i], drawn.green[i], drawn.blue[i], 1};
      std::copy_n(left, 4, image.at(x, y));
      std::copy_n(right, 4, image.at(x + drawn.width, y));
    }
  }
  return image;
}

}  // namespace livegs
