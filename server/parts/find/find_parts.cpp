// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "core/percentile.h"
#include "parts/find/claim_rim.h"
#include "parts/find/pixel_labels.h"
#include "parts/find/split_things.h"
#include "parts/find/thing_voxels.h"
#include "parts/graph/kernel_tree.h"
#include "parts/label/label_weights.h"
#include "parts/room_parts.h"
#include "parts/views/choose_cameras.h"

namespace livegs {
namespace {

constexpr size_t kMinRoomKernels = 100;  // fewer form no surface
constexpr int kPointStride = 2;          // pixels between points
constexpr double kMinSeen = 0.1;         // share of pixels that show a surface
constexpr double kLowest = 0.01;         // percentile of the heights of points that counts as the lowest
constexpr double kFootShare = 0.02;  // percentile of the heights of a thing's kernels that counts as its foot
constexpr double kSpread_voxels = 3.0;  // from an unseen kernel to a seen one that gives its label
constexpr double kRest_voxels = 3.0;    // between the foot of a thing and its support

Error stopped() { return {ErrorCode::Unavailable, "parts: cancelled"}; }

Error too_few(size_t kernels) {
  return invalid_data("room: has " + std::to_string(kernels) +
                      " kernels, too few to form a surface; give the splat of a room");
}

// Kernels that no view saw get the label of the nearest one that was seen, if it is near.
void spread_labels(const GaussianAsset& asset, RoomParts& found) {
  std::vector<Eigen::Vector3f> seen;
  std::vector<uint32_t> index;
  for (uint32_t k = 0; k < asset.size(); ++k)
    if (found.share[k] > 0) seen.push_back(asset.positions[k]), index.push_back(k);
  if (seen.empty() || seen.size() == asset.size()) return;
  const KernelTree tree(seen);
  const auto reach_m = static_cast<float>(kSpread_voxels * found.voxel_m);
  parallel_for(asset.size(), 1024, [&](size_t begin, size_t end) {
    std::vector<KernelTree::Neighbour> nearest;
    for (size_t k = begin; k < end; ++k) {
      if (found.share[k] > 0) continue;
      tree.nearest(asset.positions[k], 1, nearest, reach_m);
      if (!nearest.empty()) found.label[k] = found.label[index[nearest[0].index]];
    }
  });
}

void decide_labels(const GaussianAsset& asset, const LabelWeights& weights, RoomParts& found) {
  found.label.assign(asset.size(), kRoomLabel);
  found.share.assign(asset.size(), 0.0f);
  parallel_for(asset.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const LabelWeights::Share most = weights.largest(k);
      found.label[k] = static_cast<uint16_t>(most.label);
      found.share[k] = most.share;
    }
  });
  spread_labels(asset, found);
}

// Colours and numbers of kernels; parts without kernels are removed and the rest renumbered.
void describe_parts(const GaussianAsset& asset, RoomParts& found) {
  for (RoomPart& part : found.parts) part.kernel_count = 0, part.mean_rgb.setZero();
  for (size_t k = 0; k < asset.size(); ++k) {
    if (found.label[k] == kRoomLabel) continue;
    RoomPart& part = found.parts[found.label[k] - 1];
    ++part.kernel_count;
    part.mean_rgb += Eigen::Vector3f::Constant(0.5f) + kShBand0 * asset.sh_dc[k];
  }
  std::vector<uint16_t> renumbered(found.parts.size() + 1, 0);
  std::vector<RoomPart> kept;
  for (RoomPart& part : found.parts) {
    if (part.kernel_count == 0) continue;
    const uint16_t old = part.label;
    part.mean_rgb /= static_cast<float>(part.kernel_count);
    part.label = static_cast<uint16_t>(kept.size() + 1);
    renumbered[old] = part.label;
    kept.push_back(part);
  }
  for (uint16_t& label : found.label) label = renumbered[label];
  for (auto& picture : found.pictures)
    for (uint16_t& label : picture) label = renumbered[label];
  found.parts = std::move(kept);
}

struct SeenRoom {
  PosedKernels posed;
  std::vector<RoomView> views;
  std::vector<ViewPoint> points;
  PartScale scale;
};

Result<SeenRoom> see_room(const GaussianAsset& asset, const PartsOptions& options) {
  SeenRoom room;
  if (asset.size() < kMinRoomKernels) return too_few(asset.size());
  room.posed = pose_in_place(asset);
  const std::vector<Camera> cameras =
      options.cameras.empty() ? choose_cameras(asset, options.up, options.max_views, options.view_width)
                              : thin_cameras(options.cameras, options.max_views, options.view_width);
  if (cameras.empty())
    return invalid_data(
        "room: has no free space with a view of its surfaces; give the cameras of its photos");
  const DrawnObject drawn{&asset, &room.posed, 0};
  KernelRasteriser rasteriser;
  size_t seen = 0, pixels = 0;
  for (size_t v = 0; v < cameras.size(); ++v) {
    if (options.stop.stop_requested()) return stopped();
    if (options.progress)
      options.progress("views", static_cast<double>(v) / static_cast<double>(cameras.size()));
    RoomView view{cameras[v], {}};
    rasteriser.draw(drawn, cameras[v], view.kernels);
    for (float depth : view.kernels.depth_m) seen += std::isfinite(depth);
    pixels += view.kernels.depth_m.size();
    room.views.push_back(std::move(view));
  }
  if (static_cast<double>(seen) < kMinSeen * static_cast<double>(pixels))
    return invalid_data(
        "room: the views show almost no surface; give the cameras of its photos, in the frame of the splat");
  room.points = view_points(room.views, kPointStride);
  room.scale = part_scale(room.points, kPointStride);
  return room;
}

RoomParts planes_of(const SeenRoom& room, const PartsOptions& options) {
  RoomParts found;
  if (options.progress) options.progress("planes", 0);
  found.footprint_m = room.scale.footprint_m;
  found.voxel_m = room.scale.voxel_m;
  found.planes = find_planes(room.points, options.up, room.scale.footprint_m);
  std::vector<double> heights;
  for (const ViewPoint& point : room.points)
    heights.push_back(options.up.dot(point.position_m.cast<double>()));
  found.lowest_m = percentile(std::move(heights), kLowest);
  return found;
}

// The plane on which the kernels of a part end, for parts that came from masks.
void find_supports(const GaussianAsset& asset, RoomParts& found) {
  for (RoomPart& part : found.parts) {
    for (size_t s = 0; s < found.planes.supports.size() && !part.support; ++s) {
      const RoomPlane& plane = found.planes.supports[s];
      std::vector<double> heights;
      size_t over = 0;
      for (size_t k = 0; k < asset.size(); ++k) {
        if (found.label[k] != part.label) continue;
        heights.push_back(plane.height_m(asset.positions[k].cast<double>()));
        over += plane.region.contains(asset.positions[k].cast<double>());
      }
      if (heights.empty() || 2 * over < heights.size()) continue;
      if (std::abs(percentile(std::move(heights), kFootShare)) < kRest_voxels * found.voxel_m)
        part.support = s;
    }
  }
}

}  // namespace

Result<RoomParts> find_parts(const GaussianAsset& asset, const PartsOptions& options) {
  auto room = see_room(asset, options);
  if (!room) return room.error();
  RoomParts found = planes_of(*room, options);
  if (found.planes.supports.empty())
    return invalid_data("room: no floor or table was found; give the up axis of the splat with --up");
  if (options.progress) options.progress("parts", 0);
  ThingVoxels things = thing_voxels(room->points, room->views, found.planes, room->scale);
  split_things(things);
  for (size_t t = 0; t < things.things.size() && t < kMaxParts; ++t) {
    RoomPart part;
    part.label = static_cast<uint16_t>(t + 1);
    part.support = things.things[t].support;
    part.wall = things.things[t].wall;
    part.voxel_count = things.things[t].voxels.size();
    found.parts.push_back(part);
  }
  found.pictures = pixel_labels(room->views, things, found.planes, room->scale);
  for (const RoomView& view : room->views) found.cameras.push_back(view.camera);
  const DrawnObject drawn{&asset, &room->posed, 0};
  LabelWeights weights(asset.size());
  KernelRasteriser rasteriser;
  std::vector<LabelWeight> of_view;
  for (size_t v = 0; v < found.cameras.size(); ++v) {
    if (options.stop.stop_requested()) return stopped();
    if (options.progress)
      options.progress("labels", static_cast<double>(v) / static_cast<double>(found.cameras.size()));
    of_view.clear();
    rasteriser.weigh(drawn, found.cameras[v], found.pictures[v], of_view);
    weights.add(of_view);
  }
  decide_labels(asset, weights, found);
  claim_rim(asset, found);
  describe_parts(asset, found);
  return found;
}

Result<RoomParts> lift_labels(const GaussianAsset& asset, std::vector<LabelPicture> pictures,
                              const PartsOptions& options) {
  if (asset.size() < kMinRoomKernels) return too_few(asset.size());
  if (pictures.empty()) return invalid_argument("masks: none was given");
  auto room = see_room(asset, options);
  if (!room) return room.error();
  RoomParts found = planes_of(*room, options);
  uint16_t most = 0;
  const DrawnObject drawn{&asset, &room->posed, 0};
  LabelWeights weights(asset.size());
  KernelRasteriser rasteriser;
  std::vector<LabelWeight> of_view;
  for (LabelPicture& picture : pictures) {
    for (uint16_t label : picture.labels) most = std::max(most, label);
    of_view.clear();
    rasteriser.weigh(drawn, picture.camera, picture.labels, of_view);
    weights.add(of_view);
    found.cameras.push_back(picture.camera);
    found.pictures.push_back(std::move(picture.labels));
  }
  for (uint16_t label = 1; label <= most; ++label) {
    RoomPart part;
    part.label = label;
    found.parts.push_back(part);
  }
  decide_labels(asset, weights, found);
  describe_parts(asset, found);
  find_supports(asset, found);
  return found;
}

}  // namespace livegs
