// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/motion/point_motion.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/content_hash.h"
#include "core/text/format_text.h"
#include "scene/build/build_cache.h"
#include "skin/skin_kernels.h"

namespace livegs {
namespace {

// The points on one object, as an asset that is skinned like its kernels.
struct BoundPoints {
  uint32_t object_id = 0;
  RestBody rest;
  GaussianAsset asset;
  std::vector<size_t> indices;  // in PointMotion::points
  KernelBindings bindings;
  PosedKernels posed;
};

}  // namespace

Eigen::Vector3d PointPaths::at(size_t point, double time_s) const {
  const double last = static_cast<double>(ticks() - 1), tick = std::clamp(time_s * rate_hz, 0.0, last);
  const double before = std::min(std::floor(tick), std::max(0.0, last - 1)), s = tick - before;
  const auto position = [&](double k) -> Eigen::Vector3d {
    return positions_m[static_cast<size_t>(std::clamp(before + k, 0.0, last)) * points + point]
        .cast<double>();
  };
  const Eigen::Vector3d a = position(-1), b = position(0), c = position(1), d = position(2);
  return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
}

PointMotion::PointMotion(std::filesystem::path folder, std::string name, std::vector<TrackedPoint> points,
                         std::shared_ptr<BuildCache> cache, SimulationJournal* journal)
    : folder_(std::move(folder)),
      name_(std::move(name)),
      points_(std::move(points)),
      cache_(std::move(cache)),
      journal_(journal) {}

Result<Scene> PointMotion::build(const v1::Scene& file) const {
  SceneOptions options;
  options.cache = cache_;
  options.cut_fragile = false;
  return Scene::build(file, folder_, name_, options);
}

Result<PointPaths> PointMotion::simulate(const v1::Scene& file, double end_s) const {
  if (!journal_) return simulate_now(file, end_s);
  const std::string text = file.SerializeAsString() + format_text("%a", end_s);
  const std::string key = content_hash(std::as_bytes(std::span(text)));
  if (auto known = journal_->find(key)) return *std::move(known);
  auto paths = simulate_now(file, end_s);
  if (paths) journal_->add(key, *paths);
  return paths;
}

Result<PointPaths> PointMotion::simulate_now(const v1::Scene& file, double end_s) const {
  auto scene = build(file);
  if (!scene) return scene.error();
  std::vector<BoundPoints> bound;
  for (const SceneObject& object : scene->objects()) {
    BoundPoints own;
    own.object_id = object.id;
    own.rest = object.rest;
    for (size_t i = 0; i < points_.size(); ++i)
      if (!object.environment && points_[i].object == object.name) own.indices.push_back(i);
    if (own.indices.empty()) continue;
    own.asset.resize(own.indices.size());
    for (size_t i = 0; i < own.indices.size(); ++i) {
      own.asset.positions[i] = points_[own.indices[i]].asset_point;
      own.asset.log_scales[i].setConstant(-10.0f);  // a point
      own.asset.rotations[i].setIdentity();
    }
    auto bindings = bind_kernels(own.asset, own.rest);
    if (!bindings) return Error{bindings.error().code, object.name + ": " + bindings.error().message};
    own.bindings = std::move(*bindings);
    bound.push_back(std::move(own));
  }
  PointPaths paths;
  paths.rate_hz = scene->world().settings().rate_hz;
  paths.points = points_.size();
  const auto ticks = static_cast<size_t>(std::ceil(end_s * paths.rate_hz)) + 1;
  paths.positions_m.resize(ticks * paths.points, Eigen::Vector3f::Zero());
  for (size_t tick = 0; tick < ticks; ++tick) {
    if (tick > 0) scene->step();
    const DriverFrame frame = scene->world().drivers();
    for (BoundPoints& own : bound) {
      const auto drivers =
          std::find_if(frame.objects.begin(), frame.objects.end(),
                       [&](const ObjectDrivers& of) { return of.object_id == own.object_id; });
      if (drivers == frame.objects.end())
        return not_found("object " + std::to_string(own.object_id) + ": left the scene");
      skin_kernels(own.asset, own.rest, own.bindings, *drivers, own.posed);
      for (size_t i = 0; i < own.indices.size(); ++i) {
        const Eigen::Vector3f& at = own.posed.positions_m[i];
        if (!at.allFinite()) return Error{ErrorCode::Internal, "simulation: diverged; raise substeps"};
        paths.positions_m[tick * paths.points + own.indices[i]] = at;
      }
    }
  }
  return paths;
}

}  // namespace livegs
