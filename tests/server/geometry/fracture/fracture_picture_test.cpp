// SPDX-License-Identifier: Apache-2.0
// Pictures of a broken object, drawn by the CPU rasteriser.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "geometry/fracture/fracture_seeds.h"
#include "geometry/fracture/piece_kernels.h"
#include "geometry/mesh/mesh_topology.h"
#include "geometry/reconstruct_surface.h"
#include "sample/sample_scene.h"
#include "skin/skin_kernels.h"
#include "splat/frame_bounds.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

// The cup of the sample scene, upright, cut into 24 pieces.
class BrokenCup : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    cup = new GaussianAsset(make_cup());
    object_from_asset.rotation = Eigen::Quaterniond(0, 1, 0, 0);
    const Surface surface =
        reconstruct_surface(body_points(*cup, object_from_asset), elastic_surface_options()).value();
    bounds = mesh_bounds_m(surface.mesh);
    const auto seeds = fracture_seeds(surface.mesh, {.count = 24, .seed = 1, .impacts_m = {}}).value();
    pieces = new VoronoiPieces(cut_voronoi_pieces(surface.mesh, seeds).value());
    kernels = new PieceKernels(make_piece_kernels(*cup, object_from_asset, *pieces).value());
  }
  static void TearDownTestSuite() {
    delete cup;
    delete pieces;
    delete kernels;
  }

  static PosedKernels posed(const GaussianAsset& asset) {
    RestBody rest;
    rest.object_from_asset = object_from_asset;
    rest.bodies = {Pose{}};
    ObjectDrivers drivers;
    drivers.poses = {Pose{}};
    PosedKernels out;
    skin_kernels(asset, rest, bind_kernels(asset, rest).value(), drivers, out);
    return out;
  }

  static RasterisedView draw(const GaussianAsset& asset, const PosedKernels& at, double azimuth,
                             double elevation) {
    RasterisedView view;
    Rasteriser rasteriser;
    const DrawnObject object{&asset, &at, 0};
    rasteriser.draw(std::span(&object, 1), frame_bounds(bounds, 480, 360, azimuth, elevation), {}, view);
    return view;
  }

  static inline const GaussianAsset* cup = nullptr;
  static inline const VoronoiPieces* pieces = nullptr;
  static inline const PieceKernels* kernels = nullptr;
  static inline Similarity object_from_asset;
  static inline Eigen::AlignedBox3d bounds;
};

// A break replaces the kernels. Before the pieces move, the cup looks the same.
TEST_F(BrokenCup, LooksTheSameWithPiecesInPlace) {
  for (const double azimuth : {0.3, 2.5, 4.4}) {
    const RasterisedView before = draw(*cup, posed(*cup), azimuth, 0.35);
    const RasterisedView after = draw(kernels->asset, posed(kernels->asset), azimuth, 0.35);
    const double psnr = psnr_db(before.image, after.image);
    RecordProperty("psnr_db", std::to_string(psnr));
    EXPECT_GT(psnr, 45.0) << azimuth;  // about half a grey level
  }
}

// Distances of the drawn cut faces to a colour, 0 to 1 per channel, over the pixels that cut faces cover.
// Each piece is drawn alone, from two sides.
std::vector<double> face_distances(const PieceKernels& kernels, const PosedKernels& at, size_t piece_count,
                                   const Eigen::AlignedBox3d& bounds, const Eigen::Vector3f& colour) {
  std::vector<double> distances;
  Rasteriser rasteriser;
  RasterisedView view;
  const Eigen::Vector3f away(0, 1e3f, 0);
  for (uint32_t piece = 0; piece < piece_count; piece += 3) {
    PosedKernels faces = at, surface = at;
    for (size_t k = 0; k < kernels.piece.size(); ++k) {
      const bool inside = kernels.source[k] == kInteriorKernel, here = kernels.piece[k] == piece;
      if (!inside || !here) faces.positions_m[k] += away;
      if (inside || !here) surface.positions_m[k] += away;
    }
    const DrawnObject objects[] = {{&kernels.asset, &surface, 0}, {&kernels.asset, &faces, 1}};
    for (const double azimuth : {0.7, 3.8}) {
      rasteriser.draw(objects, frame_bounds(bounds, 320, 240, azimuth, 0.4), {}, view);
      for (int y = 0; y < 240; ++y) {
        for (int x = 0; x < 320; ++x) {
          const float* pixel = view.image.at(x, y);
          if (view.object_id[static_cast<size_t>(y * 320 + x)] != 1 || pixel[3] < 0.95f) continue;
          distances.push_back((Eigen::Vector3f(pixel[0], pixel[1], pixel[2]) - colour).norm());
        }
      }
    }
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

// The drawn faces have the colour of the material inside: within 0.02 at the median and within 0.2 for nine
// tenths of the pixels; the rest is mixed with the glaze at the rims of the thin wall. Without a stated
// colour they take the glaze of the nearer side.
TEST_F(BrokenCup, CutFacesShowTheColourOfTheInside) {
  const Eigen::Vector3f clay(0.776f, 0.698f, 0.580f);  // stoneware
  PieceKernelOptions options;
  options.interior_rgb = clay;
  const PieceKernels stated = make_piece_kernels(*cup, object_from_asset, *pieces, options).value();
  const size_t count = pieces->pieces.size();
  const auto drawn = face_distances(stated, posed(stated.asset), count, bounds, clay);
  ASSERT_GT(drawn.size(), 500u);
  EXPECT_LT(drawn[drawn.size() / 2], 0.02);
  EXPECT_LT(drawn[drawn.size() * 9 / 10], 0.2);
  const auto nearest = face_distances(*kernels, posed(kernels->asset), count, bounds, clay);
  EXPECT_GT(nearest[nearest.size() / 2], 0.1);
}

// At three standard deviations, no kernel extends farther into a neighbouring piece than the specified
// distance.
TEST_F(BrokenCup, KernelsDoNotCrossCracks) {
  const double stated_m = bounds.diagonal().norm() / 200;
  const PosedKernels at = posed(kernels->asset);
  const auto reach_to = [&](size_t k, uint32_t cell, uint32_t other) {
    const Eigen::Vector3d normal = (pieces->seeds_m[other] - pieces->seeds_m[cell]).normalized();
    const auto& s = at.covariances_m2[k];
    Eigen::Matrix3d covariance;
    covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    return normal.dot(at.positions_m[k].cast<double>() -
                      0.5 * (pieces->seeds_m[cell] + pieces->seeds_m[other])) +
           3.0 * std::sqrt(std::max(0.0, normal.dot(covariance * normal)));
  };
  double worst_m = 0.0;
  for (size_t k = 0; k < kernels->asset.size(); ++k) {
    const uint32_t cell = pieces->cell_at(at.positions_m[k].cast<double>());
    if (pieces->cell_parts[cell].size() > 1)
      continue;  // another part of the cell may belong to the same piece
    for (uint32_t other : pieces->cell_neighbours[cell]) {
      const auto& parts = pieces->cell_parts[other];
      if (parts.size() == 1 && parts[0].piece != kernels->piece[k])
        worst_m = std::max(worst_m, reach_to(k, cell, other));
    }
  }
  EXPECT_LT(worst_m, 1.06 * stated_m);  // 0.8 mm
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
}

// Returns the pixels where a mesh is visible, or that are within `wider_px` of it.
std::vector<char> silhouette(const TriangleMesh& mesh, const Camera& camera, double wider_px) {
  std::vector<char> seen(size_t{1} * camera.width * camera.height, 0);
  const Pose camera_from_world = camera.world_from_camera.inverse();
  for (const auto& face : mesh.triangles) {
    Eigen::Vector2d at[3];
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d place = camera_from_world * mesh.vertices_m[face[c]];
      at[c] = {camera.centre_x_px - camera.focal_x_px * place.x() / place.z(),
               camera.centre_y_px + camera.focal_y_px * place.y() / place.z()};
    }
    const Eigen::Vector2d low = at[0].cwiseMin(at[1]).cwiseMin(at[2]).array() - wider_px - 1;
    const Eigen::Vector2d high = at[0].cwiseMax(at[1]).cwiseMax(at[2]).array() + wider_px + 1;
    for (int y = std::max(0, static_cast<int>(low.y()));
         y <= std::min(camera.height - 1, static_cast<int>(high.y())); ++y) {
      for (int x = std::max(0, static_cast<int>(low.x()));
           x <= std::min(camera.width - 1, static_cast<int>(high.x())); ++x) {
        const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
        double inside = 1, nearest = 1e9;
        const double turn =
            (at[1] - at[0]).x() * (at[2] - at[0]).y() - (at[1] - at[0]).y() * (at[2] - at[0]).x();
        for (int c = 0; c < 3; ++c) {
          const Eigen::Vector2d from = at[c], along = at[(c + 1) % 3] - from, to = pixel - from;
          inside = std::min(inside, (along.x() * to.y() - along.y() * to.x()) * (turn > 0 ? 1 : -1));
          const double share = std::clamp(to.dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
          nearest = std::min(nearest, (to - share * along).norm());
        }
        if (inside >= 0 || nearest <= wider_px) seen[static_cast<size_t>(y) * camera.width + x] = 1;
      }
    }
  }
  return seen;
}

// Draws each piece alone and measures its kernels outside its own mesh, where the rest of the cup was. Such
// kernels would bridge a crack. Compares with uncut kernels, each bound to the piece at its centre.
TEST_F(BrokenCup, PiecesDoNotBridgeCracks) {
  constexpr float kSeen = 0.1f;
  const auto outside_share = [&](const GaussianAsset& asset,
                                 const std::function<bool(size_t, uint32_t)>& is_of) {
    size_t over = 0, covered = 0;
    for (uint32_t piece = 0; piece < pieces->pieces.size(); ++piece) {
      GaussianAsset alone = asset;
      for (size_t k = 0; k < asset.size(); ++k) {
        if (!is_of(k, piece)) alone.opacity_logits[k] = -20.0f;
      }
      const Camera camera = frame_bounds(bounds, 320, 240, 0.3, 0.35);
      const double distance_m = (camera.world_from_camera.position_m - bounds.center()).norm();
      const double stated_px = bounds.diagonal().norm() / 200 * camera.focal_x_px / distance_m;
      const std::vector<char> own = silhouette(pieces->pieces[piece].mesh, camera, stated_px + 1);
      std::vector<char> others(own.size(), 0);
      for (uint32_t other = 0; other < pieces->pieces.size(); ++other) {
        if (other == piece) continue;
        const std::vector<char> its = silhouette(pieces->pieces[other].mesh, camera, 0);
        for (size_t i = 0; i < its.size(); ++i) others[i] |= its[i];
      }
      RasterisedView view;
      Rasteriser rasteriser;
      const PosedKernels at = posed(alone);
      const DrawnObject object{&alone, &at, 0};
      rasteriser.draw(std::span(&object, 1), camera, {}, view);
      for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
          if (view.image.at(x, y)[3] < kSeen) continue;
          const size_t i = static_cast<size_t>(y) * camera.width + x;
          ++covered;
          over += !own[i] && others[i];
        }
      }
    }
    return static_cast<double>(over) / static_cast<double>(covered);
  };
  const double cut =
      outside_share(kernels->asset, [&](size_t k, uint32_t piece) { return kernels->piece[k] == piece; });
  const double uncut =
      outside_share(*cup, [&](size_t k, uint32_t piece) { return kernels->piece[k] == piece; });
  std::printf("visible across cracks: %.5f of the covered area; with uncut kernels %.5f\n", cut, uncut);
  EXPECT_EQ(cut, 0.0);
  EXPECT_GT(uncut, 5e-3);
}

}  // namespace
}  // namespace livegs
