// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "prepare/prepare_pieces.h"
#include "skin/rest_body.h"

// Data that a fragile object needs to break within one frame: its pieces and their kernels. Prepared on a
// worker thread when the scene is loaded.

namespace livegs {

// The kernels of a fractured object, sorted by piece: the original kernels, split where a cut crosses them,
// and the kernels of the cut faces. All breaks of the object share this asset; only the body of each piece
// changes.
struct BrokenAsset {
  std::shared_ptr<const GaussianAsset> asset;
  std::vector<uint32_t> piece_kernels;  // number of kernels per piece
  std::vector<uint32_t> source;         // per kernel: index of the original kernel, or kInteriorKernel
};

// Returns the runs of kernels that belong to each body.
std::vector<RestBody::KernelRun> kernel_runs(const BrokenAsset& broken,
                                             std::span<const uint32_t> piece_bodies);

struct FragileObject {
  std::shared_ptr<const BreakablePieces> pieces;
  std::shared_ptr<const BrokenAsset> broken;
  double prepared_ms = 0;
};

struct FragileOptions {
  BreakableOptions pieces;
  Similarity object_from_asset;
  // Set if a coarser surface is cut: the fine surface that the kernels lie on. Kernels of cut faces outside
  // this surface are left out.
  std::shared_ptr<const TriangleMesh> fine_mesh;
  std::optional<Eigen::Vector3f> interior_rgb;  // as in Material
};
// Cuts `mesh`, which is closed and in the object frame, into pieces and splits the kernels.
Result<FragileObject> prepare_fragile(const TriangleMesh& mesh, Fill fill, const GaussianAsset& asset,
                                      const FragileOptions& options);

// Height in metres of a free fall onto a hard floor at which m sqrt(2 g H) (1 + e) equals the break impulse.
double drop_height_m(const Material& material, double gravity_m_s2);

// A preparation that runs on a worker thread. The destructor cancels it and waits.
class FragileTask {
 public:
  FragileTask(uint32_t object_id, TriangleMesh mesh, Fill fill, std::shared_ptr<const GaussianAsset> asset,
              const FragileOptions& options);
  FragileTask(uint32_t object_id, const FragileObject& ready);  // of an earlier task
  FragileTask(FragileTask&&) = default;
  FragileTask& operator=(FragileTask&&) = default;
  ~FragileTask() { stop_.request_stop(); }

  uint32_t object_id() const { return object_id_; }
  bool ready() const {
    return !taken() && future_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  Result<FragileObject> take() { return future_.get(); }  // blocks until the result is ready; call once
  bool taken() const { return !future_.valid(); }

 private:
  uint32_t object_id_;
  std::stop_source stop_;
  std::future<Result<FragileObject>> future_;
};

}  // namespace livegs
