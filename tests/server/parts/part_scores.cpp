// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/parts/part_scores.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "parts/label/choose_kernels.h"
#include "parts/label/label_weights.h"
#include "parts/views/room_view.h"
#include "splat/rasterise.h"

namespace livegs {

std::vector<uint16_t> label_picture(const GaussianAsset& asset, std::span<const uint16_t> label,
                                    const Camera& camera) {
  const std::set<uint16_t> labels(label.begin(), label.end());
  std::vector<GaussianAsset> assets;
  std::vector<PosedKernels> posed;
  std::vector<DrawnObject> objects;
  assets.reserve(labels.size());
  posed.reserve(labels.size());
  for (const uint16_t one : labels) {
    std::vector<uint32_t> own;
    for (uint32_t k = 0; k < asset.size(); ++k)
      if (label[k] == one) own.push_back(k);
    assets.push_back(select_kernels(asset, own));
    posed.push_back(pose_in_place(assets.back()));
    objects.push_back({&assets.back(), &posed.back(), one});
  }
  Rasteriser rasteriser;
  RasterisedView view;
  rasteriser.draw(objects, camera, {}, view);
  std::vector<uint16_t> picture(view.object_id.size());
  for (size_t i = 0; i < picture.size(); ++i)
    picture[i] = view.object_id[i] == kNoObject ? 0 : static_cast<uint16_t>(view.object_id[i]);
  return picture;
}

namespace {

// Pixels of a mask within `reach` of a pixel that is not in it, or of the rim of the picture.
std::vector<uint8_t> boundary(const std::vector<uint8_t>& mask, int width, int reach) {
  const int height = static_cast<int>(mask.size()) / width;
  // Two passes of a minimum over a square: rows, then columns.
  std::vector<uint8_t> row(mask.size(), 1), inside(mask.size(), 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int d = -reach; d <= reach; ++d)
        row[y * width + x] &= x + d >= 0 && x + d < width && mask[y * width + x + d];
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int d = -reach; d <= reach; ++d)
        inside[y * width + x] &= y + d >= 0 && y + d < height && row[(y + d) * width + x];
  std::vector<uint8_t> rim(mask.size());
  for (size_t i = 0; i < mask.size(); ++i) rim[i] = mask[i] && !inside[i];
  return rim;
}

int boundary_reach(int width, int height) {
  return std::max(1, static_cast<int>(std::lround(0.02 * std::hypot(width, height))));
}

}  // namespace

AloneScore score_alone(const GaussianAsset& thing, std::span<const Camera> cameras,
                       std::span<const std::vector<uint8_t>> truth,
                       std::span<const std::vector<uint8_t>> hidden) {
  const PosedKernels posed = pose_in_place(thing);
  const DrawnObject object{&thing, &posed, 0};
  Rasteriser rasteriser;
  RasterisedView view;
  size_t both = 0, either = 0, rim_both = 0, rim_either = 0;
  for (size_t v = 0; v < cameras.size(); ++v) {
    rasteriser.draw(std::span(&object, 1), cameras[v], {}, view);
    std::vector<uint8_t> a = truth[v], b(a.size());
    for (size_t i = 0; i < a.size(); ++i) {
      b[i] = !hidden[v][i] && view.image.pixels[4 * i + 3] >= 0.5f;
      a[i] = a[i] && !hidden[v][i];
      both += a[i] && b[i], either += a[i] || b[i];
    }
    const int reach = boundary_reach(cameras[v].width, cameras[v].height);
    const auto rim_a = boundary(a, cameras[v].width, reach), rim_b = boundary(b, cameras[v].width, reach);
    for (size_t i = 0; i < a.size(); ++i)
      rim_both += rim_a[i] && rim_b[i], rim_either += rim_a[i] || rim_b[i];
  }
  const auto ratio = [](size_t some, size_t all) {
    return all ? static_cast<double>(some) / static_cast<double>(all) : 1.0;
  };
  return {ratio(both, either), ratio(rim_both, rim_either)};
}

double mixed_kernels(const GaussianAsset& asset, std::span<const Camera> cameras,
                     std::span<const std::vector<uint16_t>> pictures) {
  const PosedKernels posed = pose_in_place(asset);
  const LabelWeights weights = weigh_labels({&asset, &posed, 0}, cameras, pictures);
  size_t seen = 0, mixed = 0;
  for (size_t k = 0; k < asset.size(); ++k) {
    const LabelWeights::Share share = weights.largest(k);
    seen += share.weight >= 1;
    mixed += share.weight >= 1 && share.share < 0.8f;
  }
  return static_cast<double>(mixed) / static_cast<double>(std::max<size_t>(seen, 1));
}

PartScores score_parts(std::span<const std::vector<uint16_t>> truth,
                       std::span<const std::vector<uint16_t>> found, int width,
                       std::span<const uint16_t> ignored) {
  std::map<std::pair<uint16_t, uint16_t>, size_t> overlap;
  std::map<uint16_t, size_t> truth_area, found_area;
  for (size_t v = 0; v < truth.size(); ++v)
    for (size_t i = 0; i < truth[v].size(); ++i) {
      ++overlap[{truth[v][i], found[v][i]}];
      ++truth_area[truth[v][i]];
      ++found_area[found[v][i]];
    }
  PartScores scores;
  std::set<uint16_t> matched;
  for (const auto& [thing, area] : truth_area) {
    if (thing == 0 || std::find(ignored.begin(), ignored.end(), thing) != ignored.end()) continue;
    ThingScore score;
    score.truth = thing;
    for (const auto& [label, label_area] : found_area) {
      const auto at = overlap.find({thing, label});
      if (label == 0 || at == overlap.end()) continue;
      const double iou =
          static_cast<double>(at->second) / static_cast<double>(area + label_area - at->second);
      if (iou > score.iou) score.iou = iou, score.label = label;
    }
    if (score.label) {
      size_t both = 0, either = 0;
      const int height = static_cast<int>(truth[0].size()) / width;
      const int reach = boundary_reach(width, height);
      for (size_t v = 0; v < truth.size(); ++v) {
        std::vector<uint8_t> a(truth[v].size()), b(truth[v].size());
        for (size_t i = 0; i < a.size(); ++i) a[i] = truth[v][i] == thing, b[i] = found[v][i] == score.label;
        const auto rim_a = boundary(a, width, reach), rim_b = boundary(b, width, reach);
        for (size_t i = 0; i < a.size(); ++i) both += rim_a[i] && rim_b[i], either += rim_a[i] || rim_b[i];
      }
      score.boundary_iou = either ? static_cast<double>(both) / static_cast<double>(either) : 1.0;
    }
    if (score.iou >= 0.5) {
      ++scores.found;
      matched.insert(score.label);
      scores.mean_found_iou += score.iou;
    }
    scores.mean_iou += score.iou;
    scores.mean_boundary_iou += score.boundary_iou;
    scores.things.push_back(score);
  }
  for (const auto& [label, area] : found_area) scores.extra += label != 0 && !matched.contains(label);
  if (!scores.things.empty()) {
    scores.mean_iou /= static_cast<double>(scores.things.size());
    scores.mean_boundary_iou /= static_cast<double>(scores.things.size());
  }
  if (scores.found) scores.mean_found_iou /= static_cast<double>(scores.found);
  return scores;
}

Image paint_labels(const Image& picture, std::span<const uint16_t> labels) {
  Image painted = picture;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == 0) continue;
    const float hue = 2.399963f * static_cast<float>(labels[i]);  // golden angle
    for (int c = 0; c < 3; ++c) {
      const float colour = 0.5f + 0.5f * std::cos(hue + 2.0944f * static_cast<float>(c));
      painted.pixels[4 * i + static_cast<size_t>(c)] =
          0.35f * painted.pixels[4 * i + static_cast<size_t>(c)] + 0.65f * colour;
    }
  }
  return painted;
}

std::vector<Camera> orbit(const Eigen::Vector3d& middle_m, const Eigen::Vector3d& up, double radius_m,
                          size_t count, int width, double first_azimuth_rad, double sweep_rad) {
  const Eigen::Vector3d side = std::abs(up.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d u = (side - up * up.dot(side)).normalized(), v = up.cross(u);
  std::vector<Camera> cameras;
  for (size_t i = 0; i < count; ++i) {
    const double azimuth =
        first_azimuth_rad + sweep_rad * static_cast<double>(i) / static_cast<double>(count);
    const double elevation = i % 2 ? 0.35 : 0.75;
    const Eigen::Vector3d direction =
        std::cos(elevation) * (std::cos(azimuth) * u + std::sin(azimuth) * v) + std::sin(elevation) * up;
    Camera camera = look_at(middle_m + radius_m * direction, middle_m, up, 0.7, width, width * 3 / 4);
    camera.near_m = 0.01;
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace livegs
