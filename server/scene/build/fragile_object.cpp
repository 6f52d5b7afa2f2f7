// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/fragile_object.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <system_error>

#include "core/clock.h"
#include "geometry/field/distance_field.h"
#include "geometry/fracture/piece_kernels.h"
#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

constexpr double kFineFieldCells = 64.0;

// Returns the indices of the kernels to draw. Kernels of cut faces that lie outside `surface` are left out;
// null keeps all.
std::vector<uint32_t> kernels_within(const PieceKernels& kernels, const Similarity& object_from_asset,
                                     const TriangleMesh* surface) {
  std::vector<uint32_t> kept(kernels.piece.size());
  std::iota(kept.begin(), kept.end(), 0u);
  if (!surface) return kept;
  const double cell_m = mesh_bounds_m(*surface).sizes().maxCoeff() / kFineFieldCells;
  const DistanceField field(*surface, cell_m, 2 * cell_m);
  std::erase_if(kept, [&](uint32_t k) {
    if (k < kernels.interior_begin) return false;
    return field.sample(object_from_asset * Eigen::Vector3d(kernels.asset.positions[k].cast<double>()))
               .distance_m > 0.0;
  });
  return kept;
}

// Sorts the kernels by piece.
BrokenAsset ordered_by_piece(const PieceKernels& kernels, std::vector<uint32_t> order, size_t piece_count) {
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return kernels.piece[a] < kernels.piece[b]; });
  const GaussianAsset& from = kernels.asset;
  auto to = std::make_shared<GaussianAsset>();
  to->sh_degree = from.sh_degree;
  to->antialiased = from.antialiased;
  to->resize(order.size());
  BrokenAsset broken;
  broken.piece_kernels.assign(piece_count, 0);
  broken.source.resize(order.size());
  const size_t rest = from.sh_rest_count();
  for (size_t i = 0; i < order.size(); ++i) {
    const uint32_t k = order[i];
    to->positions[i] = from.positions[k];
    to->log_scales[i] = from.log_scales[k];
    to->rotations[i] = from.rotations[k];
    to->opacity_logits[i] = from.opacity_logits[k];
    to->sh_dc[i] = from.sh_dc[k];
    std::copy_n(from.sh_rest.begin() + static_cast<ptrdiff_t>(k * rest), rest,
                to->sh_rest.begin() + static_cast<ptrdiff_t>(i * rest));
    broken.source[i] = kernels.source[k];
    ++broken.piece_kernels[kernels.piece[k]];
  }
  broken.asset = std::move(to);
  return broken;
}

}  // namespace

std::vector<RestBody::KernelRun> kernel_runs(const BrokenAsset& broken,
                                             std::span<const uint32_t> piece_bodies) {
  std::vector<RestBody::KernelRun> runs;
  for (size_t piece = 0; piece < piece_bodies.size(); ++piece) {
    if (runs.empty() || runs.back().body != piece_bodies[piece]) runs.push_back({piece_bodies[piece], 0});
    runs.back().count += broken.piece_kernels[piece];
  }
  return runs;
}

Result<FragileObject> prepare_fragile(const TriangleMesh& mesh, Fill fill, const GaussianAsset& asset,
                                      const FragileOptions& options) {
  const int64_t begun_ns = now_ns();
  auto pieces = prepare_pieces(mesh, fill, options.pieces);
  if (!pieces) return pieces.error();
  FragileObject fragile;
  fragile.pieces = std::move(*pieces);
  PieceKernelOptions splitting;
  splitting.stop = options.pieces.stop;
  splitting.interior_rgb = options.interior_rgb;
  auto kernels = make_piece_kernels(asset, options.object_from_asset, fragile.pieces->cut, splitting);
  if (!kernels) return kernels.error();
  fragile.broken = std::make_shared<const BrokenAsset>(
      ordered_by_piece(*kernels, kernels_within(*kernels, options.object_from_asset, options.fine_mesh.get()),
                       fragile.pieces->pieces.size()));
  fragile.prepared_ms = milliseconds_from_ns(now_ns() - begun_ns);
  return fragile;
}

double drop_height_m(const Material& material, double gravity_m_s2) {
  const double speed = material.break_impulse_n_s / (material.mass_kg * (1.0 + material.restitution));
  return gravity_m_s2 > 0.0 ? speed * speed / (2.0 * gravity_m_s2) : INFINITY;
}

FragileTask::FragileTask(uint32_t object_id, TriangleMesh mesh, Fill fill,
                         std::shared_ptr<const GaussianAsset> asset, const FragileOptions& options)
    : object_id_(object_id) {
  FragileOptions own = options;
  own.pieces.stop = stop_.get_token();
  const auto prepare = [mesh = std::move(mesh), fill, asset = std::move(asset), own] {
    return prepare_fragile(mesh, fill, *asset, own);
  };
  // If no thread can be started, the object does not break and its warning gives the reason.
  try {
    future_ = std::async(std::launch::async, prepare);
  } catch (const std::system_error& error) {
    std::promise<Result<FragileObject>> failed;
    failed.set_value(Error{ErrorCode::Unavailable, error.what()});
    future_ = failed.get_future();
  }
}

FragileTask::FragileTask(uint32_t object_id, const FragileObject& ready) : object_id_(object_id) {
  std::promise<Result<FragileObject>> done;
  done.set_value(ready);
  future_ = done.get_future();
}

}  // namespace livegs
