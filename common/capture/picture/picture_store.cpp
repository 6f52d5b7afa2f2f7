// SPDX-License-Identifier: Apache-2.0
#include "capture/picture_store.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/picture/picture_file.h"
#include "core/parallel_for.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

// A photo without a colour above this share of white is black: a covered lens, a failed export.
constexpr float kBlackLevel = 8.0f / 255.0f;
// Largest difference of the aspect ratios of a photo and its pose file: a pixel of rounding in 200.
constexpr double kMaxAspectDifference = 0.005;

Camera working_camera(const Camera& camera, int longest_px) {
  const int longest = std::max(camera.width, camera.height);
  if (longest_px <= 0 || longest_px >= longest) return camera;
  Camera small = camera;
  const double factor = static_cast<double>(longest_px) / longest;
  small.width = std::max(1, static_cast<int>(std::lround(camera.width * factor)));
  small.height = std::max(1, static_cast<int>(std::lround(camera.height * factor)));
  const double factor_x = static_cast<double>(small.width) / camera.width;
  const double factor_y = static_cast<double>(small.height) / camera.height;
  small.focal_x_px *= factor_x;
  small.centre_x_px *= factor_x;
  small.focal_y_px *= factor_y;
  small.centre_y_px *= factor_y;
  return small;
}

bool same_aspect(int width, int height, const Camera& camera) {
  const double ratio =
      static_cast<double>(width) * camera.height / (static_cast<double>(height) * camera.width);
  return std::abs(ratio - 1) <= kMaxAspectDifference;
}

// Pose files state the size of the stored picture, which most tools do not turn. A photo is turned only if
// its pose file has the turned size.
std::optional<Image> fitting_image(StoredPicture stored, const Camera& camera) {
  if (same_aspect(stored.image.width, stored.image.height, camera)) return std::move(stored.image);
  if (stored.orientation >= 5 && same_aspect(stored.image.height, stored.image.width, camera))
    return turn_upright(stored.image, stored.orientation);
  return std::nullopt;
}

// Point of the distorted picture, in units of the slopes, for a slope of the pinhole camera.
void distort(const LensDistortion& lens, double& x, double& y) {
  const double xx = x * x, yy = y * y, xy = x * y, r = xx + yy;
  const double radial = 1 + r * (lens.k1 + r * lens.k2);
  const double distorted_x = x * radial + 2 * lens.p1 * xy + lens.p2 * (r + 2 * xx);
  y = y * radial + lens.p1 * (r + 2 * yy) + 2 * lens.p2 * xy;
  x = distorted_x;
}

// Pixels and weights of Catmull and Rom's cubic interpolation (Keys 1981, a = -1/2) along an edge of `size`
// pixels, at `x`, where 0 is the centre of the first pixel. Linear interpolation would blur a photo by an
// amount that depends on the place, up to the loss of single pixels halfway between two of them.
struct CubicTaps {
  CubicTaps(double x, int size) {
    const double below = std::floor(std::clamp(x, -1.0, static_cast<double>(size)));
    const auto t = static_cast<float>(std::clamp(x - below, 0.0, 1.0));
    for (int i = 0; i < 4; ++i) pixels[i] = std::clamp(static_cast<int>(below) - 1 + i, 0, size - 1);
    weights[0] = 0.5f * t * (-1 + t * (2 - t));
    weights[1] = 0.5f * (2 + t * t * (-5 + 3 * t));
    weights[2] = 0.5f * t * (1 + t * (4 - 3 * t));
    weights[3] = 0.5f * t * t * (t - 1);
  }
  int pixels[4];
  float weights[4];
};

// Adds the colour of the photo at a point, multiplied by opacity, and the opacity.
void add_sample(const Image& photo, double x, double y, float (&sum)[4]) {
  const CubicTaps columns(x, photo.width), rows(y, photo.height);
  for (int i = 0; i < 4; ++i) {
    if (rows.weights[i] == 0) continue;
    for (int k = 0; k < 4; ++k) {
      const float* pixel = photo.at(columns.pixels[k], rows.pixels[i]);
      const float weight = rows.weights[i] * columns.weights[k];
      for (int c = 0; c < 3; ++c) sum[c] += weight * pixel[3] * pixel[c];
      sum[3] += weight * pixel[3];
    }
  }
}

// Mean of the photo over each pixel of `to`. Along each edge a pixel is sampled at as many points as it
// covers pixels of the photo, with cubic interpolation; without distortion and for whole factors this is
// the mean of the pixels. A sample outside the photo makes the pixel not count.
CapturedPicture resample(const Image& photo, const Image* mask, const CapturedView& view, const Camera& to) {
  CapturedPicture picture;
  picture.width = to.width;
  picture.height = to.height;
  picture.rgba.resize(size_t{4} * to.width * to.height);
  picture.counts.assign(static_cast<size_t>(to.width) * to.height, 255);
  const double step_x = static_cast<double>(photo.width) / to.width;
  const double step_y = static_cast<double>(photo.height) / to.height;
  const int samples_x = std::max(1, static_cast<int>(std::ceil(step_x - 0.01)));
  const int samples_y = std::max(1, static_cast<int>(std::ceil(step_y - 0.01)));
  // Slopes to pixels of the photo, which may have another size than the pose file.
  const double focal_x = to.focal_x_px * step_x, focal_y = to.focal_y_px * step_y;
  const double centre_x = to.centre_x_px * step_x, centre_y = to.centre_y_px * step_y;
  const bool distorted = !view.distortion.none();
  bool all_count = true, opaque = true;
  for (int row = 0; row < to.height; ++row) {
    for (int column = 0; column < to.width; ++column) {
      float sum[4] = {};
      bool counted = true;
      for (int i = 0; i < samples_y; ++i) {
        for (int k = 0; k < samples_x; ++k) {
          double x = (column + (k + 0.5) / samples_x) * step_x, y = (row + (i + 0.5) / samples_y) * step_y;
          if (distorted) {
            double slope_x = (x - centre_x) / focal_x, slope_y = (y - centre_y) / focal_y;
            distort(view.distortion, slope_x, slope_y);
            x = slope_x * focal_x + centre_x;
            y = slope_y * focal_y + centre_y;
            if (!(x >= 0 && y >= 0 && x <= photo.width && y <= photo.height)) {
              counted = false;
              continue;
            }
          }
          if (mask != nullptr) {
            const int at_x = std::clamp(static_cast<int>(x * mask->width / photo.width), 0, mask->width - 1);
            const int at_y =
                std::clamp(static_cast<int>(y * mask->height / photo.height), 0, mask->height - 1);
            const float* label = mask->at(at_x, at_y);
            if (label[0] + label[1] + label[2] == 0.0f) counted = false;
          }
          add_sample(photo, x - 0.5, y - 0.5, sum);
        }
      }
      const size_t pixel = static_cast<size_t>(row) * to.width + column;
      const auto scale = 255.0f / static_cast<float>(samples_x * samples_y);
      for (size_t c = 0; c < 4; ++c)
        picture.rgba[4 * pixel + c] = static_cast<uint8_t>(std::clamp(sum[c] * scale + 0.5f, 0.0f, 255.0f));
      if (!counted) picture.counts[pixel] = 0;
      all_count = all_count && counted;
      opaque = opaque && (!counted || picture.rgba[4 * pixel + 3] == 255);
    }
  }
  if (all_count) picture.counts.clear();
  picture.opaque = opaque;
  return picture;
}

bool is_black(const Image& image) {
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    for (size_t c = 0; c < 3; ++c) {
      if (image.pixels[i + c] > kBlackLevel) return false;
    }
  }
  return true;
}

uint64_t bytes_of(const CapturedPicture& picture) { return picture.rgba.size() + picture.counts.size(); }

}  // namespace

PictureStore::PictureStore(const Capture& capture, const PictureOptions& options)
    : capture_(capture), options_(options), kept_(capture.views.size()) {
  for (const CapturedView& view : capture.views)
    cameras_.push_back(working_camera(view.camera, options.longest_px));
}

Result<CapturedPicture> PictureStore::read(size_t index) const {
  const CapturedView& view = capture_.views[index];
  auto stored = read_picture(view.picture);
  if (!stored) return stored.error();
  const int width = stored->image.width, height = stored->image.height;
  auto image = fitting_image(std::move(*stored), view.camera);
  if (!image) {
    return invalid_data(
        format_text("%s: is %d x %d pixels, but its pose is of %d x %d; use the photos of the poses",
                    view.picture.c_str(), width, height, view.camera.width, view.camera.height));
  }
  if (is_black(*image)) return invalid_data(view.picture.string() + ": is black; remove it");
  std::optional<Image> mask;
  if (options_.ignore_masked && !view.mask.empty()) {
    auto labels = read_picture(view.mask);
    if (!labels) return labels.error();
    if (labels->image.width != image->width || labels->image.height != image->height) {
      return invalid_data(format_text(
          "%s: is %d x %d pixels, but its photo is %d x %d; save both in the same size", view.mask.c_str(),
          labels->image.width, labels->image.height, image->width, image->height));
    }
    mask = std::move(labels->image);
  }
  return resample(*image, mask ? &*mask : nullptr, view, cameras_[index]);
}

Result<std::shared_ptr<const CapturedPicture>> PictureStore::picture(size_t view) {
  {
    std::lock_guard lock(mutex_);
    if (kept_[view]) {
      recent_.remove(view);
      recent_.push_front(view);
      return kept_[view];
    }
  }
  auto read_now = read(view);
  if (!read_now) return read_now.error();
  auto picture = std::make_shared<const CapturedPicture>(std::move(*read_now));
  std::lock_guard lock(mutex_);
  if (kept_[view]) return kept_[view];
  kept_[view] = picture;
  recent_.push_front(view);
  kept_bytes_ += bytes_of(*picture);
  while (kept_bytes_ > options_.max_bytes && recent_.size() > 1) {
    const size_t oldest = recent_.back();
    recent_.pop_back();
    kept_bytes_ -= bytes_of(*kept_[oldest]);
    kept_[oldest].reset();
  }
  return picture;
}

Result<void> PictureStore::check_all() {
  std::vector<std::optional<Error>> errors(kept_.size());
  parallel_for(kept_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t view = begin; view < end; ++view) {
      if (auto one = picture(view); !one) errors[view] = one.error();
    }
  });
  size_t failed = 0;
  const Error* first = nullptr;
  for (const auto& error : errors) {
    if (!error) continue;
    ++failed;
    if (first == nullptr) first = &*error;
  }
  if (first == nullptr) return {};
  if (failed == 1) return *first;
  return Error{first->code, format_text("%zu of %zu photos cannot be used, the first is %s", failed,
                                        errors.size(), first->message.c_str())};
}

uint64_t PictureStore::bytes_in_memory() const {
  std::lock_guard lock(mutex_);
  return kept_bytes_;
}

}  // namespace livegs
