// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "livegs/v1/scene.pb.h"
#include "render/scene_view.h"
#include "xr/window/window_panels.h"

namespace livegs {

// A force with adjustable size, direction, point and duration, as in the elastic study of LIVE-GS. Holds the
// choice only and makes no calls. One thread.
class ForceStudy {
 public:
  struct Target {
    std::string object;
    uint32_t object_id = 0;
    size_t kernel = 0;             // kernel tracked by the arrow
    Eigen::Vector3d rest_point_m;  // object frame
  };
  void aim(Target target) { target_ = std::move(target); }
  // An object was described again, possibly under a new id.
  void follow(const std::string& object, uint32_t object_id) {
    if (target_ && target_->object == object) target_->object_id = object_id;
  }
  // The object's kernels were renumbered.
  void find_kernel_again(uint32_t object_id, const SceneView& view) {
    if (!target_ || target_->object_id != object_id) return;
    if (const auto kernel = view.nearest_kernel(object_id, target_->rest_point_m)) target_->kernel = *kernel;
  }
  const std::optional<Target>& target() const { return target_; }

  void choose(const PanelActions::Force& chosen) { chosen_ = chosen; }
  void choose_force(const Eigen::Vector3d& force_n, double duration_s);

  Eigen::Vector3d force_n() const;
  double duration_s() const { return chosen_.duration_s; }
  // "Apply a force of 5 newtons to the pillow for 1 second."
  std::string sentence() const;
  // Precondition: a target is set.
  v1::Event::Force message() const;
  ForcePanel shown(std::string progress) const;

 private:
  std::optional<Target> target_;
  PanelActions::Force chosen_{5, 1, 0, 90};
};

// Describes several forces: "Apply a force of 5 newtons to the pillow for 1 second at 2 points, and a force
// of ...". Equal descriptions are merged. Precondition: not empty.
std::string sentence_of(std::span<const ForceStudy> studies);

// Parses "OBJECT:X,Y,Z:FX,FY,FZ:SECONDS", the point in rest coordinates, for at most a minute, the server's
// limit. The error names the problem.
Result<v1::Event::Force> parse_force(const std::string& text);

// Yaw about +Y from +Z, and elevation, in degrees.
Eigen::Vector3d direction_of(double yaw_deg, double pitch_deg);

}  // namespace livegs
