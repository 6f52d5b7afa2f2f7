// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset/establish_invariants.h"

#include <algorithm>
#include <cmath>

#include "gaussian/opacity.h"

namespace livegs {
namespace {

// Limits within which squared lengths stay finite, normal floats: 1e18^2 < FLT_MAX, e^86 < FLT_MAX, e^-86 >
// FLT_MIN.
constexpr float kMaxCoordinate = 1e18f;
constexpr float kMaxLogScale = 43.0f;
constexpr float kMinLogScale = -43.0f;

// Tolerance of the squared length of a unit quaternion. Normalising in double leaves a float within 2^-23 of
// 1; seven more steps allow for quaternions that another program normalised in float.
constexpr double kUnitTolerance = 1e-6;

struct Repairs {
  size_t dropped = 0;
  size_t flattened = 0;
  size_t turned_to_identity = 0;
};

bool usable(const GaussianAsset& asset, size_t i) {
  if (!(asset.positions[i].array().abs() <= kMaxCoordinate).all()) return false;  // false for NaN as well
  if (!(asset.log_scales[i].array() <= kMaxLogScale).all()) return false;
  if (!asset.rotations[i].coeffs().allFinite()) return false;
  if (std::isnan(asset.opacity_logits[i])) return false;
  if (!asset.sh_dc[i].allFinite()) return false;
  const size_t rest = asset.sh_rest_count();
  for (size_t k = 0; k < rest; ++k) {
    if (!asset.sh_rest[i * rest + k].allFinite()) return false;
  }
  return true;
}

void repair(GaussianAsset& asset, size_t i, Repairs& repairs) {
  if ((asset.log_scales[i].array() < kMinLogScale).any()) {
    asset.log_scales[i] = asset.log_scales[i].cwiseMax(kMinLogScale);
    ++repairs.flattened;
  }
  if (std::isinf(asset.opacity_logits[i])) {
    asset.opacity_logits[i] = std::copysign(kMaxOpacityLogit, asset.opacity_logits[i]);
  }
  const Eigen::Quaterniond q = asset.rotations[i].cast<double>();
  const double squared = q.squaredNorm();
  if (squared == 0) {
    asset.rotations[i] = Eigen::Quaternionf::Identity();
    ++repairs.turned_to_identity;
  } else if (std::abs(squared - 1) > kUnitTolerance) {
    asset.rotations[i] = Eigen::Quaterniond(q.coeffs() / std::sqrt(squared)).cast<float>();
  }
}

void move_kernel(GaussianAsset& asset, size_t from, size_t to) {
  asset.positions[to] = asset.positions[from];
  asset.log_scales[to] = asset.log_scales[from];
  asset.rotations[to] = asset.rotations[from];
  asset.opacity_logits[to] = asset.opacity_logits[from];
  asset.sh_dc[to] = asset.sh_dc[from];
  const auto rest = static_cast<ptrdiff_t>(asset.sh_rest_count());
  const auto begin = asset.sh_rest.begin();
  std::copy_n(begin + static_cast<ptrdiff_t>(from) * rest, rest, begin + static_cast<ptrdiff_t>(to) * rest);
}

std::string kernels(size_t count) { return std::to_string(count) + (count == 1 ? " kernel" : " kernels"); }

}  // namespace

bool meets_invariants(const GaussianAsset& asset, size_t kernel) {
  return usable(asset, kernel) && (asset.log_scales[kernel].array() >= kMinLogScale).all() &&
         std::isfinite(asset.opacity_logits[kernel]) &&
         std::abs(asset.rotations[kernel].cast<double>().squaredNorm() - 1) <= kUnitTolerance;
}

Result<void> establish_invariants(AssetFile& file, std::string_view name) {
  GaussianAsset& asset = file.asset;
  const size_t count = asset.size();
  Repairs repairs;
  size_t kept = 0;
  for (size_t i = 0; i < count; ++i) {
    if (!usable(asset, i)) {
      ++repairs.dropped;
      continue;
    }
    repair(asset, i, repairs);
    if (kept != i) move_kernel(asset, i, kept);
    ++kept;
  }
  if (count == 0) return invalid_data(std::string(name) + ": has no kernels");
  if (kept == 0) {
    return invalid_data(std::string(name) + ": none of the " + kernels(count) +
                        " has finite values in range");
  }
  asset.resize(kept);
  if (repairs.dropped)
    file.notes.push_back("dropped " + kernels(repairs.dropped) +
                         " with values that are not finite or out of range");
  if (repairs.flattened)
    file.notes.push_back("raised a standard deviation below e^-43 in " + kernels(repairs.flattened));
  if (repairs.turned_to_identity)
    file.notes.push_back("gave the identity rotation to " + kernels(repairs.turned_to_identity) +
                         " with a quaternion of length zero");
  return {};
}

}  // namespace livegs
