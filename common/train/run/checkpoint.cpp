// SPDX-License-Identifier: Apache-2.0
// A checkpoint is a header and the arrays of the state, little-endian:
//   "LGSTRAIN", u32 version, u64 fingerprint of capture and options, u64 step, u64 kernels, u64 Adam steps,
//   f64 recent loss, then for kernels, first and second moments the families in order, then the smallest axes
//   and the errors, then for each view the pose of its camera, its moments and its number of steps
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/content_hash.h"
#include "core/text/format_text.h"
#include "train/run/trainer_state.h"

namespace livegs {
namespace {

static_assert(std::endian::native == std::endian::little, "checkpoints are written in memory layout");

constexpr char kMagic[8] = {'L', 'G', 'S', 'T', 'R', 'A', 'I', 'N'};
constexpr uint32_t kVersion = 2;

struct Header {
  char magic[8];
  uint32_t version;
  uint32_t spare;
  char fingerprint[16];
  uint64_t step, kernels, adam_steps;
  double recent_loss;
};
static_assert(sizeof(Header) == 64);

constexpr size_t kPoseNumbers = 7 + 3 + 3 + 1 + 1 + 1;
using PoseNumbers = std::array<double, kPoseNumbers>;
static_assert(sizeof(PoseNumbers) == kPoseNumbers * sizeof(double));

PoseNumbers numbers_of(const CameraPose& pose) {
  PoseNumbers numbers;
  const Eigen::Vector3d& p = pose.world_from_camera.position_m;
  const Eigen::Vector4d& q = pose.world_from_camera.orientation.coeffs();
  const Eigen::Vector3d &a = pose.position_first, &b = pose.turn_first;
  numbers = {p[0],
             p[1],
             p[2],
             q[0],
             q[1],
             q[2],
             q[3],
             a[0],
             a[1],
             a[2],
             b[0],
             b[1],
             b[2],
             pose.position_second,
             pose.turn_second,
             static_cast<double>(pose.steps)};
  return numbers;
}

CameraPose pose_of(const PoseNumbers& n) {
  CameraPose pose;
  pose.world_from_camera.position_m = {n[0], n[1], n[2]};
  pose.world_from_camera.orientation.coeffs() = Eigen::Vector4d(n[3], n[4], n[5], n[6]);
  pose.position_first = {n[7], n[8], n[9]};
  pose.turn_first = {n[10], n[11], n[12]};
  pose.position_second = n[13];
  pose.turn_second = n[14];
  pose.steps = static_cast<uint64_t>(n[15]);
  return pose;
}

size_t floats_of_kernel() {
  size_t width = 0;
  for (size_t one : kFamilyWidth) width += one;
  return 3 * width + 2;
}

}  // namespace

// Names and poses of the views, and every option that changes the result.
static std::string fingerprint_of(const Capture& capture, const TrainOptions& o) {
  std::string text =
      format_text("%zu %zu %d %llu %d %g %g %g %g %d", o.steps, o.max_kernels, o.longest_px,
                  static_cast<unsigned long long>(o.seed), static_cast<int>(o.shape.loss),
                  double{o.shape.weight}, double{o.shape.limit}, double{o.shape.opacity_weight},
                  double{o.shape.scale_weight}, o.ignore_masked ? 1 : 0);
  text += format_text(" %d %g %g", o.refine_poses ? 1 : 0, o.poses_from, o.pose_rate);
  text += format_text(" %g", o.last_pose_share);
  text += format_text(" %g %g %g %g %g %g %g %g %g %g %g %g %g %g %g", o.position_rate, o.last_position_rate,
                      o.scale_rate, o.rotation_rate, o.opacity_rate, o.colour_rate, o.harmonics_rate,
                      o.grow_from, o.grow_until, o.harmonics_interval, o.min_axis_px, o.last_rate_share,
                      o.spread_weight, o.spread_edge, o.spread_error);
  for (const CapturedView& view : capture.views) {
    const Camera& c = view.camera;
    const Eigen::Vector3d& p = c.world_from_camera.position_m;
    text += format_text("\n%s %d %d %d %.9g %.9g %.9g %.9g %.9g", view.name.c_str(), view.held_out ? 1 : 0,
                        c.width, c.height, c.focal_x_px, c.focal_y_px, p.x(), p.y(), p.z());
  }
  return content_hash(std::as_bytes(std::span(text.data(), text.size()))).substr(0, 16);
}

std::vector<std::byte> Trainer::checkpoint() const {
  const State& s = *state_;
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  const std::string fingerprint = fingerprint_of(s.capture, s.options);
  std::memcpy(header.fingerprint, fingerprint.data(), sizeof header.fingerprint);
  header.step = s.step;
  header.kernels = s.kernels.size();
  header.adam_steps = s.adam.steps;
  header.recent_loss = s.recent_loss;
  std::vector<std::byte> bytes(sizeof header + s.kernels.size() * floats_of_kernel() * sizeof(float) +
                               s.poses.size() * sizeof(PoseNumbers));
  std::memcpy(bytes.data(), &header, sizeof header);
  size_t at = sizeof header;
  const auto put = [&](const std::vector<float>& numbers) {
    std::memcpy(bytes.data() + at, numbers.data(), numbers.size() * sizeof(float));
    at += numbers.size() * sizeof(float);
  };
  for (const KernelParameters* part : {&s.kernels, &s.adam.first, &s.adam.second}) {
    for (const auto& family : part->families) put(family);
  }
  put(s.min_log_scales);
  put(s.errors);
  for (const CameraPose& pose : s.poses) {
    const PoseNumbers numbers = numbers_of(pose);
    std::memcpy(bytes.data() + at, numbers.data(), sizeof numbers);
    at += sizeof numbers;
  }
  return bytes;
}

Result<void> Trainer::resume(std::span<const std::byte> bytes) {
  State& s = *state_;
  Header header{};
  if (bytes.size() < sizeof header) return invalid_data("checkpoint: is too short; remove it");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
    return invalid_data("checkpoint: the file has another format; remove it");
  if (header.version != kVersion)
    return unsupported(
        format_text("checkpoint: has version %u, expected %u; remove it", header.version, kVersion));
  const std::string fingerprint = fingerprint_of(s.capture, s.options);
  if (std::memcmp(header.fingerprint, fingerprint.data(), sizeof header.fingerprint) != 0)
    return invalid_argument("checkpoint: is of other photos or options; use the same ones or remove it");
  if (header.kernels > kMaxTrainedKernels || header.step > s.options.steps ||
      bytes.size() != sizeof header + header.kernels * floats_of_kernel() * sizeof(float) +
                          s.poses.size() * sizeof(PoseNumbers))
    return invalid_data("checkpoint: is damaged: its size does not agree with its count; remove it");
  std::vector<CameraPose> poses;
  for (size_t i = 0; i < s.poses.size(); ++i) {
    PoseNumbers numbers;
    std::memcpy(numbers.data(), bytes.data() + bytes.size() - (s.poses.size() - i) * sizeof numbers,
                sizeof numbers);
    const bool good = std::ranges::all_of(numbers, [](double one) { return std::abs(one) < 1e15; });
    if (!good || numbers.back() < 0)
      return invalid_data("checkpoint: is damaged: a pose is out of range; remove it");
    poses.push_back(pose_of(numbers));
  }
  size_t at = sizeof header;
  const auto take = [&](std::vector<float>& numbers) {
    std::memcpy(numbers.data(), bytes.data() + at, numbers.size() * sizeof(float));
    at += numbers.size() * sizeof(float);
  };
  for (KernelParameters* part : {&s.kernels, &s.adam.first, &s.adam.second}) {
    part->resize(header.kernels);
    for (auto& family : part->families) take(family);
  }
  s.min_log_scales.resize(header.kernels);
  take(s.min_log_scales);
  s.errors.resize(header.kernels);
  take(s.errors);
  s.poses = std::move(poses);
  s.step = header.step;
  s.adam.steps = header.adam_steps;
  s.recent_loss = header.recent_loss;
  return {};
}

}  // namespace livegs
