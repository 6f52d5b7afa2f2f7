// SPDX-License-Identifier: GPL-3.0-or-later
#include "fit/tracks/point_tracker.h"

#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace livegs {
namespace {

// Side of the patch that is compared, px. Larger: fewer wrong matches, but patches bend with the object.
constexpr int kPatch_px = 11;
// Halvings of the picture. A point may move by about kPatch_px * 2^kLevels / 2 between two frames.
constexpr int kLevels = 4;
// Distance between a point and its track back, px; above it the match is wrong. Kalal et al. 2010.
constexpr float kMaxReturn_px = 0.5f;
// Weakest corner over the strongest. Lower: more points, on smoother places with larger errors.
constexpr double kCornerQuality = 0.003;
// Smallest gradient of a patch, the least eigenvalue of its matrix a pixel. Flat patches drift.
constexpr double kMinEigenvalue = 1e-4;

cv::Mat matrix_of(const GreyPicture& picture) {
  return cv::Mat(picture.height, picture.width, CV_8UC1, const_cast<uint8_t*>(picture.pixels.data()));
}

// OpenCV has (0, 0) at the centre of the first pixel, Camera (0.5, 0.5).
cv::Point2f opencv_point(const Eigen::Vector2d& px) {
  return {static_cast<float>(px.x() - 0.5), static_cast<float>(px.y() - 0.5)};
}
Eigen::Vector2d camera_point(const cv::Point2f& point) { return {point.x + 0.5, point.y + 0.5}; }

}  // namespace

std::vector<Eigen::Vector2d> trackable_corners(const GreyPicture& picture, std::span<const uint8_t> mask,
                                               double apart_px, size_t count) {
  cv::setNumThreads(1);  // the same bits for any number of cores
  std::vector<cv::Point2f> found;
  const cv::Mat allowed(picture.height, picture.width, CV_8UC1, const_cast<uint8_t*>(mask.data()));
  cv::goodFeaturesToTrack(matrix_of(picture), found, static_cast<int>(count), kCornerQuality, apart_px,
                          allowed, 5);
  std::vector<Eigen::Vector2d> corners;
  for (const cv::Point2f& point : found) corners.push_back(camera_point(point));
  return corners;
}

struct PointTracker::Pictures {
  std::vector<cv::Mat> last, next;  // pyramids
  static void build(const GreyPicture& picture, std::vector<cv::Mat>& pyramid) {
    pyramid.clear();
    cv::buildOpticalFlowPyramid(matrix_of(picture).clone(), pyramid, {kPatch_px, kPatch_px}, kLevels);
  }
};

PointTracker::PointTracker(const GreyPicture& first, std::span<const Eigen::Vector2d> points_px)
    : pictures_(std::make_unique<Pictures>()), points_px_(points_px.begin(), points_px.end()) {
  cv::setNumThreads(1);
  Pictures::build(first, pictures_->last);
}

PointTracker::~PointTracker() = default;

const std::vector<Eigen::Vector2d>& PointTracker::advance(const GreyPicture& picture) {
  Pictures::build(picture, pictures_->next);
  std::vector<size_t> alive;
  std::vector<cv::Point2f> from, to, back;
  for (size_t i = 0; i < points_px_.size(); ++i) {
    if (points_px_[i].hasNaN()) continue;
    alive.push_back(i);
    from.push_back(opencv_point(points_px_[i]));
  }
  if (!alive.empty()) {
    std::vector<uint8_t> there, here;
    std::vector<float> error;
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.003);
    const cv::Size patch(kPatch_px, kPatch_px);
    cv::calcOpticalFlowPyrLK(pictures_->last, pictures_->next, from, to, there, error, patch, kLevels, until,
                             0, kMinEigenvalue);
    cv::calcOpticalFlowPyrLK(pictures_->next, pictures_->last, to, back, here, error, patch, kLevels, until,
                             0, kMinEigenvalue);
    for (size_t k = 0; k < alive.size(); ++k) {
      const cv::Point2f miss = back[k] - from[k];
      const bool inside =
          to[k].x >= 0 && to[k].y >= 0 && to[k].x <= picture.width - 1.0f && to[k].y <= picture.height - 1.0f;
      const bool kept = there[k] && here[k] && inside && miss.dot(miss) < kMaxReturn_px * kMaxReturn_px;
      points_px_[alive[k]] =
          kept ? camera_point(to[k]) : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  std::swap(pictures_->last, pictures_->next);
  return points_px_;
}

}  // namespace livegs
