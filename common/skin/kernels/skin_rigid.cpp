// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/nearest_cubes.h"

namespace livegs {

Result<void> bind_rigid(const RestKernels& kernels, const RestBody& rest, KernelBindings& bindings) {
  if (rest.bodies.empty()) return invalid_argument("rest body: a rigid object needs at least one body");
  std::vector<Eigen::Vector3f> origins_m;
  std::vector<Pose> body_from_object;
  for (const Pose& object_from_body : rest.bodies) {
    if (!object_from_body.position_m.cast<float>().allFinite() ||
        !object_from_body.orientation.coeffs().allFinite()) {
      return invalid_argument("rest body: the pose of body " + std::to_string(origins_m.size()) +
                              " is not finite");
    }
    origins_m.push_back(object_from_body.position_m.cast<float>());
    body_from_object.push_back(object_from_body.inverse());
  }
  std::vector<uint32_t> body_of;  // one per kernel; empty: the nearest
  for (const RestBody::KernelRun& run : rest.kernel_runs) {
    if (run.body >= rest.bodies.size()) {
      return invalid_argument("rest body: a kernel run refers to body " + std::to_string(run.body) + " of " +
                              std::to_string(rest.bodies.size()));
    }
    if (run.count > kernels.positions_m.size() - body_of.size()) {
      return invalid_argument("rest body: kernel runs cover more than the " +
                              std::to_string(kernels.positions_m.size()) + " kernels of the asset");
    }
    body_of.insert(body_of.end(), run.count, run.body);
  }
  if (!rest.kernel_runs.empty() && body_of.size() != kernels.positions_m.size()) {
    return invalid_argument("rest body: kernel runs cover " + std::to_string(body_of.size()) + " of the " +
                            std::to_string(kernels.positions_m.size()) + " kernels of the asset");
  }
  const NearestCubes bodies(origins_m, 0.0f);

  bindings.rest_positions_m.resize(kernels.positions_m.size());
  parallel_for(kernels.positions_m.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      uint32_t body = 0;
      if (body_of.empty()) {
        std::array<NearestCubes::Neighbour, 1> nearest;
        bodies.find(kernels.positions_m[k].cast<float>(), nearest);
        body = nearest[0].index;
      } else {
        body = body_of[k];
      }
      const Pose& into_body = body_from_object[body];
      bindings.kernels[k].drivers[0] = body;
      bindings.kernels[k].weights[0] = 1.0f;
      bindings.rest_positions_m[k] = (into_body * kernels.positions_m[k]).cast<float>();
      bindings.rest_covariances_m2[k] = transformed(into_body.orientation.cast<float>().toRotationMatrix(),
                                                    symmetric_of(kernels.covariances_m2[k]));
    }
  });
  return {};
}

std::vector<TurnedBody> turned_bodies(const RestBody& rest, const ObjectDrivers& drivers) {
  LIVEGS_ASSERT(drivers.poses.size() == rest.bodies.size());
  std::vector<TurnedBody> bodies(rest.bodies.size());
  for (size_t b = 0; b < bodies.size(); ++b) {
    const Eigen::Quaterniond since_rest =
        drivers.poses[b].orientation * rest.bodies[b].orientation.conjugate();
    bodies[b].world_from_body = drivers.poses[b].orientation.toRotationMatrix().cast<float>();
    bodies[b].position_m = drivers.poses[b].position_m.cast<float>();
    bodies[b].world_from_object = since_rest.toRotationMatrix().cast<float>();
    bodies[b].world_from_asset = (since_rest * rest.object_from_asset.rotation).normalized().cast<float>();
  }
  return bodies;
}

void skin_rigid(const RestBody& rest, const KernelBindings& bindings, const ObjectDrivers& drivers,
                PosedKernels& kernels, std::vector<Eigen::Matrix3f>* deformation_gradients) {
  const std::vector<TurnedBody> bodies = turned_bodies(rest, drivers);
  parallel_for(bindings.kernels.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const TurnedBody& body = bodies[bindings.kernels[k].drivers[0]];
      kernels.positions_m[k] = body.world_from_body * bindings.rest_positions_m[k] + body.position_m;
      kernels.covariances_m2[k] = transformed(body.world_from_body, bindings.rest_covariances_m2[k]);
      kernels.world_from_asset[k] = body.world_from_asset;
      if (deformation_gradients) (*deformation_gradients)[k] = body.world_from_object;
    }
  });
}

}  // namespace livegs
