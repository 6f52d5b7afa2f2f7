// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/piece_kernels.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"
#include "geometry/split_gaussian.h"

namespace livegs {
namespace {

constexpr size_t kBlock = 1024;
constexpr double kDefaultOverhang = 1.0 / 200.0;  // of the diagonal
constexpr double kMostOpacity = 0.998;
constexpr double kLeastOpacity = 1.0 / 255.0;
// Of the largest standard deviation: a part is never flatter, so that a renderer's inverse has its digits.
constexpr double kLeastFlatness = 1e-3;

struct Kernel {
  Eigen::Vector3d mean_m;
  Eigen::Matrix3d covariance_m2;
};

Kernel at_rest(const GaussianAsset& asset, size_t k, const Similarity& object_from_asset) {
  const Eigen::Matrix3d axes =
      (object_from_asset.rotation * asset.rotations[k].cast<double>()).toRotationMatrix();
  const Eigen::Vector3d deviations_m =
      (asset.log_scales[k].cast<double>().array().exp() * object_from_asset.scale).min(1e6);
  const Eigen::Matrix3d scaled = axes * deviations_m.asDiagonal();
  return {object_from_asset * asset.positions[k].cast<double>(), scaled * scaled.transpose()};
}

struct AddedPart {
  uint32_t source;
  GaussianPart part;
};

void store(GaussianAsset& asset, size_t k, const GaussianPart& part, double source_opacity,
           const Similarity& object_from_asset) {
  const Eigen::Quaterniond asset_from_object = object_from_asset.rotation.conjugate();
  asset.positions[k] =
      (asset_from_object * (part.mean_m - object_from_asset.translation_m) / object_from_asset.scale)
          .cast<float>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(part.covariance_m2);
  Eigen::Matrix3d axes = eigen.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(0) = -axes.col(0);
  const double most_m2 = std::max(eigen.eigenvalues()[2], 1e-36);
  const Eigen::Array3d variances_m2 = eigen.eigenvalues().array().max(kLeastFlatness * kLeastFlatness * most_m2);
  asset.log_scales[k] = (0.5 * variances_m2.log() - std::log(object_from_asset.scale)).matrix().cast<float>();
  asset.rotations[k] = (asset_from_object * Eigen::Quaterniond(axes)).normalized().cast<float>();
  const double opacity = std::min(part.opacity * source_opacity, std::max(kMostOpacity, source_opacity));
  asset.opacity_logits[k] = static_cast<float>(
      std::clamp(std::log(opacity / (1.0 - opacity)), -static_cast<double>(kMaxOpacityLogit),
                 static_cast<double>(kMaxOpacityLogit)));
}

void copy_colour(const GaussianAsset& from, size_t source, GaussianAsset& to, size_t k) {
  to.sh_dc[k] = from.sh_dc[source];
  const size_t count = from.sh_rest_count();
  std::copy_n(from.sh_rest.begin() + static_cast<std::ptrdiff_t>(source * count), count,
              to.sh_rest.begin() + static_cast<std::ptrdiff_t>(k * count));
}

double body_diagonal_m(const VoronoiPieces& pieces) {
  Eigen::AlignedBox3d bounds;
  for (const VoronoiPiece& piece : pieces.pieces) {
    for (const auto& vertex : piece.mesh.vertices_m) bounds.extend(vertex);
  }
  return bounds.diagonal().norm();
}

}  // namespace

Result<PieceKernels> make_piece_kernels(const GaussianAsset& asset, const Similarity& object_from_asset,
                                        const VoronoiPieces& pieces, const PieceKernelOptions& options) {
  if (pieces.pieces.empty()) return invalid_argument("fracture: no pieces to bind kernels to");
  if (!(options.most_overhang_m >= 0.0) || !(options.interior_spacing_m >= 0.0)) {
    return invalid_argument("fracture: most_overhang_m and interior_spacing_m must not be negative");
  }
  const double overhang_m =
      options.most_overhang_m > 0.0 ? options.most_overhang_m : kDefaultOverhang * body_diagonal_m(pieces);

  PieceKernels out;
  out.asset = asset;
  out.original_count = asset.size();
  out.piece.resize(asset.size());
  out.source.resize(asset.size());
  std::vector<uint8_t> changed(asset.size(), 0);
  std::vector<std::vector<AddedPart>> added((asset.size() + kBlock - 1) / kBlock);
  parallel_for(asset.size(), kBlock, [&](size_t begin, size_t end) {
    if (options.stop.stop_requested()) return;
    for (size_t k = begin; k < end; ++k) {
      const Kernel kernel = at_rest(asset, k, object_from_asset);
      const double opacity = opacity_of_logit(asset.opacity_logits[k]);
      const SplitLimits limits{overhang_m, kLeastOpacity / std::max(opacity, 1e-6)};
      std::vector<GaussianPart> parts =
          split_gaussian(kernel.mean_m, kernel.covariance_m2, pieces, limits);
      out.source[k] = static_cast<uint32_t>(k);
      if (parts.size() == 1 && parts[0].covariance_m2 == kernel.covariance_m2) {
        out.piece[k] = pieces.locate_in(parts[0].cell, kernel.mean_m);
        continue;
      }
      changed[k] = 1;
      out.piece[k] = pieces.locate_in(parts[0].cell, parts[0].mean_m);
      store(out.asset, k, parts[0], opacity, object_from_asset);
      for (size_t p = 1; p < parts.size(); ++p) {
        added[begin / kBlock].push_back({static_cast<uint32_t>(k), std::move(parts[p])});
      }
    }
  });
  if (options.stop.stop_requested()) return Error{ErrorCode::Unavailable, "fracture: cancelled"};

  for (uint32_t k = 0; k < changed.size(); ++k) {
    if (changed[k]) out.changed.push_back(k);
  }
  size_t count = asset.size();
  for (const auto& block : added) count += block.size();
  out.asset.resize(count);
  out.piece.resize(count);
  out.source.resize(count);
  size_t k = asset.size();
  for (const auto& block : added) {
    for (const AddedPart& more : block) {
      copy_colour(asset, more.source, out.asset, k);
      store(out.asset, k, more.part, opacity_of_logit(asset.opacity_logits[more.source]), object_from_asset);
      out.piece[k] = pieces.locate_in(more.part.cell, more.part.mean_m);
      out.source[k] = more.source;
      ++k;
    }
  }
  out.interior_begin = count;
  return out;
}

}  // namespace livegs
