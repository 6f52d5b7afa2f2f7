// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/place_asset.h"

#include <Eigen/Geometry>

#include "analysis/estimate.h"
#include "analysis/knowledge/name_match.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "geometry/reconstruct_surface.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

// Range of the longest side of an asset that may be a metric capture of a household object.
constexpr double kMinObjectSize_m = 0.02;
constexpr double kMaxObjectSize_m = 3.0;
// Factor by which a size may leave the usual range of its name before the metre of a format is doubted.
constexpr double kMaxUnusualSize = 3.0;

double longest_side(const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& point : points) bounds.extend(point);
  return bounds.isEmpty() ? 0.0 : bounds.sizes().maxCoeff();
}

struct Guess {
  double scale;
  std::string reason;
  bool by_name = false;
};

Guess guess_scale(double longest_units, std::string_view name) {
  char reason[200];
  const SizePrior prior = size_prior(name);
  if (prior.best_m > 0) {
    if (longest_units >= prior.low_m && longest_units <= prior.high_m) {
      std::snprintf(reason, sizeof reason, "assumed to be metres: %.3g fits a %s", longest_units,
                    prior.label.c_str());
      return {1.0, reason, true};
    }
    std::snprintf(reason, sizeof reason, "guessed: a %s is about %.3g m long", prior.label.c_str(),
                  prior.best_m);
    return {prior.best_m / longest_units, reason, true};
  }
  if (longest_units >= kMinObjectSize_m && longest_units <= kMaxObjectSize_m) {
    std::snprintf(reason, sizeof reason, "guessed: %.3g units are assumed to be metres", longest_units);
    return {1.0, reason};
  }
  std::snprintf(reason, sizeof reason, "guessed: the name is unknown, the longest side is set to %.3g m",
                kDefaultSize_m);
  return {kDefaultSize_m / longest_units, reason};
}

// Whether a size in metres is impossible for the name.
bool contradicts_name(double longest_m, std::string_view name) {
  const SizePrior prior = size_prior(name);
  return prior.best_m > 0 &&
         (longest_m < prior.low_m / kMaxUnusualSize || longest_m > prior.high_m * kMaxUnusualSize);
}

}  // namespace

Result<PlacedAsset> place_asset(const std::filesystem::path& path, std::string_view name,
                                std::optional<double> scale, std::string_view up, std::string_view field,
                                std::optional<double> assumed_scale, const ReadOptions& read) {
  auto rotation = up_value(up, std::string(field) + ".up");
  if (!rotation) return rotation.error();
  auto file = read_asset(path, read);
  if (!file) return Error{file.error().code, std::string(field) + ".asset: " + file.error().message};
  for (const std::string& note : file->notes) log_warn("%s: %s", path.filename().c_str(), note.c_str());

  if (up.empty()) rotation = up_value(file->frame.up_axis, std::string(field) + ".up");

  if (!file->frame.origin.isZero(0))
    log_info("%s: origin %.10g %.10g %.10g of its positions", path.filename().c_str(), file->frame.origin.x(),
             file->frame.origin.y(), file->frame.origin.z());

  PlacedAsset placed;
  auto asset = std::make_shared<GaussianAsset>(std::move(file->asset));
  placed.object_from_asset.rotation = *rotation;
  placed.up_known = !up.empty() || !file->frame.up_axis.empty();
  placed.body_points_m = body_points(*asset, placed.object_from_asset);
  const double longest = longest_side(placed.body_points_m);
  if (!(longest > 0))
    return invalid_data(std::string(field) + ".asset: " + path.filename().string() +
                        ": no kernel is opaque enough to form a body; raise the opacities");
  if (scale) {
    placed.object_from_asset.scale = *scale;
    placed.scale_known = true;
    placed.scale_reason = "given in the scene file";
  } else if (file->frame.metres_per_unit > 0 &&
             !(file->frame.unit_of_format && contradicts_name(longest, name))) {
    placed.object_from_asset.scale = file->frame.metres_per_unit;
    placed.scale_known = true;
    placed.scale_reason = file->frame.unit_of_format ? "the format is metric" : "the file names its unit";
  } else {
    Guess guess = guess_scale(longest, name);
    placed.scale_by_name = guess.by_name;
    if (assumed_scale && !guess.by_name)
      guess = {*assumed_scale, "guessed: one scale for all assets of the folder"};
    placed.object_from_asset.scale = guess.scale;
    placed.scale_reason = guess.reason;
  }
  for (Eigen::Vector3d& point : placed.body_points_m) point *= placed.object_from_asset.scale;
  placed.asset = std::move(asset);
  return placed;
}

}  // namespace livegs
