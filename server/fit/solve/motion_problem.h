// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/fit_quantity.h"
#include "fit/motion/point_motion.h"
#include "fit/point_tracks.h"
#include "splat/camera.h"
#include "splat/project/project_kernels.h"

namespace livegs {

// Least squares between tracked points and those of a simulation, in pixels. Unknowns are the logarithms of
// the parameters, and two of the recording: a factor of all paths in the picture (an error of focal length or
// distance) and a shift in time (the first frame is not exactly at its time).
class MotionProblem {
 public:
  struct Unknowns {
    Eigen::VectorXd log_values;  // one per parameter
    double log_picture_scale = 0, shift_s = 0;
  };

  // `file` is the scene in which the parameters are set. The tracks have the points of `motion`, in its
  // order.
  MotionProblem(const PointMotion& motion, v1::Scene file, std::vector<FitParameter> parameters,
                PointTracks tracks, const Camera& camera);

  const std::vector<FitParameter>& parameters() const { return parameters_; }
  const PointTracks& tracks() const { return tracks_; }
  Unknowns before() const;
  size_t simulations() const { return simulations_; }

  v1::Scene scene_at(const Eigen::VectorXd& log_values) const;
  // Fixes cells and substeps to those that the program chooses at these values, because a change of
  // resolution during a fit would be a discontinuity. With `headroom` there are more substeps. The maximum
  // stiffness of a lattice grows with their square; without headroom, larger values would be clipped to equal
  // results.
  Result<void> choose_resolution(const Eigen::VectorXd& log_values, bool headroom);

  // Tracks to compare: all up to this frame. More frames are more exact but have more false minima.
  void set_frames(size_t frames) { frames_ = std::min(frames, tracks_.frames()); }
  size_t frames() const { return frames_; }

  // Paths in the picture by simulation, displacement since the first frame, as PointTracks. NaN: not seen by
  // the camera. Values are simulated in parallel.
  std::vector<Result<PointPaths>> simulate(std::span<const Eigen::VectorXd> log_values);
  Eigen::Vector2d displacement_px(const PointPaths& paths, size_t point, size_t frame,
                                  const Unknowns& at) const;

  // Robust cost of each object's points, and their number of residuals: sum of log(1 + (r / sd)²) over the
  // sights.
  std::map<std::string, double> cost(const PointPaths& paths, const Unknowns& at, double sd_px) const;
  // Robust standard deviation of a coordinate, px: 1.4826 times the median magnitude, at least kMinSd_px. Of
  // sights that have moved by kMoved_px: points at rest fit for any values.
  double spread_px(const PointPaths& paths, const Unknowns& at) const;

  // Improves the unknowns by Levenberg-Marquardt (Ceres), with Cauchy's loss. A stiffness rises at most to
  // the maximum of the chosen resolution, because larger values give equal results. Calls `step` after each
  // iteration with the unknowns and the spread; false stops.
  using Step = std::function<bool(const Unknowns&, double spread_px)>;
  Result<Unknowns> improve(Unknowns from, int max_iterations, const Step& step);

  // Covariance of the logarithms of the parameters at the solution. Residuals of one track, and of one frame,
  // may have any correlation: clustered by both (Cameron, Gelbach and Miller 2011), without the part counted
  // twice.
  Result<Eigen::MatrixXd> covariance(const Unknowns& at);

  // Precision of tracking, px: smaller residuals are not believed.
  static constexpr double kMinSd_px = 0.1;
  // Displacement at which a point counts as moving, px. Smaller: noise counts; larger: small motions are not
  // seen.
  static constexpr double kMoved_px = 2.0;

 private:
  friend class MotionEvaluation;
  Result<std::vector<PointPaths>> paths_with_steps(const Unknowns& at, bool derivatives);
  double step_of(Eigen::Index i, const Eigen::VectorXd& log_values) const;
  // Standard deviation of the shift: half the time between two frames.
  double shift_sd_s() const { return 0.5 * (tracks_.times_s[1] - tracks_.times_s[0]); }
  void add_rows(const std::vector<PointPaths>& paths, const Unknowns& at, size_t point, size_t frame,
                Eigen::Vector2d& residual, Eigen::Matrix2Xd* derivatives) const;

  const PointMotion& motion_;
  v1::Scene file_;
  std::map<int, v1::Resolution> written_resolution_;  // by index of the object
  std::vector<FitParameter> parameters_;
  PointTracks tracks_;
  Projection projection_;
  size_t frames_ = 0;
  double stiffness_rise_ = 1;  // factor that the chosen resolution reaches
  size_t simulations_ = 0;
};

}  // namespace livegs
