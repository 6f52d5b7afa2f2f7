// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset/subtract_origin.h"

#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"
#include "gaussian/asset/float_of.h"

namespace livegs {
namespace {

// Spacing of floats, relative to the typical kernel, from which an asset is moved. A shift of a hundredth of
// a standard deviation is not visible.
constexpr double kMaxStepPerDeviation = 0.02;

// 0 without finite values.
double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void subtract_origin(AssetFile& file, const std::vector<Eigen::Vector3d>* exact) {
  GaussianAsset& asset = file.asset;
  const size_t count = asset.size();
  const auto position = [&](size_t i) -> Eigen::Vector3d {
    return exact ? (*exact)[i] : asset.positions[i].cast<double>();
  };
  Eigen::Vector3d middle;
  std::vector<double> values;
  values.reserve(count);
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (size_t i = 0; i < count; ++i) {
      const double value = position(i)[axis];
      if (std::isfinite(value)) values.push_back(value);
    }
    middle[axis] = median_of(values);
  }
  values.clear();
  for (size_t i = 0; i < count; ++i) {
    const double deviation = std::exp(static_cast<double>(asset.log_scales[i].maxCoeff()));
    if (std::isfinite(deviation)) values.push_back(deviation);
  }
  const double kernel = median_of(values);
  const float farthest = float_of(middle.cwiseAbs().maxCoeff());
  const double step = static_cast<double>(std::nextafter(farthest, INFINITY)) - static_cast<double>(farthest);
  const bool far = std::isfinite(step) && step > kMaxStepPerDeviation * kernel && kernel > 0;
  const Eigen::Vector3d origin = far ? Eigen::Vector3d(middle.array().round()) : Eigen::Vector3d::Zero();
  if (far && !origin.isZero(0)) {
    file.frame.origin += origin;
    const std::string at = format_text("(%.9g, %.9g, %.9g)", origin.x(), origin.y(), origin.z());
    file.notes.push_back(
        exact
            ? format_text("the origin %s was subtracted in double precision; a float there has steps of %.3g "
                          "units",
                          at.c_str(), step)
            : format_text("positions around %s are floats in steps of %.3g units for kernels %.3g wide, too "
                          "coarse; export doubles, or subtract an origin before the export",
                          at.c_str(), step, kernel));
  } else if (!exact) {
    return;
  }
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d moved = position(i) - origin;
    asset.positions[i] = {float_of(moved.x()), float_of(moved.y()), float_of(moved.z())};
  }
}

}  // namespace livegs
