// SPDX-License-Identifier: Apache-2.0
#include "wire/stream_lag.h"

#include <algorithm>
#include <cmath>

#include "wire/stream_layout.h"

namespace livegs {

std::vector<ObjectLag> lag_behind(const DriverFrame& frame, const StreamBaseline& baseline,
                                  const GridPrecision& precision) {
  std::vector<ObjectLag> lags;
  for (const ObjectDrivers& object : frame.objects) {
    const auto* known = baseline.find(object.object_id);
    const size_t count = std::max(object.poses.size(), object.positions_m.size());
    if (!known || (*known)->now.kind != object.kind || (*known)->now.revision != object.revision ||
        (*known)->now.count != count)
      continue;
    if (to_grid(object, &(*known)->now, precision) == (*known)->now) continue;
    const ObjectDrivers has = from_grid((*known)->now);
    ObjectLag lag;
    lag.object_id = object.object_id;
    lag.age_ticks = frame.tick - (*known)->tick;
    lag.integers = count * (*known)->now.channels();
    for (size_t i = 0; i < object.poses.size(); ++i) {
      lag.moved_m = std::max(lag.moved_m, (object.poses[i].position_m - has.poses[i].position_m).norm());
      lag.turned_rad =
          std::max(lag.turned_rad, object.poses[i].orientation.angularDistance(has.poses[i].orientation));
    }
    float moved_m2 = 0;
    for (size_t i = 0; i < object.positions_m.size(); ++i)
      moved_m2 = std::max(moved_m2, (object.positions_m[i] - has.positions_m[i]).squaredNorm());
    lag.moved_m = std::max(lag.moved_m, std::sqrt(static_cast<double>(moved_m2)));
    lags.push_back(lag);
  }
  return lags;
}

}  // namespace livegs
