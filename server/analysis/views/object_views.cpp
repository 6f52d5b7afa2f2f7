// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/views/object_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include "analysis/views/coverage_mask.h"
#include "analysis/views/outline.h"
#include "core/text/format_text.h"
#include "splat/kernel_view.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

constexpr double kVerticalFov_rad = 0.7;
// Bounding sphere of the target over picture height; leaves a margin for its surroundings.
constexpr double kFillShare = 0.7;
constexpr int kThumbnail_px = 160;  // long side of the thumbnails that score the cameras
constexpr double kUprightElevation_rad = 0.35, kSteepElevation_rad = 0.8;
constexpr double kSteepBonus = 0.85;  // most objects are seen and photographed from slightly above
// Fraction of the distance; the close ring lies inside obstacles near the target.
constexpr double kCloseRingDistance = 0.5;
constexpr double kMinVisibleShare = 0.3;        // visible share below which the close ring is tried
constexpr double kMinViewSeparation_rad = 0.9;  // between views of one object
// Margin around the target in the outlined picture, as a fraction of the target's extent. The picture then
// shows the support and the neighbours of the target.
constexpr double kOutlinedMargin = 0.25;
// Margin around the target alone.
constexpr double kCutoutMargin = 0.05;
// Step of the added surface, as a fraction of the surface in a view. Views within one step count as equal,
// because kernels on the rim appear larger edge-on, a few percent in sum.
constexpr double kAddedStep = 0.05;
// Number of kernels in thumbnails: of the target, and of everything else.
constexpr size_t kTargetKernels = 30'000, kOtherKernels = 120'000;

struct Ring {
  Eigen::Vector3d target_m;
  double distance_m;
};

struct Candidate {
  ViewCandidate judged;
  double distance_m = 0;
  // Pixels of light from each kernel of the target: in the scene, and with the target alone.
  std::vector<float> visible_px, alone_px;
};

// The target as one object.
struct Target {
  explicit Target(std::span<const DrawnObject> objects) {
    for (const DrawnObject& object : objects) {
      const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
      append(asset.positions, object.asset->positions);
      append(asset.opacity_logits, object.asset->opacity_logits);
      append(asset.sh_dc, object.asset->sh_dc);
      append(kernels.positions_m, object.kernels->positions_m);
      append(kernels.covariances_m2, object.kernels->covariances_m2);
      append(kernels.world_from_asset, object.kernels->world_from_asset);
      asset.antialiased = object.asset->antialiased;
      drawn.object_id = object.object_id;
    }
    drawn.asset = &asset;
    drawn.kernels = &kernels;
  }
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  GaussianAsset asset;
  PosedKernels kernels;
  DrawnObject drawn;
};

Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad) {
  return {std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
          std::cos(azimuth_rad) * std::cos(elevation_rad)};
}

Camera camera_at(const Ring& ring, double azimuth_rad, double elevation_rad, int width, int height) {
  Camera camera = look_at(ring.target_m + ring.distance_m * direction_of(azimuth_rad, elevation_rad),
                          ring.target_m, Eigen::Vector3d::UnitY(), kVerticalFov_rad, width, height);
  camera.near_m = std::min(camera.near_m, 0.02 * ring.distance_m);
  return camera;
}

// Sum of a channel over all pixels: the light from the target, in pixels.
double sum_of(const Image& image, int channel) {
  double sum = 0;
  for (size_t i = static_cast<size_t>(channel); i < image.pixels.size(); i += 4) sum += image.pixels[i];
  return sum;
}

// Bounds of the target without the outermost 1/500 of its kernels on each side.
Eigen::AlignedBox3d bounds_of(std::span<const DrawnObject> target) {
  std::array<std::vector<double>, 3> places;
  for (const DrawnObject& object : target) {
    for (size_t i = 0; i < object.kernels->positions_m.size(); ++i) {
      const Eigen::Vector3f& place = object.kernels->positions_m[i];
      if (object.asset->opacity_logits[i] < -2.2f || !place.allFinite()) continue;  // opacity 0.1
      for (int d = 0; d < 3; ++d) places[d].push_back(place[d]);
    }
  }
  Eigen::AlignedBox3d bounds;
  if (places[0].empty()) return bounds;
  Eigen::Vector3d low, high;
  const size_t spare = places[0].size() / 500;
  for (int d = 0; d < 3; ++d) {
    std::sort(places[d].begin(), places[d].end());
    low[d] = places[d][spare];
    high[d] = places[d][places[d].size() - 1 - spare];
  }
  bounds.extend(low);
  bounds.extend(high);
  return bounds;
}

std::vector<Candidate> judge_ring(const CoverageMaskScene& thin, const Ring& ring, int width, int height,
                                  Rasteriser& rasteriser, const std::stop_token& stop) {
  std::vector<Candidate> ring_candidates;
  RasterisedView view;
  RasteriseOptions options;
  const Target target(thin.target());
  KernelRasteriser kernels;
  std::vector<uint16_t> seen(static_cast<size_t>(width) * height);
  std::vector<LabelWeight> weights;
  for (int i = 0; i < 12 && !stop.stop_requested(); ++i) {
    const bool steep = i >= 8;
    Candidate candidate;
    candidate.distance_m = ring.distance_m;
    ViewCandidate& judged = candidate.judged;
    judged.azimuth_rad = steep ? (i - 8 + 0.5) * std::numbers::pi / 2 : i * std::numbers::pi / 4;
    judged.elevation_rad = steep ? kSteepElevation_rad : kUprightElevation_rad;
    const Camera camera = camera_at(ring, judged.azimuth_rad, judged.elevation_rad, width, height);
    rasteriser.draw(thin.target(), camera, options, view);
    const double alone = sum_of(view.image, 0);
    if (alone > 0) {
      rasteriser.draw(thin.seen_by(camera), camera, options, view);
      const double visible = sum_of(view.image, 0);
      judged.visible_share = std::clamp(visible / alone, 0.0, 1.0);
      judged.area_share = visible / (static_cast<double>(width) * height);
      judged.score =
          alone / (static_cast<double>(width) * height) * judged.visible_share * (steep ? kSteepBonus : 1.0);
      for (size_t pixel = 0; pixel < seen.size(); ++pixel) seen[pixel] = view.image.pixels[4 * pixel] >= 0.5f;
    } else {
      std::fill(seen.begin(), seen.end(), uint16_t{0});
    }
    weights.clear();
    kernels.weigh(target.drawn, camera, seen, weights);
    candidate.visible_px.assign(target.asset.size(), 0.0f);
    candidate.alone_px.assign(target.asset.size(), 0.0f);
    for (const LabelWeight& one : weights) {
      candidate.alone_px[one.kernel] += one.weight;
      if (one.label) candidate.visible_px[one.kernel] += one.weight;
    }
    ring_candidates.push_back(std::move(candidate));
  }
  return ring_candidates;
}

Eigen::Vector3d direction_of(const Candidate& candidate) {
  return direction_of(candidate.judged.azimuth_rad, candidate.judged.elevation_rad);
}

double sum_of(const std::vector<float>& kernels_px) {
  return std::accumulate(kernels_px.begin(), kernels_px.end(), 0.0);
}

// Surface that a view adds to the surface of other views, in steps of kAddedStep of `whole_px`: for each
// kernel the additional pixels.
double added_steps(const std::vector<float>& view_px, const std::vector<float>& seen_px, double whole_px) {
  double added = 0;
  for (size_t i = 0; i < view_px.size(); ++i) added += std::max(0.0f, view_px[i] - seen_px[i]);
  return whole_px > 0 ? std::floor(added / (kAddedStep * whole_px)) : 0;
}

// Selects the best candidate, then those that add the most to the surface seen so far (greedy facility
// location, Nemhauser et al. 1978), with the score as a tie-break. Views in another direction come first.
std::vector<const Candidate*> choose(const std::vector<Candidate>& candidates, size_t count) {
  std::vector<const Candidate*> left, chosen;
  for (const Candidate& candidate : candidates) left.push_back(&candidate);
  std::vector<float> seen_px(candidates.empty() ? 0 : candidates.front().visible_px.size(), 0.0f);
  double first_px = 0;
  while (!left.empty() && chosen.size() < count) {
    const auto rank = [&](const Candidate& candidate) {
      const bool near = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate* other) {
        return direction_of(candidate).dot(direction_of(*other)) > std::cos(kMinViewSeparation_rad);
      });
      const double added = chosen.empty() ? 0 : added_steps(candidate.visible_px, seen_px, first_px);
      return std::tuple(!near, added, candidate.judged.score);
    };
    auto best = left.begin();
    for (auto one = left.begin() + 1; one != left.end(); ++one) {
      if (rank(**one) > rank(**best)) best = one;
    }
    if (chosen.empty()) first_px = sum_of((*best)->visible_px);
    for (size_t i = 0; i < seen_px.size(); ++i) seen_px[i] = std::max(seen_px[i], (*best)->visible_px[i]);
    chosen.push_back(*best);
    left.erase(best);
  }
  return chosen;
}

// The view of the target alone that shows the most of what `view` does not show; `view` itself if none shows
// more.
const Candidate& complement(const std::vector<Candidate>& candidates, const Candidate& view) {
  const double whole_px = sum_of(view.alone_px);
  const Candidate* best = &view;
  double most = added_steps(view.alone_px, view.visible_px, whole_px);
  for (const Candidate& candidate : candidates) {
    if (candidate.distance_m != view.distance_m) continue;  // of the same ring
    const double added = added_steps(candidate.alone_px, view.visible_px, whole_px);
    if (added <= most) continue;
    most = added;
    best = &candidate;
  }
  return *best;
}

// Edges of the region of `silhouette` that is at least 0.1, in pixels.
struct Extent {
  double left = 0, right = 0, top = 0, bottom = 0;
};
std::optional<Extent> extent_of(const Image& silhouette) {
  int left = silhouette.width, right = -1, top = silhouette.height, bottom = -1;
  for (int y = 0; y < silhouette.height; ++y) {
    for (int x = 0; x < silhouette.width; ++x) {
      if (silhouette.at(x, y)[0] < 0.1f) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return std::nullopt;
  return Extent{left - 1.0, right + 2.0, top - 1.0, bottom + 2.0};  // and a pixel of the silhouette's edge
}

// A camera at the same place that shows the rectangle of `camera` around `extent` of this size, in pixels, on
// a picture of width times height.
Camera lens(const Camera& camera, const Extent& extent, double wide_px, int width, int height) {
  const double zoom = width / wide_px;
  Camera close = camera;
  close.width = width;
  close.height = height;
  close.focal_x_px *= zoom;
  close.focal_y_px *= zoom;
  close.centre_x_px = 0.5 * width + zoom * (camera.centre_x_px - 0.5 * (extent.left + extent.right));
  close.centre_y_px = 0.5 * height + zoom * (camera.centre_y_px - 0.5 * (extent.top + extent.bottom));
  return close;
}

// Camera with a longer lens, so that `silhouette` fills the picture, whose shape is that of the silhouette.
Camera close_up(const Camera& camera, const Image& silhouette, int long_side_px) {
  const auto extent = extent_of(silhouette);
  if (!extent) return camera;
  const double wide = (1 + 2 * kCutoutMargin) * (extent->right - extent->left),
               high = (1 + 2 * kCutoutMargin) * (extent->bottom - extent->top);
  const double zoom = long_side_px / std::max(wide, high);
  return lens(camera, *extent, wide, std::max(16, static_cast<int>(std::lround(zoom * wide))),
              std::max(16, static_cast<int>(std::lround(zoom * high))));
}

// Camera with a longer lens and a picture of the same size that is cropped to `silhouette` with a margin.
Camera cropped(const Camera& camera, const Image& silhouette) {
  const auto extent = extent_of(silhouette);
  if (!extent) return camera;
  const double wide = extent->right - extent->left, high = extent->bottom - extent->top,
               margin = 2 * kOutlinedMargin * std::max(wide, high),
               aspect = static_cast<double>(camera.width) / camera.height;
  return lens(camera, *extent, std::max(wide + margin, aspect * (high + margin)), camera.width,
              camera.height);
}

// Copies one channel of `from` to all three, fully opaque.
Image grey(const Image& from) {
  Image image = from;
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    const float value = std::clamp(from.pixels[i], 0.0f, 1.0f);
    image.pixels[i] = image.pixels[i + 1] = image.pixels[i + 2] = value;
    image.pixels[i + 3] = 1.0f;
  }
  return image;
}

// The same camera with a picture of kSightCells along its longer side.
Camera sight_camera(Camera camera) {
  const double factor = static_cast<double>(kSightCells) / std::max(camera.width, camera.height);
  const int width = std::max(1, static_cast<int>(std::lround(factor * camera.width))),
            height = std::max(1, static_cast<int>(std::lround(factor * camera.height)));
  const double across = static_cast<double>(width) / camera.width,
               down = static_cast<double>(height) / camera.height;
  camera.width = width;
  camera.height = height;
  camera.focal_x_px *= across;
  camera.focal_y_px *= down;
  camera.centre_x_px *= across;
  camera.centre_y_px *= down;
  return camera;
}

// Every `stride`-th kernel with its weight per pixel of `camera`. `mask`: a picture of the same view; pixels
// in which it shows other objects are ignored; null: none are.
PictureSights sights_of(const DrawnObject& target, const Camera& camera, const Image* mask, size_t stride) {
  const Camera small = sight_camera(camera);
  PictureSights sights;
  sights.columns = small.width;
  sights.rows = small.height;
  std::vector<uint16_t> cells(static_cast<size_t>(small.width) * static_cast<size_t>(small.height));
  std::iota(cells.begin(), cells.end(), uint16_t{0});
  std::vector<LabelWeight> weights;
  KernelRasteriser().weigh(target, small, cells, weights);
  for (const LabelWeight& one : weights) {
    if (one.kernel % stride != 0) continue;
    if (mask) {
      const int x = static_cast<int>(one.label) % small.width, y = static_cast<int>(one.label) / small.width;
      const float* seen = mask->at(std::min(mask->width - 1, x * mask->width / small.width),
                                   std::min(mask->height - 1, y * mask->height / small.height));
      if (seen[0] < 0.5f) continue;
    }
    sights.seen.push_back(
        {static_cast<uint32_t>(one.kernel / stride), static_cast<uint16_t>(one.label), one.weight});
  }
  return sights;
}

Result<void> check(const ViewOptions& options) {
  if (options.long_side_px < 32 || options.long_side_px > 4096) {
    return invalid_argument("long_side_px: " + std::to_string(options.long_side_px) +
                            " is not in 32 to 4096");
  }
  if (options.view_count < 1 || options.view_count > 12) {
    return invalid_argument("view_count: " + std::to_string(options.view_count) + " is not in 1 to 12");
  }
  if (!(options.aspect >= 0.5 && options.aspect <= 2.0)) {
    return invalid_argument("aspect: " + std::to_string(options.aspect) + " is not in 0.5 to 2");
  }
  return {};
}

}  // namespace

Result<std::vector<ObjectView>> object_views(std::span<const DrawnObject> scene, uint32_t object_id,
                                             const ViewOptions& options,
                                             std::vector<ViewCandidate>* candidates) {
  if (auto checked = check(options); !checked) return checked.error();
  std::vector<DrawnObject> target;
  for (const DrawnObject& object : scene) {
    if (object.object_id == object_id) target.push_back(object);
  }
  if (target.empty()) {
    return invalid_argument("object " + std::to_string(object_id) + ": is not among the scene's objects");
  }
  const Eigen::AlignedBox3d bounds = bounds_of(target);
  if (bounds.isEmpty()) {
    return invalid_argument("object " + std::to_string(object_id) +
                            ": has no kernel with an opacity of 0.1 or more; raise the opacities");
  }
  const auto size = [&](int long_side) {
    const double wide = std::min(1.0, options.aspect), high = std::min(1.0, 1 / options.aspect);
    return std::pair(
        std::max(8, static_cast<int>(std::lround(long_side * (options.aspect < 1 ? wide : 1.0)))),
        std::max(8, static_cast<int>(std::lround(long_side * (options.aspect < 1 ? 1.0 : high)))));
  };
  const double radius_m = std::max(0.5 * bounds.sizes().norm(), 1e-3);
  const Ring ring{bounds.center(), radius_m / (kFillShare * std::tan(0.5 * kVerticalFov_rad)) /
                                       std::max(1.0, std::min(1.0, options.aspect))};

  Rasteriser rasteriser;
  const auto [thumb_width, thumb_height] = size(kThumbnail_px);
  const CoverageMaskScene thin(scene, object_id, kTargetKernels, kOtherKernels);
  std::vector<Candidate> tried = judge_ring(thin, ring, thumb_width, thumb_height, rasteriser, options.stop);
  const bool hidden = std::none_of(tried.begin(), tried.end(), [](const Candidate& c) {
    return c.judged.visible_share > kMinVisibleShare;
  });
  if (hidden) {
    const Ring close{ring.target_m, kCloseRingDistance * ring.distance_m};
    for (Candidate& candidate :
         judge_ring(thin, close, thumb_width, thumb_height, rasteriser, options.stop)) {
      // The area it would have on the wide ring.
      constexpr float kWideArea = kCloseRingDistance * kCloseRingDistance;
      candidate.judged.score *= kWideArea;
      for (std::vector<float>* kernels_px : {&candidate.visible_px, &candidate.alone_px}) {
        for (float& one_px : *kernels_px) one_px *= kWideArea;
      }
      tried.push_back(candidate);
    }
  }
  const Error cancelled{ErrorCode::Unavailable, "cancelled"};
  if (options.stop.stop_requested()) return cancelled;
  if (candidates) {
    candidates->clear();
    for (const Candidate& candidate : tried) candidates->push_back(candidate.judged);
  }

  const auto [width, height] = size(options.long_side_px);
  const CoverageMaskScene whole(scene, object_id);
  std::vector<ObjectView> views;
  for (const Candidate* chosen : choose(tried, static_cast<size_t>(options.view_count))) {
    ObjectView view;
    const Ring at{ring.target_m, chosen->distance_m};
    const auto camera_of = [&](const Candidate& candidate) {
      return camera_at(at, candidate.judged.azimuth_rad, candidate.judged.elevation_rad, width, height);
    };
    view.target_m = ring.target_m;
    view.distance_m = chosen->distance_m;
    view.azimuth_rad = chosen->judged.azimuth_rad;
    view.elevation_rad = chosen->judged.elevation_rad;
    view.score = chosen->judged.score;
    RasterisedView drawn;
    if (options.stop.stop_requested()) return cancelled;
    rasteriser.draw(whole.target(), camera_of(*chosen), {}, drawn);
    view.camera = cropped(camera_of(*chosen), drawn.image);
    RasteriseOptions grey_ground;
    grey_ground.background = Eigen::Vector3f::Constant(0.5f);
    if (options.stop.stop_requested()) return cancelled;
    rasteriser.draw(whole.coloured_seen_by(view.camera), view.camera, grey_ground, drawn);
    view.scene = std::move(drawn.image);
    if (options.stop.stop_requested()) return cancelled;
    rasteriser.draw(whole.seen_by(view.camera), view.camera, {}, drawn);
    view.mask = grey(drawn.image);
    const double visible = sum_of(view.mask, 0);
    rasteriser.draw(whole.target(), view.camera, {}, drawn);
    const double alone = sum_of(drawn.image, 0);
    view.visible_share = alone > 0 ? std::clamp(visible / alone, 0.0, 1.0) : 0.0;
    view.area_share = visible / (static_cast<double>(width) * height);
    view.outlined = outlined(view.scene, view.mask, std::max(1, options.long_side_px / 256));
    const Candidate& other = complement(tried, *chosen);
    view.cutout_azimuth_rad = other.judged.azimuth_rad;
    view.cutout_elevation_rad = other.judged.elevation_rad;
    RasteriseOptions white_ground;
    white_ground.background = Eigen::Vector3f::Ones();
    if (options.stop.stop_requested()) return cancelled;
    rasteriser.draw(whole.target(), camera_of(other), {}, drawn);
    const Camera close = close_up(camera_of(other), drawn.image, options.long_side_px);
    rasteriser.draw(target, close, white_ground, drawn);
    view.cutout = std::move(drawn.image);
    if (options.sight_stride > 0 && target.size() == 1) {
      view.sights = {sights_of(target.front(), view.camera, &view.mask, options.sight_stride),
                     sights_of(target.front(), close, nullptr, options.sight_stride)};
    }
    views.push_back(std::move(view));
  }
  return views;
}

std::map<std::string, std::string> camera_slots(const ObjectView& view) {
  const auto degrees = [](double rad) { return format_text("%.0f", rad * 180 / std::numbers::pi); };
  return {{"camera_azimuth", degrees(view.azimuth_rad)},
          {"camera_elevation", degrees(view.elevation_rad)},
          {"camera_seen", format_text("%.0f", 100 * view.visible_share)},
          {"second_azimuth", degrees(view.cutout_azimuth_rad)},
          {"second_elevation", degrees(view.cutout_elevation_rad)}};
}

std::string describe_camera(const ObjectView& view) {
  static constexpr const char* kSides[] = {"the front", "the front right", "the right", "the back right",
                                           "the back",  "the back left",   "the left",  "the front left"};
  const long eighth = std::lround(view.azimuth_rad / (std::numbers::pi / 4));
  char text[200];
  std::snprintf(text, sizeof text,
                "from %s, %.0f degrees above the horizon, %.3g m from its centre; %.0f %% of it is seen",
                kSides[((eighth % 8) + 8) % 8], view.elevation_rad * 180 / std::numbers::pi, view.distance_m,
                100 * view.visible_share);
  return text;
}

}  // namespace livegs
