// SPDX-License-Identifier: Apache-2.0
#include "geometry/fracture/piece_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"
#include "geometry/fracture/fracture_seeds.h"
#include "geometry/fracture/split_gaussian.h"
#include "geometry/fracture/truncated_gaussian.h"
#include "geometry/mesh/mesh_topology.h"
#include "rates.h"
#include "server/geometry/fracture/fracture_shapes.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1.0p-53; }

VoronoiPieces cut(const TriangleMesh& mesh, size_t count, uint64_t seed) {
  return cut_voronoi_pieces(mesh,
                            fracture_seeds(mesh, {.count = count, .seed = seed, .impacts_m = {}}).value())
      .value();
}

// Kernels of all sizes up to `widest_m` on and around the mesh, with harmonics of degree 1.
GaussianAsset kernels_about(const TriangleMesh& mesh, size_t count, double widest_m, double haze_m) {
  std::mt19937_64 engine(count);
  GaussianAsset asset;
  asset.sh_degree = 1;
  asset.resize(count);
  for (size_t k = 0; k < count; ++k) {
    const auto& triangle = mesh.triangles[engine() % mesh.triangles.size()];
    const double r = std::sqrt(uniform(engine)), s = uniform(engine);
    Vector3d place = (1 - r) * mesh.vertices_m[triangle[0]] + r * (1 - s) * mesh.vertices_m[triangle[1]] +
                     r * s * mesh.vertices_m[triangle[2]];
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] += haze_m * (uniform(engine) - 0.5);
      asset.log_scales[k][axis] = static_cast<float>(std::log(widest_m * (0.05 + 0.95 * uniform(engine))));
      asset.sh_dc[k][axis] = static_cast<float>(uniform(engine));
      asset.sh_rest[3 * k + axis] = Vector3d(uniform(engine), 0.5, -1).cast<float>();
    }
    asset.positions[k] = place.cast<float>();
    // Two statements: compilers evaluate arguments in different orders.
    const auto w = static_cast<float>(uniform(engine));
    const auto y = static_cast<float>(uniform(engine));
    asset.rotations[k] = Eigen::Quaternionf(w, 0.3f, y, -0.2f).normalized();
    asset.opacity_logits[k] = static_cast<float>(6.0 * uniform(engine) - 2.0);
  }
  return asset;
}

Matrix3d covariance_of(const GaussianAsset& asset, size_t k) {
  const Matrix3d axes = asset.rotations[k].cast<double>().normalized().toRotationMatrix();
  const Vector3d deviations = asset.log_scales[k].cast<double>().array().exp();
  const Matrix3d scaled = axes * deviations.asDiagonal();
  return scaled * scaled.transpose();
}

// Integral of opacity over space, up to a constant factor.
double mass_of(const GaussianAsset& asset, size_t k) {
  return opacity_of_logit(asset.opacity_logits[k]) * std::exp(asset.log_scales[k].cast<double>().sum());
}

TEST(TruncatedGaussian, AgreesWithSummation) {
  for (const double end : {-7.5, -6.01, -5.99, -3.0, -1.0, 0.0, 0.7, 2.5, 6.0}) {
    double mass = 0, first = 0, second = 0;
    const double step = 1e-4;
    for (double z = end - step / 2; z > end - 14; z -= step) {
      const double p = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi) * step;
      mass += p, first += p * z, second += p * z * z;
    }
    const TruncatedNormal cut = normal_below(end);
    const double mean = first / mass, variance = second / mass - mean * mean;
    EXPECT_NEAR(cut.mass / mass, 1.0, 1e-6) << end;  // the midpoint rule with step 1e-4 is accurate to 1e-8
    EXPECT_NEAR(cut.mean, mean, 2e-3 * std::abs(mean))
        << end;  // the next term of the tail expansion is 10/end⁵
    EXPECT_NEAR(cut.variance / variance, 1.0, end < -6 ? 0.05 : 1e-5) << end;
  }
}

// The parts of a Gaussian together have its mass, mean and covariance. This is exact for one cut. With
// narrower Gaussians their omitted tails are the error.
TEST(SplitGaussian, KeepsTheMomentsOfTheWhole) {
  const auto halves =
      cut_voronoi_pieces(box_mesh({2, 2, 2}), std::vector<Vector3d>{{-0.5, 0.1, 0}, {0.5, 0, 0.2}});
  ASSERT_TRUE(halves);
  Matrix3d shape;
  shape << 0.02, 0.008, -0.004, 0.008, 0.03, 0.002, -0.004, 0.002, 0.01;
  for (const double x : {-0.2, -0.05, 0.0, 0.1, 0.3}) {
    for (const double overhang_m : {1.0, 0.06, 0.03}) {
      const Vector3d mean(x, 0.1, -0.05);
      const auto parts = split_gaussian(mean, shape, *halves, {overhang_m, 1e-9});
      ASSERT_GE(parts.size(), 2u);
      double mass = 0.0;
      Vector3d first = Vector3d::Zero();
      Matrix3d second = Matrix3d::Zero();
      for (const GaussianPart& part : parts) {
        const double share = part.opacity * std::sqrt(part.covariance_m2.determinant() / shape.determinant());
        mass += share;
        first += share * part.mean_m;
        second += share * (part.covariance_m2 + part.mean_m * part.mean_m.transpose());
        EXPECT_LT(
            part.opacity,
            1.07);  // the maximum of P / sqrt(variance) is 1.066, for a cut 0.9 deviations from the mean
        EXPECT_EQ(part.cell, halves->cell_at(part.mean_m));
      }
      // The narrower Gaussians cover at least 3.2 deviations minus one of their spacings. The second moment
      // beyond is 1e-2.
      const bool once = overhang_m == 1.0;
      EXPECT_NEAR(mass, 1.0, once ? 1e-12 : 3e-3);
      EXPECT_LT((first - mean).norm(), (once ? 1e-12 : 2e-2) * std::sqrt(shape(0, 0)));
      EXPECT_LT((second - mean * mean.transpose() - shape).norm(), (once ? 1e-12 : 3e-2) * shape.norm());
    }
  }
}

void expect_bound_once(const GaussianAsset& asset, const PieceKernels& kernels, const VoronoiPieces& pieces,
                       double most_lost) {
  ASSERT_EQ(kernels.original_count, asset.size());
  ASSERT_EQ(kernels.piece.size(), kernels.asset.size());
  ASSERT_EQ(kernels.source.size(), kernels.asset.size());
  std::vector<uint8_t> changed(asset.size(), 0);
  for (uint32_t k : kernels.changed) changed[k] = 1;
  std::vector<double> mass(asset.size(), 0.0);
  for (size_t k = 0; k < kernels.asset.size(); ++k) {
    ASSERT_LT(kernels.piece[k], pieces.pieces.size());
    ASSERT_TRUE(kernels.asset.positions[k].allFinite());
    ASSERT_TRUE(kernels.asset.log_scales[k].allFinite());
    ASSERT_NEAR(kernels.asset.rotations[k].norm(), 1.0, 1e-5);
    if (k < asset.size()) {
      ASSERT_EQ(kernels.source[k], k);  // each kernel occurs once, at its index
      if (!changed[k]) {
        ASSERT_EQ(kernels.asset.positions[k], asset.positions[k]);
        ASSERT_EQ(kernels.asset.log_scales[k], asset.log_scales[k]);
        ASSERT_EQ(kernels.asset.opacity_logits[k], asset.opacity_logits[k]);
        ASSERT_EQ(kernels.piece[k], pieces.locate(asset.positions[k].cast<double>()));
      }
    } else if (k < kernels.interior_begin) {
      ASSERT_TRUE(changed[kernels.source[k]]);  // or is the part of a kernel that was cut
    } else {
      ASSERT_EQ(kernels.source[k], kInteriorKernel);
      continue;
    }
    const uint32_t source = kernels.source[k];
    mass[source] += mass_of(kernels.asset, k);
    ASSERT_EQ(kernels.asset.sh_dc[k], asset.sh_dc[source]);
    ASSERT_EQ(kernels.asset.sh_rest[3 * k + 2], asset.sh_rest[3 * source + 2]);
  }
  // A flattened part may need more opacity than the maximum of 0.998.
  std::vector<uint8_t> held(asset.size(), 0);
  for (size_t k = 0; k < kernels.interior_begin; ++k) {
    if (changed[kernels.source[k]] && opacity_of_logit(kernels.asset.opacity_logits[k]) > 0.9979)
      held[kernels.source[k]] = 1;
  }
  double before = 0.0, lost = 0.0, lost_by_others = 0.0;
  for (size_t k = 0; k < asset.size(); ++k) {
    const double less = mass_of(asset, k) - mass[k];
    before += mass_of(asset, k), lost += less;
    if (!held[k]) lost_by_others += less;
  }
  EXPECT_LT(std::abs(lost_by_others / before),
            0.003);  // dropped faint parts and the ripple of narrower Gaussians
  EXPECT_LT(lost / before, most_lost);
  EXPECT_GT(lost / before, -0.001);
}

// Maximum extent of a kernel beyond the planes between its piece and other pieces, at three standard
// deviations.
double worst_overhang_m(const PieceKernels& kernels, const VoronoiPieces& pieces) {
  double worst = 0.0;
  for (size_t k = 0; k < kernels.asset.size(); ++k) {
    const Vector3d mean = kernels.asset.positions[k].cast<double>();
    const Matrix3d covariance = covariance_of(kernels.asset, k);
    const auto holds = [&](uint32_t cell, auto&& test) {
      return std::any_of(pieces.cell_parts[cell].begin(), pieces.cell_parts[cell].end(), test);
    };
    double least = INFINITY;  // over the cells of its piece
    for (uint32_t cell = 0; cell < pieces.seeds_m.size(); ++cell) {
      if (!holds(cell, [&](const auto& part) { return part.piece == kernels.piece[k]; })) continue;
      double reach = 0.0;
      for (uint32_t other : pieces.cell_neighbours[cell]) {
        if (!holds(other, [&](const auto& part) { return part.piece != kernels.piece[k]; })) continue;
        const Vector3d normal = (pieces.seeds_m[other] - pieces.seeds_m[cell]).normalized();
        const double distance = normal.dot(0.5 * (pieces.seeds_m[other] + pieces.seeds_m[cell]) - mean);
        reach = std::max(reach, 3.0 * std::sqrt(normal.dot(covariance * normal)) - distance);
      }
      least = std::min(least, reach);
    }
    worst = std::max(worst, least);
  }
  return worst;
}

TEST(PieceKernels, BindEachKernelOnceAndBridgeNoCrack) {
  // Bars of the mass that wide kernels lose by the opacity limit, a twentieth above what these kernels lose;
  // narrow kernels lose almost none.
  struct Shape {
    TriangleMesh mesh;
    double wide_lost;
  };
  const Shape shapes[] = {
      {sphere_mesh(0.05, 3), 0.232}, {box_mesh({0.2, 0.1, 0.05}), 0.112}, {testing::cup_mesh(48, 10), 0.213}};
  for (const auto& [mesh, wide_lost] : shapes) {
    // Kernels as wide as a hundredth and an eighth of the object. The latter overlap many cells; above the
    // maximum number of parts they are flattened.
    for (const double widest_m : {0.001, 0.012}) {
      const bool wide = widest_m > 0.01;
      const GaussianAsset asset = kernels_about(mesh, wide ? 400 : 4000, widest_m, 2 * widest_m);
      const VoronoiPieces pieces = cut(mesh, 24, 2);
      const auto kernels = make_piece_kernels(asset, {}, pieces);
      ASSERT_TRUE(kernels);
      expect_bound_once(asset, *kernels, pieces, wide ? wide_lost : 0.001);
      if (HasFatalFailure()) return;
      // The default distance, a 200th of the diagonal. Kernels of cut faces lie a 16th of their spacing
      // behind the face, so they are closer to a plane that meets it at a sharp angle.
      const double stated_m = mesh_bounds_m(mesh).diagonal().norm() / 200;
      EXPECT_LT(worst_overhang_m(*kernels, pieces), 1.06 * stated_m) << widest_m;
    }
  }
}

TEST(PieceKernels, CupKernelsAreBoundOnceForAllSeeds) {
  const TriangleMesh mesh = testing::cup_mesh(32, 8);
  const GaussianAsset asset = kernels_about(mesh, 300, 0.003, 0.006);
  for (uint64_t seed = 1; seed <= static_cast<uint64_t>(seed_count(10)); ++seed) {
    SCOPED_TRACE(seed);
    const VoronoiPieces pieces = cut(mesh, 8 + seed % 9, seed);
    const auto kernels = make_piece_kernels(asset, {}, pieces);
    ASSERT_TRUE(kernels);
    expect_bound_once(asset, *kernels, pieces, 0.005);  // the worst of 100 seeds loses 0.40 %
    if (HasFatalFailure()) return;
  }
}

TEST(PieceKernels, FollowTheFrameOfTheObject) {
  const TriangleMesh mesh = testing::cup_mesh(48, 10);
  Similarity object_from_asset;
  object_from_asset.scale = 0.37;
  object_from_asset.rotation = Eigen::AngleAxisd(0.8, Vector3d(1, 2, -1).normalized());
  object_from_asset.translation_m = {0.1, -0.2, 0.05};
  const VoronoiPieces pieces = cut(mesh, 16, 3);
  const GaussianAsset plain = kernels_about(mesh, 2000, 0.004, 0.0);
  GaussianAsset turned = plain;
  const Eigen::Quaternionf back = object_from_asset.rotation.conjugate().cast<float>();
  for (size_t k = 0; k < plain.size(); ++k) {
    turned.positions[k] = (object_from_asset.rotation.conjugate() *
                           (plain.positions[k].cast<double>() - object_from_asset.translation_m) / 0.37)
                              .cast<float>();
    turned.rotations[k] = (back * plain.rotations[k]).normalized();
    turned.log_scales[k].array() -= std::log(0.37f);
  }
  const auto a = make_piece_kernels(plain, {}, pieces),
             b = make_piece_kernels(turned, object_from_asset, pieces);
  ASSERT_TRUE(a && b);
  size_t moved = 0;
  for (size_t k = 0; k < plain.size(); ++k) moved += a->piece[k] != b->piece[k];
  EXPECT_LE(moved, 2u);  // rounding, on the plane itself
  // Parts of each original kernel, in order. Rounding decides on a part at the limit of faintness.
  const auto parts_of = [](const PieceKernels& kernels) {
    std::map<uint32_t, std::vector<size_t>> parts;
    for (size_t k = 0; k < kernels.asset.size(); ++k) parts[kernels.source[k]].push_back(k);
    return parts;
  };
  const auto parts_a = parts_of(*a), parts_b = parts_of(*b);
  ASSERT_EQ(parts_a.size(), parts_b.size());
  ASSERT_EQ(parts_a.at(kInteriorKernel).size(), parts_b.at(kInteriorKernel).size());
  size_t differ = 0;
  for (const auto& [source, of_a] : parts_a) {
    const std::vector<size_t>& of_b = parts_b.at(source);
    if (of_a.size() != of_b.size()) {
      ++differ;
      continue;
    }
    for (size_t i = 0; i < of_a.size(); ++i) {
      const Vector3d position = a->asset.positions[of_a[i]].cast<double>();
      EXPECT_LT((object_from_asset * b->asset.positions[of_b[i]].cast<double>() - position).norm(), 1e-6);
    }
  }
  EXPECT_LE(differ, 3u);
}

TEST(PieceKernels, AreTheSameBitsForAnyThreadCount) {
  const TriangleMesh mesh = testing::cup_mesh(48, 10);
  const GaussianAsset asset = kernels_about(mesh, 6000, 0.004, 0.004);
  const VoronoiPieces pieces = cut(mesh, 24, 2);
  set_thread_count(1);
  const PieceKernels one = make_piece_kernels(asset, {}, pieces).value();
  for (const int threads : {2, 8}) {
    set_thread_count(threads);
    const PieceKernels many = make_piece_kernels(asset, {}, pieces).value();
    EXPECT_EQ(many.piece, one.piece);
    EXPECT_EQ(many.source, one.source);
    EXPECT_TRUE(many.asset.positions == one.asset.positions);
    EXPECT_TRUE(many.asset.log_scales == one.asset.log_scales);
    EXPECT_TRUE(many.asset.opacity_logits == one.asset.opacity_logits);
    EXPECT_TRUE(many.asset.sh_dc == one.asset.sh_dc);
  }
  set_thread_count(0);
}

// Each point of a cut face, up to the rim, is covered by opaque kernels. Points beyond the rim are not.
TEST(PieceKernels, CoverTheFacesOfTheCut) {
  const TriangleMesh box = box_mesh({0.2, 0.1, 0.06});
  const auto halves = cut_voronoi_pieces(box, std::vector<Vector3d>{{-0.05, 0, 0}, {0.05, 0, 0}});
  ASSERT_TRUE(halves);
  PieceKernelOptions options;
  options.interior_spacing_m = 0.004;
  options.interior_rgb = Eigen::Vector3f(0.6f, 0.5f, 0.4f);
  const PieceKernels kernels =
      make_piece_kernels(kernels_about(box, 500, 0.002, 0.0), {}, *halves, options).value();
  const auto coverage = [&](const Vector3d& place, uint32_t piece) {
    double through = 1.0;
    for (size_t k = kernels.interior_begin; k < kernels.asset.size(); ++k) {
      if (kernels.piece[k] != piece) continue;
      EXPECT_LT(
          ((0.28209479f * kernels.asset.sh_dc[k].array() + 0.5f).matrix() - *options.interior_rgb).norm(),
          1e-6f);
      // Seen along the normal, x: the marginal over y and z.
      const Eigen::Matrix2d flat = covariance_of(kernels.asset, k).bottomRightCorner<2, 2>();
      const Eigen::Vector2d way = (place - kernels.asset.positions[k].cast<double>()).tail<2>();
      through *= 1.0 - opacity_of_logit(kernels.asset.opacity_logits[k]) *
                           std::exp(-0.5 * way.dot(flat.inverse() * way));
    }
    return 1.0 - through;
  };
  std::mt19937_64 engine(1);
  double least = 1.0, mean = 0.0, beyond = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Vector3d inside(0, 0.1 * (uniform(engine) - 0.5) * 0.96, 0.06 * (uniform(engine) - 0.5) * 0.96);
    const double covered = coverage(inside, n % 2);
    least = std::min(least, covered);
    mean += covered / 400;
    beyond = std::max(beyond, coverage({0, 0.0525, 0.06 * (uniform(engine) - 0.5)}, 0));
  }
  EXPECT_GT(least, 0.7);
  EXPECT_GT(mean, 0.97);
  EXPECT_LT(beyond, 0.05);  // 2.5 mm beyond the rim
  for (size_t k = kernels.interior_begin; k < kernels.asset.size(); ++k) {
    const double x = kernels.asset.positions[k].x();
    EXPECT_TRUE(kernels.piece[k] == 0 ? x < 0 : x > 0);
  }
}

// Without an interior colour, cut faces have the colour of the nearby surface: red at one end, blue at the
// other.
TEST(PieceKernels, CutFacesHaveTheNearbySurfaceColour) {
  const TriangleMesh box = box_mesh({0.2, 0.1, 0.06});
  GaussianAsset asset = kernels_about(box, 4000, 0.002, 0.0);
  const Eigen::Vector3f red(1, -1, -1), blue(-1, -1, 1);
  for (size_t k = 0; k < asset.size(); ++k) asset.sh_dc[k] = asset.positions[k].x() < 0 ? red : blue;
  const auto slices = cut_voronoi_pieces(
      box, std::vector<Vector3d>{{-0.08, 0, 0}, {-0.03, 0, 0}, {0.03, 0, 0}, {0.08, 0, 0}});
  ASSERT_TRUE(slices);
  const PieceKernels kernels = make_piece_kernels(asset, {}, *slices).value();
  size_t reds = 0, blues = 0;
  for (size_t k = kernels.interior_begin; k < kernels.asset.size(); ++k) {
    const float x = kernels.asset.positions[k].x();
    if (std::abs(x) < 0.01f) continue;  // the face between the colours
    ++(x < 0 ? reds : blues);
    ASSERT_LT((kernels.asset.sh_dc[k] - (x < 0 ? red : blue)).norm(), 1e-5f) << x;
  }
  EXPECT_GT(reds, 100u);
  EXPECT_GT(blues, 100u);
}

TEST(PieceKernels, StopOnRequest) {
  const VoronoiPieces pieces = cut(box_mesh({1, 1, 1}), 4, 1);
  std::stop_source stop;
  stop.request_stop();
  PieceKernelOptions options;
  options.stop = stop.get_token();
  EXPECT_FALSE(make_piece_kernels(kernels_about(box_mesh({1, 1, 1}), 100, 0.01, 0), {}, pieces, options));
  options = {};
  options.max_overhang_m = -1;
  EXPECT_FALSE(make_piece_kernels({}, {}, pieces, options));
  EXPECT_TRUE(make_piece_kernels({}, {}, pieces));
}

}  // namespace
}  // namespace livegs
