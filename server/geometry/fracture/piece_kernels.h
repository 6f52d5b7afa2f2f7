// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/fracture/voronoi_pieces.h"

// The kernels of an asset, made ready for the pieces its body breaks into. Prepared once after the cut, on
// any thread; when the body breaks, the frame swaps this asset in and nothing is computed.
//
// Cut the fine surface (elastic_surface_options): where the mesh stands out beyond the kernels, as the coarse
// one does in the handle of a cup, the kernels of its cut faces would be seen.

namespace livegs {

// In place of the number of a kernel of the asset: made for a cut face.
inline constexpr uint32_t kInteriorKernel = ~0u;

struct PieceKernelOptions {
  // No kernel reaches farther across a cut than this at three standard deviations, metres; 0: a 200th of the
  // diagonal of the body. Kernels that would are first replaced by narrower ones of the same moments.
  double max_overhang_m = 0.0;
  // Kernels on the cut faces, metres apart; 0: as the surface kernels are, by their median size, but no more
  // than max_interior in all.
  double interior_spacing_m = 0.0;
  size_t max_interior = 60000;
  // Colour of the material inside, 0 … 1; without one, that of the surface kernels nearest to each place, and
  // for the most part the mean of that over the face.
  std::optional<Eigen::Vector3f> interior_rgb;
  std::stop_token stop;
};

// `asset` holds the kernels of the original first, in their order: each as it was, or, where a cut crosses
// it, the part of it on its own side. The other parts follow, then the kernels of the cut faces. Arrays by
// kernel.
struct PieceKernels {
  GaussianAsset asset;
  std::vector<uint32_t> piece;    // that it moves with
  std::vector<uint32_t> source;   // kernel of the original it is a part of, or kInteriorKernel
  std::vector<uint32_t> changed;  // kernels below the original count that are not as they were
  size_t original_count = 0;
  size_t interior_begin = 0;  // first kernel of the cut faces
};

// Binds each kernel to the piece at its centre (VoronoiPieces::locate) and splits those whose ellipsoid at
// three standard deviations crosses the plane between two pieces.
//
// A part has the moments of the Gaussian cut off at the plane: with a the plane's distance in standard
// deviations along its normal n, p(a) and P(a) the normal density and distribution, h = p/P and s² = nᵀΣn,
// the part below the plane has
//   mass P, mean μ - h Σn/s, covariance Σ - (a h + h²) Σn nᵀΣ/s²,
// (Cartinhour 1990, one-dimensional marginals of truncated normals). Its peak opacity is P·sqrt(|Σ|/|Σ'|)
// times the original's, which keeps the sum of opacity over space, held below 0.998. A part with an opacity
// below 1/255 is left out, as every renderer would.
//
// Deterministic for any thread count. Cancelled: ErrorCode::Unavailable.
Result<PieceKernels> make_piece_kernels(const GaussianAsset& asset, const Similarity& object_from_asset,
                                        const VoronoiPieces& pieces, const PieceKernelOptions& options = {});

}  // namespace livegs
