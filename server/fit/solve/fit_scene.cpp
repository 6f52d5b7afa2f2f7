// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/fit_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/text/format_text.h"
#include "fit/solve/first_frame.h"
#include "fit/solve/motion_problem.h"
#include "scene/build/build_cache.h"

namespace livegs {
namespace {

// Search of the first parameter of each object before least squares: all values at a constant ratio, of a
// stiffness within kSearchRange of its value before. A period of the motion changes by a fifth between two of
// them, so that one is within the first swings of the right one. Smaller: more simulations.
constexpr double kSearchRatio = 1.45;
constexpr double kSearchRange = 300.0;
// Part of the moving frames that is compared in the search, and then in turn by least squares.
constexpr double kHorizons[] = {0.25, 0.5, 1.0};
// Starts of least squares: the best minima of the search.
constexpr size_t kStarts = 2;
constexpr int kIterations = 10;
// Standard deviation of a coordinate in the search, px: about a tenth of the motion that it compares.
constexpr double kSearchSd_px = 2.0;
// Factor within which a simulation has a stiffness or a loss factor, nine times in ten (ElasticBand::Exact).
constexpr double kMethodRange = 1.05;
// If stiffness and mass by kJointFactor together move the paths by less than kUnseenChange of the change by
// the stiffness alone, only their ratio is measured.
constexpr double kJointFactor = 1.3, kUnseenChange = 0.1;

// Largest distance of a tracked point from the picture's corner, over the longer side, without an error.
constexpr double kMaxOutside = 10.0;
// Part of the uncertainty that a recording takes away from a value that it shows; others stay as they were.
constexpr double kShown = 0.5;
// Spread over that of the values before, above which the search has found nothing.
constexpr double kNoBetter = 0.9;

using Unknowns = MotionProblem::Unknowns;

// The first frame in which enough points of an object have moved.
Result<size_t> first_moving_frame(const PointTracks& tracks, const std::vector<TrackedPoint>& points,
                                  const std::string& object) {
  for (size_t frame = 1; frame < tracks.frames(); ++frame) {
    size_t moving = 0;
    for (size_t point = 0; point < tracks.points(); ++point)
      moving += points[point].object == object &&
                (tracks.at(point, frame) - tracks.at(point, 0)).norm() > MotionProblem::kMoved_px;
    if (moving >= kMinFitPoints) return frame;
  }
  return invalid_data(object +
                      ": does not move by more than two pixels in the recording; there is nothing to fit");
}

struct SearchGrid {
  Eigen::Index parameter;  // the first of its object
  std::vector<double> log_values;
  std::vector<double> costs;
  std::vector<size_t> best;  // local minima, the lowest first
};

std::vector<SearchGrid> search_grids(const std::vector<FitParameter>& parameters) {
  std::vector<SearchGrid> grids;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (i > 0 && parameters[i].object == parameters[i - 1].object) continue;
    const FitParameter& lead = parameters[i];
    SearchGrid grid{static_cast<Eigen::Index>(i), {}, {}, {}};
    const bool wide = lead.quantity == FitQuantity::YoungsModulus || lead.quantity == FitQuantity::Mass;
    const double low = wide ? std::max(lead.lowest, lead.before / kSearchRange) : lead.lowest;
    const double high = wide ? std::min(lead.highest, lead.before * kSearchRange) : lead.highest;
    const auto steps = static_cast<size_t>(std::ceil(std::log(high / low) / std::log(kSearchRatio)));
    for (size_t k = 0; k <= steps; ++k)
      grid.log_values.push_back(std::log(low) +
                                std::log(high / low) * static_cast<double>(k) / static_cast<double>(steps));
    grids.push_back(std::move(grid));
  }
  return grids;
}

class SceneFit {
 public:
  SceneFit(MotionProblem& problem, const FitProgress& progress) : problem_(problem), progress_(progress) {}

  bool stopped() const { return stopped_; }

  Result<std::vector<Unknowns>> search(size_t frames) {
    problem_.set_frames(frames);
    std::vector<SearchGrid> grids = search_grids(problem_.parameters());
    size_t count = 0;
    for (const SearchGrid& grid : grids) count = std::max(count, grid.log_values.size());
    std::vector<Eigen::VectorXd> places;
    for (size_t k = 0; k < count; ++k) {
      places.push_back(problem_.before().log_values);
      for (const SearchGrid& grid : grids)
        places.back()[grid.parameter] = grid.log_values[std::min(k, grid.log_values.size() - 1)];
    }
    std::optional<Error> error;
    const size_t block = 8;
    for (size_t k = 0; k < count && !stopped_; k += block) {
      report(format_text("search: %zu of %zu values", k, count));
      auto results = problem_.simulate(std::span(places).subspan(k, std::min(block, count - k)));
      for (size_t j = 0; j < results.size(); ++j) {
        std::map<std::string, double> costs;
        if (results[j]) {
          costs = problem_.cost(*results[j], problem_.before(), kSearchSd_px);
        } else if (!error) {
          error = results[j].error();
        }
        for (SearchGrid& grid : grids) {
          if (k + j >= grid.log_values.size()) continue;
          const auto own = costs.find(problem_.parameters()[static_cast<size_t>(grid.parameter)].object);
          grid.costs.push_back(own == costs.end() ? std::numeric_limits<double>::infinity() : own->second);
        }
      }
    }
    for (SearchGrid& grid : grids) {
      const std::vector<double>& costs = grid.costs;
      for (size_t k = 0; k < costs.size(); ++k) {
        if (std::isinf(costs[k]) || (k > 0 && costs[k - 1] < costs[k]) ||
            (k + 1 < costs.size() && costs[k + 1] <= costs[k]))
          continue;
        grid.best.push_back(k);
      }
      std::stable_sort(grid.best.begin(), grid.best.end(),
                       [&](size_t a, size_t b) { return costs[a] < costs[b]; });
      if (grid.best.empty())
        return error.value_or(Error{ErrorCode::Internal, "fit: no value could be simulated"});
    }
    std::vector<Unknowns> starts;
    for (size_t rank = 0; rank < kStarts; ++rank) {
      Unknowns start = problem_.before();
      bool different = rank == 0;
      for (const SearchGrid& grid : grids) {
        different |= rank < grid.best.size();
        start.log_values[grid.parameter] = grid.log_values[grid.best[std::min(rank, grid.best.size() - 1)]];
      }
      if (different) starts.push_back(start);
    }
    return starts;
  }

  Result<Unknowns> refine(Unknowns at, size_t first_moving) {
    const size_t all = problem_.tracks().frames();
    for (const double horizon : kHorizons) {
      problem_.set_frames(first_moving +
                          static_cast<size_t>(std::ceil(horizon * static_cast<double>(all - first_moving))));
      if (auto chosen = problem_.choose_resolution(at.log_values, true); !chosen) return chosen.error();
      auto better = problem_.improve(at, kIterations, step());
      if (!better) return better.error();
      at = *better;
      if (stopped_) return at;
    }
    // At the resolution that the scene will have.
    if (auto chosen = problem_.choose_resolution(at.log_values, false); !chosen) return chosen.error();
    auto last = problem_.improve(at, kIterations, step());
    if (!last) return last.error();
    auto paths = problem_.simulate(std::array{at.log_values, last->log_values});
    if (!paths[0] || !paths[1]) return at;
    const double sd_px = problem_.spread_px(*paths[0], at);
    double gain = 0;
    for (const auto& [object, cost] : problem_.cost(*paths[0], at, sd_px)) gain += cost;
    for (const auto& [object, cost] : problem_.cost(*paths[1], *last, sd_px)) gain -= cost;
    return gain > 0 ? *last : at;
  }

  MotionProblem::Step step() {
    return [this](const Unknowns& at, double spread_px) {
      std::string line = "least squares: ";
      for (size_t i = 0; i < problem_.parameters().size(); ++i)
        line += format_text("%s%s %.4g", i > 0 ? ", " : "", names_of(problem_.parameters()[i].quantity).name,
                            std::exp(at.log_values[static_cast<Eigen::Index>(i)]));
      report(line +
             format_text(" over %.2f s; %.2f px apart",
                         problem_.tracks().times_s[problem_.frames() - 1] - problem_.tracks().times_s[0],
                         spread_px));
      return !stopped_;
    };
  }

 private:
  void report(const std::string& line) {
    if (progress_ && !progress_(line)) stopped_ = true;
  }

  MotionProblem& problem_;
  const FitProgress& progress_;
  bool stopped_ = false;
};

PointTracks simulated_tracks(const MotionProblem& problem, const PointPaths& paths, const Unknowns& at) {
  PointTracks tracks = problem.tracks();
  for (size_t point = 0; point < tracks.points(); ++point)
    for (size_t frame = 1; frame < tracks.frames(); ++frame)
      tracks.positions_px[point * tracks.frames() + frame] =
          tracks.at(point, 0) + problem.displacement_px(paths, point, frame, at);
  return tracks;
}

double squared_distance(const PointTracks& a, const PointTracks& b) {
  double sum = 0;
  for (size_t k = 0; k < a.positions_px.size(); ++k)
    sum += (a.positions_px[k] - b.positions_px[k]).squaredNorm();
  return sum;
}

}  // namespace

Result<FitResult> fit_scene(const FitRequest& request, const PointTracks& tracks,
                            const FitProgress& progress) {
  const auto cache = std::make_shared<BuildCache>();
  const double limit_px = kMaxOutside * std::max(request.camera.width, request.camera.height);
  for (size_t k = 0; k < tracks.positions_px.size(); ++k) {
    const Eigen::Vector2d& px = tracks.positions_px[k];
    if (px.cwiseAbs().maxCoeff() > limit_px)
      return invalid_data(format_text(
          "tracks: point %zu is at (%.6g, %.6g) px, far outside of the picture; correct or remove it",
          k / tracks.frames(), px.x(), px.y()));
  }
  auto first = first_frame(request, tracks.times_s[0], cache, progress);
  if (!first) return first.error();

  // The points that show an object, with their tracks.
  PointTracks kept;
  std::vector<TrackedPoint> points;
  for (const double time_s : tracks.times_s)
    if (time_s - tracks.times_s[0] <= request.max_seconds) kept.times_s.push_back(time_s);
  for (size_t point = 0; point < tracks.points(); ++point) {
    const auto at = first->view.at(tracks.at(point, 0));
    if (!at) continue;
    points.push_back(*at);
    for (size_t frame = 0; frame < kept.frames(); ++frame)
      kept.positions_px.push_back(tracks.at(point, frame));
  }
  size_t first_moving = kept.frames();
  for (const std::string& object : first->objects) {
    const auto count = static_cast<size_t>(std::count_if(
        points.begin(), points.end(), [&](const TrackedPoint& point) { return point.object == object; }));
    if (count < kMinFitPoints)
      return invalid_data(
          format_text("tracks: %zu points are on %s in the first frame, and %zu are needed; check the "
                      "camera and the time of the first frame",
                      count, object.c_str(), kMinFitPoints));
    auto moving = first_moving_frame(kept, points, object);
    if (!moving) return moving.error();
    first_moving = std::min(first_moving, *moving);
  }
  if (kept.frames() < first_moving + 3)
    return invalid_data("tracks: the motion is seen in fewer than three frames; give a longer recording");

  FitResult result;
  const PointMotion motion(request.scene.folder, request.scene.name, points, cache, request.journal);
  MotionProblem problem(motion, first->file, first->parameters, kept, request.camera);
  SceneFit fit(problem, progress);
  const Unknowns before = problem.before();
  const auto horizon =
      first_moving +
      static_cast<size_t>(std::ceil(kHorizons[0] * static_cast<double>(kept.frames() - first_moving)));
  auto starts = fit.search(horizon);
  if (!starts) return starts.error();
  struct Refined {
    Unknowns at;
    PointPaths paths;
    double spread_px;
  };
  std::vector<Refined> refined;
  std::optional<Error> failed;  // of a start; another one may succeed
  for (const Unknowns& start : *starts) {
    if (!refined.empty() && fit.stopped()) break;
    auto at = fit.stopped() ? Result<Unknowns>(start) : fit.refine(start, first_moving);
    problem.set_frames(kept.frames());
    auto chosen = at ? problem.choose_resolution(at->log_values, false) : Result<void>(at.error());
    if (!chosen) {
      failed = chosen.error();
      continue;
    }
    auto paths = problem.simulate(std::span(&at->log_values, 1));
    if (!paths[0]) {
      failed = paths[0].error();
      continue;
    }
    const double spread_px = problem.spread_px(*paths[0], *at);
    refined.push_back({*at, *std::move(paths[0]), spread_px});
  }
  if (refined.empty()) return *failed;
  // The lowest cost by one measure.
  const auto sharpest =
      std::min_element(refined.begin(), refined.end(),
                       [](const Refined& a, const Refined& b) { return a.spread_px < b.spread_px; });
  const auto cost_of = [&](const Refined& one) {
    double sum = 0;
    for (const auto& [object, own] : problem.cost(one.paths, one.at, sharpest->spread_px)) sum += own;
    return sum;
  };
  const Refined& chosen_fit =
      *std::min_element(refined.begin(), refined.end(),
                        [&](const Refined& a, const Refined& b) { return cost_of(a) < cost_of(b); });
  const Unknowns* const best = &chosen_fit.at;
  result.spread_px = chosen_fit.spread_px;
  result.simulated = simulated_tracks(problem, chosen_fit.paths, *best);
  if (auto chosen = problem.choose_resolution(best->log_values, true); !chosen) return chosen.error();
  auto covariance = problem.covariance(*best);
  if (!covariance) return covariance.error();
  result.scene = problem.scene_at(best->log_values);
  auto fitted = motion.build(result.scene);
  if (!fitted) return fitted.error();
  for (size_t i = 0; i < problem.parameters().size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const FitParameter& parameter = problem.parameters()[i];
    const double variance = (*covariance)(k, k), before_variance = std::pow(parameter.before_sd, 2);
    const double sd = std::hypot(std::sqrt(variance), std::log(kMethodRange) / kHalfRange_sd);
    FittedValue value;
    value.parameter = parameter;
    value.best = std::exp(best->log_values[k]);
    value.low = std::max(parameter.lowest, value.best * std::exp(-kHalfRange_sd * sd));
    value.high = std::min(parameter.highest, value.best * std::exp(kHalfRange_sd * sd));
    value.shown = std::clamp(1.0 - variance / before_variance, 0.0, 1.0);
    if (parameter.asked && value.shown < kShown)
      result.notes.push_back(
          format_text("%s: the recording does not determine %s; the prior value and its range apply",
                      parameter.object.c_str(), names_of(parameter.quantity).name));
    if (value.best <= parameter.lowest * 1.01 || value.best >= parameter.highest * 0.99)
      result.notes.push_back(format_text("%s: %s is at the limit of the search", parameter.object.c_str(),
                                         names_of(parameter.quantity).name));
    result.values.push_back(std::move(value));
  }
  for (const std::string& name : first->objects) {
    const SceneObject& object = *fitted->find_in_file(name);
    if (!object.elastic) continue;
    if (object.elastic->band == ElasticBand::Band)
      result.notes.push_back(format_text(
          "%s: youngs_modulus_pa is the value for this scene; the lattice has %.2g to %.2g times the "
          "modulus of the material",
          name.c_str(), object.elastic->modulus_ratio_low, object.elastic->modulus_ratio_high));
    if (object.elastic->clipped)
      result.notes.push_back(name +
                             ": the stiffness is above the maximum of the lattice; its range is unknown");
    // Stiffness and mass by the same factor: the motion is the same unless a known force acts.
    const double stiffness =
        object.physics.structure_coefficient().best() * object.physics.youngs_modulus_pa().best();
    const auto simulated = [&](double stiffness_factor, double mass_factor) {
      v1::Scene file = result.scene;
      for (v1::Object& written : *file.mutable_objects()) {
        if (written.name() != name) continue;
        set_quantity(written, FitQuantity::YoungsModulus, stiffness_factor * stiffness);
        set_quantity(written, FitQuantity::Mass, mass_factor * object.physics.mass_kg().best());
      }
      return motion.simulate(file, kept.times_s.back());
    };
    const auto found = simulated(1, 1), stiffer = simulated(kJointFactor, 1),
               both = simulated(kJointFactor, kJointFactor);
    if (!found || !stiffer || !both) continue;
    const PointTracks paths = simulated_tracks(problem, *found, *best);
    const double by_stiffness = squared_distance(paths, simulated_tracks(problem, *stiffer, *best));
    const double by_both = squared_distance(paths, simulated_tracks(problem, *both, *best));
    const double seen =
        MotionProblem::kMinSd_px * MotionProblem::kMinSd_px * static_cast<double>(paths.positions_px.size());
    if (by_stiffness > seen && by_both < kUnseenChange * kUnseenChange * by_stiffness)
      result.notes.push_back(
          format_text("%s: the recording shows only youngs_modulus_pa / mass_kg, as no known force acts; the "
                      "mass of %.3g kg (%s) is kept",
                      name.c_str(), object.physics.mass_kg().best(), first->mass_source.at(name).c_str()));
  }
  auto paths_before = problem.simulate(std::span(&before.log_values, 1));
  if (paths_before[0]) {
    result.spread_before_px = problem.spread_px(*paths_before[0], before);
    if (result.spread_px > MotionProblem::kMoved_px && result.spread_px > kNoBetter * result.spread_before_px)
      result.notes.push_back(
          "the paths are not closer than with the initial values; check the video, the camera and the loads "
          "on the objects");
  }
  result.picture_scale = std::exp(best->log_picture_scale);
  result.shift_s = best->shift_s;
  result.simulations = problem.simulations();
  result.measured = std::move(kept);
  // The scene for the user: the request's, with the values.
  v1::Scene file = request.scene.file;
  for (int i = 0; i < file.objects_size(); ++i) {
    for (const FittedValue& value : result.values)
      if (value.parameter.asked && value.shown >= kShown &&
          value.parameter.object == first->file.objects(i).name())
        set_quantity(*file.mutable_objects(i), value.parameter.quantity, value.best);
  }
  result.scene = std::move(file);
  return result;
}

}  // namespace livegs
