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
#include "physics/breakable_pieces.h"
#include "skin/rest_body.h"

// What a fragile object needs to break within a frame, made at load on a thread of its own: its pieces and
// the kernels it is drawn with afterwards.

namespace livegs {

// The kernels of a broken object, ordered by piece: those of the original, split where a cut crosses them,
// and those of the cut faces. The same for every break of the object; what changes is the body each piece is
// in.
struct BrokenAsset {
  std::shared_ptr<const GaussianAsset> asset;
  std::vector<uint32_t> piece_kernels;  // how many of each piece
  std::vector<uint32_t> source;         // of each kernel: the original's it is a part of, or kInteriorKernel
};

// Which kernels go with which body.
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
  // Where a coarser surface is cut, the fine one that the kernels lie on: those of cut faces outside it are
  // left out.
  std::shared_ptr<const TriangleMesh> fine_mesh;
  std::optional<Eigen::Vector3f> interior_rgb;  // as Material has it
};
// `mesh` is closed, in the object frame.
Result<FragileObject> prepare_fragile(const TriangleMesh& mesh, Fill fill, const GaussianAsset& asset,
                                      const FragileOptions& options);

// Metres that a free fall onto a hard floor has, at which m sqrt(2 g H) (1 + e) is the break impulse.
double drop_height_m(const Material& material, double gravity_m_s2);

// One preparation that runs. Ends it, and waits, when it goes.
class FragileTask {
 public:
  FragileTask(uint32_t object_id, TriangleMesh mesh, Fill fill, std::shared_ptr<const GaussianAsset> asset,
              const FragileOptions& options);
  FragileTask(FragileTask&&) = default;
  FragileTask& operator=(FragileTask&&) = default;
  ~FragileTask() { stop_.request_stop(); }

  uint32_t object_id() const { return object_id_; }
  bool ready() const {
    return !taken() && future_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  Result<FragileObject> take() { return future_.get(); }  // waits; once
  bool taken() const { return !future_.valid(); }

 private:
  uint32_t object_id_;
  std::stop_source stop_;
  std::future<Result<FragileObject>> future_;
};

}  // namespace livegs
