// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/motion_value.h"

#include "scene/values/scene_values.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kMaxOffset_m = 1000.0;
constexpr double kMaxSpeed_m_s = 1000.0;
// Minimum pulse duration, seconds. A shorter pulse ends between two substeps.
constexpr double kMinPulse_s = 1e-6;

Result<Vector3d> needed_vector(const Numbers& numbers, double largest, const char* unit,
                               const std::string& field) {
  if (numbers.empty()) return invalid_argument(field + ": is missing; give [x, y, z] in " + unit);
  return vector_value(numbers, Vector3d::Zero(), field, largest);
}

Result<void> check_order(double start_s, double end_s, const std::string& field, const char* start,
                         const char* end) {
  if (auto number = number_value(start_s, 0, kMaxTime_s, field + "." + start); !number) return number.error();
  if (auto number = number_value(end_s, 0, kMaxTime_s, field + "." + end); !number) return number.error();
  if (end_s >= start_s) return {};
  char message[96];
  std::snprintf(message, sizeof message, ": is %g, before %s, which is %g; swap or change them", end_s, start,
                start_s);
  return invalid_argument(field + "." + end + message);
}

Result<RegionMotion> read(const v1::Motion::DisplacementRamp& ramp, const std::string& field) {
  auto displacement = needed_vector(ramp.displacement_m(), kMaxOffset_m, "metres", field + ".displacement_m");
  if (!displacement) return displacement.error();
  if (auto order = check_order(ramp.start_s(), ramp.end_s(), field, "start_s", "end_s"); !order) {
    return order.error();
  }
  return RegionMotion(DisplacementRamp{*displacement, ramp.start_s(), ramp.end_s()});
}

Result<RegionMotion> read(const v1::Motion::AffineRamp& ramp, const std::string& field) {
  if (ramp.matrix().empty()) {
    return invalid_argument(field + ".matrix: is missing; give nine numbers, row by row");
  }
  auto matrix = matrix_value(ramp.matrix(), field + ".matrix");
  if (!matrix) return matrix.error();
  auto about = vector_value(ramp.about_m(), Vector3d::Zero(), field + ".about_m");
  if (!about) return about.error();
  if (auto order = check_order(ramp.start_s(), ramp.end_s(), field, "start_s", "end_s"); !order) {
    return order.error();
  }
  if (ramp.has_return_end_s()) {
    auto order = check_order(ramp.end_s(), ramp.return_end_s(), field, "end_s", "return_end_s");
    if (!order) return order.error();
    if (ramp.return_end_s() == ramp.end_s()) {
      return invalid_argument(
          field + ".return_end_s: equals end_s; give a later time, or omit it to keep the deformation");
    }
  }
  return RegionMotion(AffineRamp{*matrix, *about, ramp.start_s(), ramp.end_s(), ramp.return_end_s()});
}

Result<RegionMotion> read(const v1::Motion::HalfSinePulse& pulse, const std::string& field) {
  auto displacement =
      needed_vector(pulse.displacement_m(), kMaxOffset_m, "metres", field + ".displacement_m");
  if (!displacement) return displacement.error();
  if (auto start = number_value(pulse.start_s(), 0, kMaxTime_s, field + ".start_s"); !start)
    return start.error();
  if (auto width = number_value(pulse.width_s(), kMinPulse_s, kMaxTime_s, field + ".width_s"); !width) {
    return width.error();
  }
  return RegionMotion(HalfSinePulse{*displacement, pulse.start_s(), pulse.width_s()});
}

Result<RegionMotion> read(const v1::Motion::ConstantVelocity& steady, const std::string& field) {
  auto velocity =
      needed_vector(steady.velocity_m_s(), kMaxSpeed_m_s, "metres per second", field + ".velocity_m_s");
  if (!velocity) return velocity.error();
  const double end_s = steady.has_end_s() ? steady.end_s() : kMaxTime_s;
  if (auto order = check_order(steady.start_s(), end_s, field, "start_s", "end_s"); !order)
    return order.error();
  return RegionMotion(ConstantVelocity{*velocity, steady.start_s(), end_s});
}

}  // namespace

Result<RegionMotion> motion_value(const v1::Motion& motion, const std::string& field) {
  switch (motion.kind_case()) {
    case v1::Motion::kDisplacementRamp:
      return read(motion.displacement_ramp(), field + ".displacement_ramp");
    case v1::Motion::kAffineRamp:
      return read(motion.affine_ramp(), field + ".affine_ramp");
    case v1::Motion::kHalfSinePulse:
      return read(motion.half_sine_pulse(), field + ".half_sine_pulse");
    case v1::Motion::kConstantVelocity:
      return read(motion.constant_velocity(), field + ".constant_velocity");
    case v1::Motion::KIND_NOT_SET:
      break;
  }
  return invalid_argument(
      field + ": is empty; give displacement_ramp, affine_ramp, half_sine_pulse or constant_velocity");
}

}  // namespace livegs
