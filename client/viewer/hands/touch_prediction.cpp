// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/touch_prediction.h"

#include "core/clock.h"
#include "render/surface_near.h"
#include "viewer/hands/hand_markers.h"

namespace livegs {
namespace {

constexpr double kLookahead_s = 0.025;  // about two pictures
constexpr int kSteps = 4;               // samples along the path: 12 mm apart at 2 m/s
constexpr float kHandRadius_m = 0.01f;  // the hand is a sphere
// Kernel surfaces of touching objects come no closer than this, owing to the server's contact margin.
constexpr float kContactDistance_m = 0.003f;
constexpr float kReleaseDistance_m = 0.015f;  // hysteresis: a contact ends above this distance
constexpr size_t kProbes = 64, kMaxSurfaceKernels = 4096;
constexpr int64_t kMaxPictureInterval_ns = 500'000'000;  // between pictures

}  // namespace

std::optional<TouchPrediction::Touch> TouchPrediction::at(size_t hand, const HandSample& sample,
                                                          uint32_t held_id, const SceneView& view,
                                                          int64_t displayed_ns) {
  const std::optional<Last> last = last_[hand];
  last_[hand].reset();
  if (!sample.active) return std::nullopt;
  const Eigen::Vector3d place_m = sample.grip.position_m;
  last_[hand] = Last{place_m, displayed_ns, last && last->touches};
  if (!last || displayed_ns <= last->displayed_ns ||
      displayed_ns - last->displayed_ns > kMaxPictureInterval_ns)
    return std::nullopt;
  const Eigen::Vector3f velocity_m_s =
      ((place_m - last->place_m) / seconds_from_ns(displayed_ns - last->displayed_ns)).cast<float>();

  std::vector<Eigen::Vector3f> probes;
  if (held_id == 0) {
    probes.push_back(place_m.cast<float>());
  } else if (const auto held = view.drawn_object(held_id)) {
    const Eigen::AlignedBox3f all(Eigen::Vector3f::Constant(-1e6f), Eigen::Vector3f::Constant(1e6f));
    for (const SurfaceKernel& point : surface_within({&*held, 1}, all, kProbes))
      probes.push_back(point.middle_m);
  }
  const float reach_m = held_id == 0 ? kHandRadius_m : kContactDistance_m;
  const float end_m = last->touches ? reach_m + kReleaseDistance_m : reach_m;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& probe : probes) box.extend(probe);
  Touch touch{false, velocity_m_s.norm()};
  if (!probes.empty()) {
    const Eigen::Vector3f ahead = static_cast<float>(kLookahead_s) * velocity_m_s;
    box.extend(Eigen::AlignedBox3f(box.min() + ahead, box.max() + ahead));
    const Eigen::Vector3f wider =
        Eigen::Vector3f::Constant(end_m + 0.05f);  // centres of large kernels are farther away
    const Eigen::AlignedBox3f looked_at(box.min() - wider, box.max() + wider);
    std::vector<DrawnObject> others = view.drawn_near(looked_at);
    std::erase_if(others, [&](const DrawnObject& object) {
      return object.object_id == held_id || HandMarkers::is_marker(object.object_id);
    });
    const auto surface = surface_within(others, looked_at, kMaxSurfaceKernels);
    for (int step = 0; step <= kSteps && !touch.touches; ++step) {
      for (const Eigen::Vector3f& probe : probes) {
        const Eigen::Vector3f there = probe + static_cast<float>(step) / kSteps * ahead;
        if (distance_to_surface(surface, there) < end_m) {
          touch.touches = true;
          break;
        }
      }
    }
  }
  last_[hand]->touches = touch.touches;
  return touch;
}

}  // namespace livegs
