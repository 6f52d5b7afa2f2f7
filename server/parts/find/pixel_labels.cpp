// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/find/pixel_labels.h"

#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "parts/label/colour_model.h"

namespace livegs {
namespace {

constexpr double kBelow_voxels = 0.7;       // depth of the foot band below the plane: noise of the depth
constexpr double kFootReach_voxels = 3.3;   // of the foot band around a thing
constexpr double kFootHeight_voxels = 6.0;  // height of a thing that gives the colours of its foot
// Light of the support at a thing, relative to that around it: things shade it.
constexpr float kSupportLights[] = {1.0f, 1.0f, 0.85f, 0.7f, 0.55f};
constexpr double kFootOdds =
    3.0;  // of a thing against its support, for a pixel below the voxels of the thing
constexpr double kRing_voxels = 12.0;  // of the support around a thing that gives its colours

// Labels of things on the ground of a support, in square cells of a voxel's edge, grown by a number of cells.
class GroundMap {
 public:
  GroundMap(const RoomPlane& plane, double cell_m) : plane_(&plane), cell_m_(cell_m) {}

  void add(const Eigen::Vector3d& point_m, uint16_t label) { marks_.push_back({cell_of(point_m), label}); }
  // Every cell gets the label of the nearest mark within `reach` cells.
  void grow(int reach) {
    if (marks_.empty()) return;
    Eigen::Vector2i low = marks_[0].cell, high = low;
    for (const Mark& mark : marks_) low = low.cwiseMin(mark.cell), high = high.cwiseMax(mark.cell);
    low_ = low - Eigen::Vector2i::Constant(reach);
    size_ = high - low + Eigen::Vector2i::Constant(2 * reach + 1);
    nearest_.assign(static_cast<size_t>(size_.x()) * size_.y(), {reach * reach + 1, 0});
    for (const Mark& mark : marks_)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const Eigen::Vector2i c = mark.cell - low_ + Eigen::Vector2i(x, y);
          Nearest& at = nearest_[static_cast<size_t>(c.y()) * size_.x() + c.x()];
          const Nearest mine{x * x + y * y, mark.label};
          if (mine.distance2 < at.distance2 || (mine.distance2 == at.distance2 && mine.label < at.label))
            at = mine;
        }
  }
  // Label of the nearest thing and its squared distance in cells; 0 if none is within reach.
  struct Nearest {
    int distance2;
    uint16_t label;
  };
  Nearest at(const Eigen::Vector3d& point_m) const {
    const Eigen::Vector2i c = cell_of(point_m) - low_;
    if (c.x() < 0 || c.y() < 0 || c.x() >= size_.x() || c.y() >= size_.y()) return {0, 0};
    return nearest_[static_cast<size_t>(c.y()) * size_.x() + c.x()];
  }

 private:
  struct Mark {
    Eigen::Vector2i cell;
    uint16_t label;
  };
  Eigen::Vector2i cell_of(const Eigen::Vector3d& p) const {
    return {static_cast<int>(std::floor(plane_->region.u().dot(p) / cell_m_)),
            static_cast<int>(std::floor(plane_->region.v().dot(p) / cell_m_))};
  }
  const RoomPlane* plane_;
  double cell_m_;
  std::vector<Mark> marks_;
  Eigen::Vector2i low_{0, 0}, size_{0, 0};
  std::vector<Nearest> nearest_;
};

}  // namespace

std::vector<std::vector<uint16_t>> pixel_labels(std::span<const RoomView> views, const ThingVoxels& found,
                                                const RoomPlanes& planes, const PartScale& scale) {
  const VoxelSet& voxels = found.voxels;
  std::vector<uint16_t> label_of_voxel(voxels.size(), 0);
  // Things stand on supports and on walls; both have a foot.
  std::vector<const RoomPlane*> grounds;
  for (const RoomPlane& plane : planes.supports) grounds.push_back(&plane);
  for (const RoomPlane& plane : planes.walls) grounds.push_back(&plane);
  std::vector<GroundMap> maps;
  for (const RoomPlane* plane : grounds) maps.emplace_back(*plane, voxels.edge_m());
  for (size_t t = 0; t < found.things.size(); ++t) {
    const auto label = static_cast<uint16_t>(t + 1);
    for (uint32_t i : found.things[t].voxels) {
      label_of_voxel[i] = label;
      const Eigen::Vector3d p = voxels[i].position_m.cast<double>();
      for (size_t g = 0; g < grounds.size(); ++g) {
        const double height_m = grounds[g]->height_m(p);
        if (height_m > 0 && height_m < kFootReach_voxels * scale.voxel_m) maps[g].add(p, label);
      }
    }
  }
  for (GroundMap& map : maps) map.grow(static_cast<int>(kRing_voxels));

  // The label of the voxel of a point, or of the nearest of its 26 neighbours.
  const auto voxel_label = [&](const Eigen::Vector3d& p) -> uint16_t {
    const Eigen::Vector3i cell = voxels.cell_of(p);
    if (const uint32_t own = voxels.at(cell); own != kNoVoxel && label_of_voxel[own])
      return label_of_voxel[own];
    uint16_t label = 0;
    float nearest = static_cast<float>(2.25 * voxels.edge_m() * voxels.edge_m());
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const uint32_t other = voxels.at(cell + Eigen::Vector3i(x, y, z));
          if (other == kNoVoxel || !label_of_voxel[other]) continue;
          const float distance = (voxels[other].position_m - p.cast<float>()).squaredNorm();
          if (distance < nearest) nearest = distance, label = label_of_voxel[other];
        }
    return label;
  };
  // The ground within whose foot band a point is.
  const auto ground_of = [&](const Eigen::Vector3d& p) -> int {
    for (size_t g = 0; g < grounds.size(); ++g) {
      const double height_m = grounds[g]->height_m(p);
      if (height_m > -kBelow_voxels * scale.voxel_m - 3 * grounds[g]->deviation_m &&
          height_m < scale.foot_m(*grounds[g]) && grounds[g]->region.contains(p))
        return static_cast<int>(g);
    }
    return -1;
  };

  struct FootPixel {
    uint32_t pixel;
    uint16_t label;
    Eigen::Vector3f rgb;
    bool close;
  };
  std::vector<std::vector<uint16_t>> pictures(views.size());
  std::vector<std::vector<FootPixel>> feet(views.size());
  std::vector<std::vector<std::pair<uint16_t, Eigen::Vector3f>>> body(
      views.size());  // label and colour near the ground
  const double close2 = kFootReach_voxels * kFootReach_voxels;
  parallel_for(views.size(), 1, [&](size_t v, size_t) {
    const KernelView& view = views[v].kernels;
    const ViewRays rays(views[v].camera);
    pictures[v].assign(view.depth_m.size(), 0);
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x) {
        const size_t pixel = static_cast<size_t>(y) * view.width + x;
        if (!std::isfinite(view.depth_m[pixel])) continue;
        const Eigen::Vector3d p = rays.point_m(x, y, view.depth_m[pixel]);
        const float* rgba = view.image.at(x, y);
        const Eigen::Vector3f rgb = Eigen::Vector3f(rgba[0], rgba[1], rgba[2]) / std::max(rgba[3], 0.5f);
        const int ground = ground_of(p);
        if (ground < 0) {
          const uint16_t label = pictures[v][pixel] = voxel_label(p);
          if (label == 0) continue;
          for (const RoomPlane* plane : grounds)
            if (plane->height_m(p) < kFootHeight_voxels * scale.voxel_m && plane->height_m(p) > 0) {
              body[v].emplace_back(label, rgb);
              break;
            }
          continue;
        }
        const GroundMap::Nearest near = maps[static_cast<size_t>(ground)].at(p);
        if (near.label == 0) continue;
        feet[v].push_back({static_cast<uint32_t>(pixel), near.label, rgb, near.distance2 <= close2});
      }
  });
  std::vector<ColourModel> of_thing(found.things.size() + 1), of_ring(found.things.size() + 1);
  for (size_t v = 0; v < views.size(); ++v) {
    for (const auto& [label, rgb] : body[v]) of_thing[label].add(rgb);
    for (const FootPixel& foot : feet[v]) {
      if (foot.close) continue;
      for (const float light : kSupportLights) of_ring[foot.label].add(light * foot.rgb);
    }
  }
  for (size_t t = 1; t < of_thing.size(); ++t) of_thing[t].finish(), of_ring[t].finish();
  for (size_t v = 0; v < views.size(); ++v)
    for (const FootPixel& foot : feet[v])
      if (foot.close &&
          of_thing[foot.label].density(foot.rgb) > kFootOdds * of_ring[foot.label].density(foot.rgb))
        pictures[v][foot.pixel] = foot.label;
  return pictures;
}

}  // namespace livegs
