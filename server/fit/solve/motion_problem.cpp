// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/solve/motion_problem.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/parallel_for.h"
#include "core/serial_here.h"

namespace livegs {
namespace {

// Step of the logarithm of a parameter for a derivative. Smaller: rounding of contacts; larger: curvature.
constexpr double kDerivativeStep = 0.03;
// Residuals beyond this many standard deviations lose influence (Cauchy's loss; 2.385 is 95 % efficient).
constexpr double kOutlier_sd = 2.385;
// Standard deviation of the error of focal length over distance.
constexpr double kPictureScaleSd = 0.02;

// parallel_for of this thread runs in order while it lives.
struct SerialHere {
  SerialHere() { set_serial_here(true); }
  ~SerialHere() { set_serial_here(false); }
};

// Substeps over those that the program chooses, for headroom. Larger: slower; smaller: less stiffness is in
// reach.
constexpr double kMoreSubsteps = 1.5;
constexpr uint32_t kMaxSubsteps = 1024;  // of a scene file
// Without headroom the program still leaves a little.
constexpr double kRiseWithoutHeadroom = 1.1;

double robust_weight(double squared) { return 1.0 / (1.0 + squared / (kOutlier_sd * kOutlier_sd)); }

}  // namespace

// The simulations behind all residuals. Ceres evaluates many residuals at one point, which is simulated once.
class MotionEvaluation : public ceres::EvaluationCallback {
 public:
  MotionEvaluation(MotionProblem& problem, const MotionProblem::Unknowns& from, double sd_px)
      : problem_(problem),
        sd_px_(sd_px),
        values_(from.log_values),
        recording_{from.log_picture_scale, from.shift_s} {}

  double* values() { return values_.data(); }
  double* recording() { return recording_.data(); }
  double sd_px() const { return sd_px_; }
  const MotionProblem& problem() const { return problem_; }
  MotionProblem::Unknowns unknowns() const { return {values_, recording_[0], recording_[1]}; }
  bool failed() const { return paths_.empty(); }
  const std::vector<PointPaths>& paths() const { return paths_; }
  void rows(size_t point, size_t frame, Eigen::Vector2d& residual, Eigen::Matrix2Xd* derivatives) const {
    problem_.add_rows(paths_, unknowns(), point, frame, residual, derivatives);
  }

  void PrepareForEvaluation(bool derivatives, bool new_point) override {
    (void)new_point;  // also true if only the recording's unknowns are new, which needs no simulation
    if (simulated_.size() == values_.size() && simulated_ == values_ &&
        paths_.size() > (derivatives ? 1u : 0u))
      return;
    auto paths = problem_.paths_with_steps(unknowns(), derivatives);
    paths_.clear();
    simulated_ = values_;
    if (paths) paths_ = std::move(*paths);
  }

 private:
  MotionProblem& problem_;
  double sd_px_;
  Eigen::VectorXd values_, simulated_;
  std::array<double, 2> recording_;
  std::vector<PointPaths> paths_;  // at the values, then with a step of each
};

namespace {

// The residual of one sight of a point, in standard deviations.
class SightCost : public ceres::CostFunction {
 public:
  SightCost(const MotionEvaluation& evaluation, size_t point, size_t frame)
      : evaluation_(evaluation), point_(point), frame_(frame) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(evaluation.problem().parameters().size()));
    mutable_parameter_block_sizes()->push_back(2);
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override;

 private:
  const MotionEvaluation& evaluation_;
  size_t point_, frame_;
};

// (x - mean) / sd of one number of a block.
class BeforeCost : public ceres::CostFunction {
 public:
  BeforeCost(int size, int index, double mean, double sd) : index_(index), mean_(mean), sd_(sd) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(size);
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = (blocks[0][index_] - mean_) / sd_;
    if (jacobians && jacobians[0]) {
      std::fill(jacobians[0], jacobians[0] + parameter_block_sizes()[0], 0.0);
      jacobians[0][index_] = 1.0 / sd_;
    }
    return true;
  }

 private:
  int index_;
  double mean_, sd_;
};

class StepReport : public ceres::IterationCallback {
 public:
  StepReport(const MotionEvaluation& evaluation, const MotionProblem::Step& step)
      : evaluation_(evaluation), step_(step) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0 || !step_ || evaluation_.failed()) return ceres::SOLVER_CONTINUE;
    const auto at = evaluation_.unknowns();
    return step_(at, evaluation_.problem().spread_px(evaluation_.paths().front(), at))
               ? ceres::SOLVER_CONTINUE
               : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  const MotionEvaluation& evaluation_;
  const MotionProblem::Step& step_;
};

}  // namespace

MotionProblem::MotionProblem(const PointMotion& motion, v1::Scene file, std::vector<FitParameter> parameters,
                             PointTracks tracks, const Camera& camera)
    : motion_(motion),
      file_(std::move(file)),
      parameters_(std::move(parameters)),
      tracks_(std::move(tracks)),
      projection_(camera),
      frames_(tracks_.frames()) {
  for (int i = 0; i < file_.objects_size(); ++i)
    if (file_.objects(i).has_resolution()) written_resolution_[i] = file_.objects(i).resolution();
}

MotionProblem::Unknowns MotionProblem::before() const {
  Unknowns at;
  at.log_values.resize(static_cast<Eigen::Index>(parameters_.size()));
  for (size_t i = 0; i < parameters_.size(); ++i)
    at.log_values[static_cast<Eigen::Index>(i)] = std::log(parameters_[i].before);
  return at;
}

v1::Scene MotionProblem::scene_at(const Eigen::VectorXd& log_values) const {
  v1::Scene scene = file_;
  for (size_t i = 0; i < parameters_.size(); ++i) {
    for (v1::Object& object : *scene.mutable_objects())
      if (object.name() == parameters_[i].object)
        set_quantity(object, parameters_[i].quantity, std::exp(log_values[static_cast<Eigen::Index>(i)]));
  }
  return scene;
}

Result<void> MotionProblem::choose_resolution(const Eigen::VectorXd& log_values, bool headroom) {
  v1::Scene chosen = scene_at(log_values);
  for (v1::Object& object : *chosen.mutable_objects()) object.clear_resolution();
  for (int i = 0; i < chosen.objects_size(); ++i) {
    // Settings of the scene file stay.
    if (written_resolution_.count(i))
      *chosen.mutable_objects(i)->mutable_resolution() = written_resolution_.at(i);
  }
  stiffness_rise_ = headroom ? kMoreSubsteps * kMoreSubsteps : kRiseWithoutHeadroom;
  auto scene = motion_.build(chosen);
  if (!scene) return scene.error();
  for (int i = 0; i < file_.objects_size(); ++i) {
    v1::Object& object = *file_.mutable_objects(i);
    const SceneObject* built = scene->find_in_file(object.name());
    if (!built || !built->elastic || built->elastic->cell_width_m <= 0) continue;
    v1::Resolution resolution;
    resolution.set_cell_width_m(built->elastic->cell_width_m);
    const auto scene_substeps = static_cast<uint32_t>(scene->world().settings().substeps);
    const double wanted = (headroom ? kMoreSubsteps : 1.0) * built->elastic->substeps / scene_substeps;
    resolution.set_substeps(
        std::min(kMaxSubsteps, scene_substeps * static_cast<uint32_t>(std::ceil(wanted))));
    *object.mutable_resolution() = resolution;
  }
  return {};
}

std::vector<Result<PointPaths>> MotionProblem::simulate(std::span<const Eigen::VectorXd> log_values) {
  const double end_s = tracks_.times_s[frames_ - 1] + (tracks_.times_s[1] - tracks_.times_s[0]);
  std::vector<Result<PointPaths>> results(log_values.size(), Result<PointPaths>(PointPaths{}));
  simulations_ += log_values.size();
  if (log_values.size() == 1) {
    results[0] = motion_.simulate(scene_at(log_values[0]), end_s);
    return results;
  }
  parallel_for(log_values.size(), 1, [&](size_t i, size_t) {
    const SerialHere one_simulation_a_core;
    results[i] = motion_.simulate(scene_at(log_values[i]), end_s);
  });
  return results;
}

Result<std::vector<PointPaths>> MotionProblem::paths_with_steps(const Unknowns& at, bool derivatives) {
  std::vector<Eigen::VectorXd> places = {at.log_values};
  for (Eigen::Index i = 0; derivatives && i < at.log_values.size(); ++i) {
    places.push_back(at.log_values);
    places.back()[i] += step_of(i, at.log_values);
  }
  std::vector<PointPaths> paths;
  for (auto& result : simulate(places)) {
    if (!result) return result.error();
    paths.push_back(std::move(*result));
  }
  return paths;
}

// Towards the inside at an upper limit.
double MotionProblem::step_of(Eigen::Index i, const Eigen::VectorXd& log_values) const {
  return log_values[i] + kDerivativeStep > std::log(parameters_[static_cast<size_t>(i)].highest)
             ? -kDerivativeStep
             : kDerivativeStep;
}

Eigen::Vector2d MotionProblem::displacement_px(const PointPaths& paths, size_t point, size_t frame,
                                               const Unknowns& at) const {
  const auto project = [&](const Eigen::Vector3d& world_m) -> Eigen::Vector2d {
    const Eigen::Vector3d t = projection_.image_from_world * (world_m - projection_.position_m);
    const double depth_m = std::max(t.z(), projection_.near_m);
    return {projection_.focal_x_px * t.x() / depth_m, projection_.focal_y_px * t.y() / depth_m};
  };
  return std::exp(at.log_picture_scale) * (project(paths.at(point, tracks_.times_s[frame] + at.shift_s)) -
                                           project(paths.at(point, tracks_.times_s[0])));
}

std::map<std::string, double> MotionProblem::cost(const PointPaths& paths, const Unknowns& at,
                                                  double sd_px) const {
  std::map<std::string, double> cost;
  for (size_t point = 0; point < tracks_.points(); ++point) {
    double& sum = cost[motion_.points()[point].object];
    for (size_t frame = 1; frame < frames_; ++frame) {
      if (std::isnan(tracks_.at(point, frame).x())) continue;
      const Eigen::Vector2d seen = tracks_.at(point, frame) - tracks_.at(point, 0);
      sum += std::log1p((displacement_px(paths, point, frame, at) - seen).squaredNorm() / (sd_px * sd_px));
    }
  }
  return cost;
}

double MotionProblem::spread_px(const PointPaths& paths, const Unknowns& at) const {
  std::vector<double> magnitudes;
  for (size_t point = 0; point < tracks_.points(); ++point) {
    for (size_t frame = 1; frame < frames_; ++frame) {
      const Eigen::Vector2d seen = tracks_.at(point, frame) - tracks_.at(point, 0);
      if (!(seen.norm() > kMoved_px)) continue;
      const Eigen::Vector2d miss = displacement_px(paths, point, frame, at) - seen;
      magnitudes.push_back(std::abs(miss.x()));
      magnitudes.push_back(std::abs(miss.y()));
    }
  }
  if (magnitudes.empty()) return kMinSd_px;
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return std::max(kMinSd_px, 1.4826 * *middle);
}

// Residual in px and its derivatives by the parameters, the scale and the shift (columns).
void MotionProblem::add_rows(const std::vector<PointPaths>& paths, const Unknowns& at, size_t point,
                             size_t frame, Eigen::Vector2d& residual, Eigen::Matrix2Xd* derivatives) const {
  const Eigen::Vector2d simulated = displacement_px(paths[0], point, frame, at);
  residual = simulated - (tracks_.at(point, frame) - tracks_.at(point, 0));
  if (!derivatives) return;
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  derivatives->resize(2, count + 2);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d stepped = displacement_px(paths[static_cast<size_t>(i) + 1], point, frame, at);
    derivatives->col(i) = (stepped - simulated) / step_of(i, at.log_values);
  }
  derivatives->col(count) = simulated;
  const double half_tick_s = 0.5 / paths[0].rate_hz;
  Unknowns earlier = at, later = at;
  earlier.shift_s -= half_tick_s;
  later.shift_s += half_tick_s;
  derivatives->col(count + 1) =
      (displacement_px(paths[0], point, frame, later) - displacement_px(paths[0], point, frame, earlier)) /
      (2 * half_tick_s);
}

bool SightCost::Evaluate(double const* const*, double* residuals, double** jacobians) const {
  if (evaluation_.failed()) return false;
  Eigen::Vector2d residual;
  Eigen::Matrix2Xd derivatives;
  evaluation_.rows(point_, frame_, residual, jacobians ? &derivatives : nullptr);
  const double by = 1.0 / evaluation_.sd_px();
  Eigen::Map<Eigen::Vector2d> written(residuals);
  written = by * residual;
  if (!jacobians) return true;
  const Eigen::Index count = derivatives.cols() - 2;
  using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  if (jacobians[0]) Eigen::Map<Rows>(jacobians[0], 2, count) = by * derivatives.leftCols(count);
  if (jacobians[1]) Eigen::Map<Rows>(jacobians[1], 2, 2) = by * derivatives.rightCols(2);
  return true;
}

Result<MotionProblem::Unknowns> MotionProblem::improve(Unknowns from, int max_iterations, const Step& step) {
  auto paths = paths_with_steps(from, false);
  if (!paths) return paths.error();
  MotionEvaluation evaluation(*this, from, spread_px(paths->front(), from));
  StepReport report(evaluation, step);
  ceres::Problem::Options ownership;
  ownership.evaluation_callback = &evaluation;
  ceres::Problem problem(ownership);
  const int count = static_cast<int>(parameters_.size());
  ceres::LossFunction* const loss = new ceres::CauchyLoss(kOutlier_sd);  // owned by the problem
  for (size_t point = 0; point < tracks_.points(); ++point) {
    for (size_t frame = 1; frame < frames_; ++frame) {
      if (std::isnan(tracks_.at(point, frame).x())) continue;
      problem.AddResidualBlock(new SightCost(evaluation, point, frame), loss, evaluation.values(),
                               evaluation.recording());
    }
  }
  for (int i = 0; i < count; ++i) {
    const FitParameter& parameter = parameters_[static_cast<size_t>(i)];
    problem.AddResidualBlock(new BeforeCost(count, i, std::log(parameter.before), parameter.before_sd),
                             nullptr, evaluation.values());
    problem.SetParameterLowerBound(evaluation.values(), i, std::log(parameter.lowest));
    const double reached = parameter.quantity == FitQuantity::YoungsModulus
                               ? from.log_values[i] + std::log(stiffness_rise_)
                               : std::log(parameter.highest);
    problem.SetParameterUpperBound(evaluation.values(), i, std::min(std::log(parameter.highest), reached));
  }
  problem.AddResidualBlock(new BeforeCost(2, 0, 0.0, kPictureScaleSd), nullptr, evaluation.recording());
  problem.AddResidualBlock(new BeforeCost(2, 1, 0.0, shift_sd_s()), nullptr, evaluation.recording());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-5;
  options.parameter_tolerance = 1e-4;
  options.initial_trust_region_radius = 1e2;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.update_state_every_iteration = true;
  options.callbacks.push_back(&report);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (summary.termination_type == ceres::FAILURE)
    return Error{ErrorCode::Internal, "fit: the least squares failed: " + summary.message};
  return evaluation.unknowns();
}

Result<Eigen::MatrixXd> MotionProblem::covariance(const Unknowns& at) {
  auto paths = paths_with_steps(at, true);
  if (!paths) return paths.error();
  const double sd_px = spread_px(paths->front(), at);
  const auto count = static_cast<Eigen::Index>(parameters_.size()), all = count + 2;
  Eigen::MatrixXd before = Eigen::MatrixXd::Zero(all, all);
  for (Eigen::Index i = 0; i < count; ++i)
    before(i, i) = std::pow(parameters_[static_cast<size_t>(i)].before_sd, -2);
  before(count, count) = std::pow(kPictureScaleSd, -2);
  before(count + 1, count + 1) = std::pow(shift_sd_s(), -2);
  Eigen::MatrixXd information = before;
  Eigen::MatrixXd of_tracks = Eigen::MatrixXd::Zero(all, all), of_sights = of_tracks, of_frames = of_tracks;
  std::vector<Eigen::VectorXd> frame_scores(frames_, Eigen::VectorXd::Zero(all));
  for (size_t point = 0; point < tracks_.points(); ++point) {
    Eigen::VectorXd track_score = Eigen::VectorXd::Zero(all);
    for (size_t frame = 1; frame < frames_; ++frame) {
      if (std::isnan(tracks_.at(point, frame).x())) continue;
      Eigen::Vector2d residual;
      Eigen::Matrix2Xd derivatives;
      add_rows(*paths, at, point, frame, residual, &derivatives);
      residual /= sd_px;
      derivatives /= sd_px;
      const double weight = robust_weight(residual.squaredNorm());
      information += weight * derivatives.transpose() * derivatives;
      const Eigen::VectorXd score = weight * derivatives.transpose() * residual;
      track_score += score;
      frame_scores[frame] += score;
      of_sights += score * score.transpose();
    }
    of_tracks += track_score * track_score.transpose();
  }
  for (const Eigen::VectorXd& score : frame_scores) of_frames += score * score.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(of_tracks + of_frames - of_sights);
  const Eigen::MatrixXd scores = spread.eigenvectors() * spread.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                 spread.eigenvectors().transpose();
  const Eigen::MatrixXd inverse = information.ldlt().solve(Eigen::MatrixXd::Identity(all, all));
  return Eigen::MatrixXd((inverse * (scores + before) * inverse).topLeftCorner(count, count));
}

}  // namespace livegs
