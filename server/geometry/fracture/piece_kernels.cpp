// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/fracture/piece_kernels.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "core/percentile.h"
#include "gaussian/opacity.h"
#include "geometry/field/colour_grid.h"
#include "geometry/fracture/face_kernels.h"
#include "geometry/fracture/split_gaussian.h"

namespace livegs {
namespace {

constexpr size_t kBlock = 1024;
constexpr float kShDc = 0.28209479f;              // Y_00
constexpr double kDefaultOverhang = 1.0 / 200.0;  // relative to the diagonal
constexpr double kMaxOpacity = 0.998;
constexpr double kMinPieceOpacity = 1.0 / 255.0;
constexpr double kInteriorOpacity = 0.98;
// Minimum opacity of a kernel that defines the surface colour.
constexpr double kOpaque = 0.3;
// Weight of the nearest surface kernel in the colour of a kernel on a cut face. The rest is the mean of the
// face, so that a speckled glaze does not continue into the clay.
constexpr float kMinDistanceShare = 0.25f;
// Minimum ratio of the smallest to the largest standard deviation of a part. Limits the loss of precision
// when a renderer inverts the covariance.
constexpr double kMinFlatness = 1e-3;

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
  const Eigen::Array3d variances_m2 = eigen.eigenvalues().array().max(kMinFlatness * kMinFlatness * most_m2);
  asset.log_scales[k] = (0.5 * variances_m2.log() - std::log(object_from_asset.scale)).matrix().cast<float>();
  asset.rotations[k] = (asset_from_object * Eigen::Quaterniond(axes)).normalized().cast<float>();
  const double opacity = std::min(part.opacity * source_opacity, std::max(kMaxOpacity, source_opacity));
  asset.opacity_logits[k] = static_cast<float>(std::clamp(std::log(opacity / (1.0 - opacity)),
                                                          -static_cast<double>(kMaxOpacityLogit),
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

// Returns the spacing of kernels on cut faces: the width of surface kernels, at least as large as
// `max_interior` requires.
double interior_spacing_m(const GaussianAsset& asset, double scale, const VoronoiPieces& pieces,
                          const PieceKernelOptions& options) {
  double area_m2 = 0.0;
  for (const VoronoiBond& bond : pieces.bonds) area_m2 += bond.area_m2;
  // Two sides, a hexagon of 0.87 spacing² per kernel, and at most the same number along rims.
  const double least_m =
      std::sqrt(4.0 * area_m2 / (0.87 * static_cast<double>(std::max<size_t>(options.max_interior, 1))));
  if (options.interior_spacing_m > 0.0) return std::max(options.interior_spacing_m, least_m);
  std::vector<float> widths;
  for (size_t k = 0; k < asset.size(); ++k) {
    Eigen::Vector3f log_scale = asset.log_scales[k];
    std::sort(log_scale.begin(), log_scale.end());
    if (opacity_of_logit(asset.opacity_logits[k]) >= kOpaque)
      widths.push_back(0.5f * (log_scale[1] + log_scale[2]));
  }
  if (widths.empty()) return std::max(least_m, body_diagonal_m(pieces) / 100.0);
  const double width_m = std::exp(static_cast<double>(percentile(std::move(widths), 0.5))) * scale;
  // A kernel on a face has a standard deviation of 0.6 spacings.
  return std::clamp(width_m / 0.6, least_m, std::max(least_m, body_diagonal_m(pieces) / 40.0));
}

void add_face_kernels(const GaussianAsset& asset, const Similarity& object_from_asset,
                      const VoronoiPieces& pieces, const PieceKernelOptions& options, double overhang_m,
                      PieceKernels& out) {
  const double spacing_m = interior_spacing_m(asset, object_from_asset.scale, pieces, options);
  const std::vector<FaceKernel> faces = options.max_interior > 0 && spacing_m > 0.0
                                            ? face_kernels(pieces, spacing_m, overhang_m)
                                            : std::vector<FaceKernel>{};
  const size_t begin = out.asset.size();
  out.interior_begin = begin;
  out.asset.resize(begin + faces.size());
  out.piece.resize(begin + faces.size());
  out.source.resize(begin + faces.size(), kInteriorKernel);
  if (faces.empty()) return;

  const Eigen::Array3f rgb = options.interior_rgb.value_or(Eigen::Vector3f::Constant(0.5f));
  std::vector<Eigen::Vector3f> colours(faces.size(), (rgb - 0.5f) / kShDc);
  if (!options.interior_rgb) {
    std::vector<Eigen::Vector3d> places_m;
    std::vector<Eigen::Vector3f> surface;
    for (size_t k = 0; k < asset.size(); ++k) {
      if (opacity_of_logit(asset.opacity_logits[k]) < kOpaque) continue;
      places_m.push_back(object_from_asset * asset.positions[k].cast<double>());
      surface.push_back(asset.sh_dc[k]);
    }
    if (!surface.empty()) {
      const ColourGrid grid(places_m, surface);
      for (size_t f = 0; f < faces.size(); ++f) colours[f] = grid.at(faces[f].position_m);
    }
    std::vector<Eigen::Vector3d> sums(pieces.bonds.size(), Eigen::Vector3d::Zero());
    std::vector<double> counts(pieces.bonds.size(), 0.0);
    for (size_t f = 0; f < faces.size(); ++f) {
      sums[faces[f].bond] += colours[f].cast<double>();
      counts[faces[f].bond] += 1.0;
    }
    for (size_t f = 0; f < faces.size(); ++f) {
      const Eigen::Vector3f mean = (sums[faces[f].bond] / counts[faces[f].bond]).cast<float>();
      colours[f] = kMinDistanceShare * colours[f] + (1.0f - kMinDistanceShare) * mean;
    }
  }

  const Eigen::Quaterniond asset_from_object = object_from_asset.rotation.conjugate();
  for (size_t f = 0; f < faces.size(); ++f) {
    const size_t k = begin + f;
    out.piece[k] = faces[f].piece;
    out.asset.positions[k] = (asset_from_object * (faces[f].position_m - object_from_asset.translation_m) /
                              object_from_asset.scale)
                                 .cast<float>();
    out.asset.rotations[k] =
        (asset_from_object * Eigen::Quaterniond(faces[f].axes)).normalized().cast<float>();
    out.asset.log_scales[k] =
        (faces[f].deviations_m / object_from_asset.scale).array().log().matrix().cast<float>();
    out.asset.opacity_logits[k] = static_cast<float>(std::log(kInteriorOpacity / (1.0 - kInteriorOpacity)));
    out.asset.sh_dc[k] = colours[f];
  }
}

}  // namespace

Result<PieceKernels> make_piece_kernels(const GaussianAsset& asset, const Similarity& object_from_asset,
                                        const VoronoiPieces& pieces, const PieceKernelOptions& options) {
  if (pieces.pieces.empty()) return invalid_argument("fracture: there are no pieces; cut the body first");
  if (!(options.max_overhang_m >= 0.0) || !(options.interior_spacing_m >= 0.0)) {
    return invalid_argument("fracture: max_overhang_m and interior_spacing_m must not be negative");
  }
  const double overhang_m =
      options.max_overhang_m > 0.0 ? options.max_overhang_m : kDefaultOverhang * body_diagonal_m(pieces);

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
      const SplitLimits limits{overhang_m, kMinPieceOpacity / std::max(opacity, 1e-6)};
      std::vector<GaussianPart> parts = split_gaussian(kernel.mean_m, kernel.covariance_m2, pieces, limits);
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
  add_face_kernels(asset, object_from_asset, pieces, options, overhang_m, out);
  return out;
}

}  // namespace livegs
