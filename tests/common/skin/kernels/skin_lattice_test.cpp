// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "common/skin/kernels/rest_bodies.h"
#include "skin/kernels/cell_fill.h"

namespace livegs {
namespace {

using namespace livegs::testing;

struct Skinned {
  PosedKernels kernels;
  std::vector<Eigen::Matrix3f> gradients;
};

Skinned skin(const GaussianAsset& asset, const RestBody& rest, const ObjectDrivers& drivers) {
  Result<KernelBindings> bindings = bind_kernels(asset, rest);
  EXPECT_TRUE(bindings) << bindings.error().message;
  Skinned skinned;
  if (bindings) skin_kernels(asset, rest, *bindings, drivers, skinned.kernels, &skinned.gradients);
  return skinned;
}

// Inputs are floats: positions near 1 m have an error of 6e-8 m, so an edge of width a has a relative error
// of 1.2e-7 / a, or 2e-6 for 50 mm. A tolerance of 1e-5 allows for five such edges.
constexpr double kCellWidth_m = 0.05;
constexpr double kGradientTolerance = 1e-5;
constexpr double kPositionTolerance_m = 1e-6;

std::vector<RestBody> full_and_ragged() {
  std::vector<RestBody> bodies = {lattice_body(4, 3, 5, kCellWidth_m, nullptr, {-2, 1, -7}),
                                  ragged_body(5, 4, 3, kCellWidth_m, 7), lattice_body(1, 1, 1, kCellWidth_m)};
  for (size_t b = 0; b < bodies.size(); ++b) place(bodies[b], 100 + b);
  return bodies;
}

std::vector<Eigen::Vector3d> points_inside_and_around(const RestBody& rest) {
  std::vector<Eigen::Vector3d> points = points_inside(rest, 300, 1);
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) points.push_back(node_rest_m(rest, 0) + uniform3(random, -0.5, 0.5));
  return points;
}

TEST(SkinLattice, DriversAtRestGiveTheRestAsset) {
  for (const RestBody& rest : full_and_ragged()) {
    const GaussianAsset asset = kernels_at(rest, points_inside_and_around(rest), 3);
    const Skinned skinned = skin(asset, rest, rest_drivers(rest));
    for (size_t k = 0; k < asset.size(); ++k) {
      const Eigen::Matrix3d covariance = rest_covariance_m2(asset, rest, k);
      EXPECT_NEAR((skinned.kernels.positions_m[k].cast<double>() - rest_position_m(asset, rest, k)).norm(),
                  0.0, kPositionTolerance_m);
      EXPECT_NEAR((matrix_of(skinned.kernels.covariances_m2[k]) - covariance).norm() / covariance.norm(), 0.0,
                  3 * kGradientTolerance);
      EXPECT_NEAR(
          angle_between(skinned.kernels.world_from_asset[k].cast<double>(), rest.object_from_asset.rotation),
          0.0, kGradientTolerance);
    }
  }
}

TEST(SkinLattice, AffineMotionIsExact) {
  Eigen::Matrix3d a;
  a << 1.2, 0.3, -0.1, 0.05, 0.8, 0.2, -0.15, 0.1, 1.1;
  const Eigen::Vector3d shift(0.1, -0.3, 0.2);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d polar = svd.matrixU() * svd.matrixV().transpose();
  for (const RestBody& rest : full_and_ragged()) {
    const GaussianAsset asset = kernels_at(rest, points_inside_and_around(rest), 4);
    const auto motion = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return a * x + shift; };
    const Skinned skinned = skin(asset, rest, moved_drivers(rest, motion));
    for (size_t k = 0; k < asset.size(); ++k) {
      const Eigen::Matrix3d covariance = a * rest_covariance_m2(asset, rest, k) * a.transpose();
      const Eigen::Vector3d where = motion(rest_position_m(asset, rest, k));
      // A kernel outside moves with F over its offset, at most 0.9 m here.
      EXPECT_NEAR((skinned.kernels.positions_m[k].cast<double>() - where).norm(), 0.0,
                  kPositionTolerance_m + 0.9 * kGradientTolerance);
      EXPECT_NEAR((skinned.gradients[k].cast<double>() - a).cwiseAbs().maxCoeff(), 0.0, kGradientTolerance);
      EXPECT_NEAR((matrix_of(skinned.kernels.covariances_m2[k]) - covariance).norm() / covariance.norm(), 0.0,
                  3 * kGradientTolerance);
      EXPECT_NEAR(angle_between(skinned.kernels.world_from_asset[k].cast<double>(),
                                Eigen::Quaterniond(polar) * rest.object_from_asset.rotation),
                  0.0, 3 * kGradientTolerance);
    }
  }
}

TEST(SkinLattice, RigidMotionKeepsKernelSizes) {
  std::mt19937_64 random(5);
  for (const RestBody& rest : full_and_ragged()) {
    const GaussianAsset asset = kernels_at(rest, points_inside_and_around(rest), 6);
    const Pose pose{uniform3(random, -0.5, 0.5), random_rotation(random)};
    const Skinned skinned =
        skin(asset, rest, moved_drivers(rest, [&](const Eigen::Vector3d& x) { return pose * x; }));
    for (size_t k = 0; k < asset.size(); ++k) {
      const Eigen::Vector3d sizes =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix_of(skinned.kernels.covariances_m2[k]))
              .eigenvalues();
      const Eigen::Vector3d at_rest =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rest_covariance_m2(asset, rest, k)).eigenvalues();
      EXPECT_NEAR((sizes - at_rest).norm() / at_rest.norm(), 0.0, 3 * kGradientTolerance);
    }
  }
}

// Sines with a wavelength of four cells: smooth, and far from affine within a cell.
Eigen::Vector3d wobble(const Eigen::Vector3d& x, const Eigen::Matrix3d& waves, double amplitude_m) {
  return x + amplitude_m * (waves * x).array().sin().matrix();
}

Eigen::Matrix3d random_waves(std::mt19937_64& random) {
  Eigen::Matrix3d waves;
  for (int i = 0; i < 9; ++i) waves(i / 3, i % 3) = uniform(random, -1.0, 1.0);
  return waves * (2.0 * M_PI / (4.0 * kCellWidth_m));
}

TEST(SkinLattice, IsContinuousAcrossCellFaces) {
  std::mt19937_64 random(8);
  RestBody rest = lattice_body(4, 4, 4, kCellWidth_m);
  // Pairs of equal kernels at 2e-6 cells on both sides of a face across x.
  const double gap = 2e-6 * kCellWidth_m;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d on_face(kCellWidth_m * static_cast<double>(1 + i % 3), uniform(random, 0.0, 0.2),
                                  uniform(random, 0.0, 0.2));
    points.push_back(on_face - gap * Eigen::Vector3d::UnitX());
    points.push_back(on_face + gap * Eigen::Vector3d::UnitX());
  }
  GaussianAsset asset = kernels_at(rest, points, 9);
  for (size_t k = 0; k < asset.size(); k += 2) {
    asset.log_scales[k + 1] = asset.log_scales[k];
    asset.rotations[k + 1] = asset.rotations[k];
  }
  const Eigen::Matrix3d waves = random_waves(random);
  const Skinned skinned = skin(
      asset, rest, moved_drivers(rest, [&](const Eigen::Vector3d& x) { return wobble(x, waves, 0.008); }));
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  double largest_change = 0.0;
  for (size_t k = 0; k < asset.size(); k += 2) {
    EXPECT_NE(bindings->kernels[k].drivers[0], bindings->kernels[k + 1].drivers[0]);
    // F changes by less than 2 between nodes here, so by less than 8e-6 over the gap, plus float rounding.
    EXPECT_NEAR((skinned.gradients[k] - skinned.gradients[k + 1]).norm(), 0.0f, 8e-6 + kGradientTolerance);
    const Eigen::Matrix3d left = matrix_of(skinned.kernels.covariances_m2[k]);
    const Eigen::Matrix3d right = matrix_of(skinned.kernels.covariances_m2[k + 1]);
    EXPECT_NEAR((left - right).norm() / left.norm(), 0.0, 1e-4);
    largest_change =
        std::max(largest_change, (skinned.gradients[k] - Eigen::Matrix3f::Identity()).norm() * 1.0);
  }
  EXPECT_GT(largest_change, 0.2);  // the motion deforms the body
}

TEST(SkinLattice, NeighboursStayTogether) {
  // Between nodes displaced by u, the trilinear map moves two points at distance r apart by at most (1 + L)
  // r. L bounds the difference quotient of u along an edge, summed over the three axes.
  std::mt19937_64 random(10);
  for (int trial = 0; trial < 5; ++trial) {
    RestBody rest = lattice_body(4, 3, 3, kCellWidth_m);
    const Eigen::Matrix3d waves = random_waves(random);
    const auto motion = [&](const Eigen::Vector3d& x) { return wobble(x, waves, 0.01); };
    double steepest = 0.0;
    for (const std::array<uint32_t, 8>& cell : rest.cells) {
      for (int c = 0; c < 8; ++c) {
        for (int d = 0; d < 3; ++d) {
          const Eigen::Vector3d from = node_rest_m(rest, cell[c]), to = node_rest_m(rest, cell[c ^ (1 << d)]);
          steepest = std::max(steepest, (motion(to) - motion(from) - (to - from)).norm() / kCellWidth_m);
        }
      }
    }
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d point = uniform3(random, 0.002, 0.148);
      points.push_back(point);
      points.push_back(point + uniform3(random, -0.001, 0.001));
    }
    const GaussianAsset asset = kernels_at(rest, points, 11);
    const Skinned skinned = skin(asset, rest, moved_drivers(rest, motion));
    for (size_t k = 0; k < points.size(); k += 2) {
      const double apart_m = (points[k] - points[k + 1]).norm();
      EXPECT_LE((skinned.kernels.positions_m[k] - skinned.kernels.positions_m[k + 1]).norm(),
                (1.0 + std::sqrt(3.0) * steepest) * apart_m + kPositionTolerance_m);
    }
  }
}

TEST(SkinLattice, GradientFollowsTheMotionToSecondOrder) {
  // Central differences inside: half the cell width gives a quarter of the error of F at the centre of the
  // body.
  const Eigen::Matrix3d waves = 8.0 * Eigen::Matrix3d::Identity();
  const auto error_for = [&](int cells) {
    const double width = 0.2 / cells;
    RestBody rest = lattice_body(cells, cells, cells, width);
    std::vector<Eigen::Vector3d> points;
    std::mt19937_64 random(12);
    for (int i = 0; i < 200; ++i) points.push_back(uniform3(random, 0.07, 0.13));
    const GaussianAsset asset = kernels_at(rest, points, 13);
    const Skinned skinned = skin(
        asset, rest, moved_drivers(rest, [&](const Eigen::Vector3d& x) { return wobble(x, waves, 0.02); }));
    double error = 0.0;
    for (size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3d slope =
          Eigen::Vector3d::Ones() + (0.16 * (8.0 * points[k]).array().cos()).matrix();
      error +=
          (skinned.gradients[k].cast<double>() - Eigen::Matrix3d(slope.asDiagonal())).norm() / points.size();
    }
    return error;
  };
  const double coarse = error_for(8), fine = error_for(16);
  EXPECT_GT(coarse / fine, 3.0);  // 4 in the limit
}

TEST(SkinLattice, BendingAThinBodyStretchesOnlyOneSide) {
  // The exact gradient of the trilinear map: x-edges are 20 % longer at the top and 20 % shorter at the
  // bottom.
  RestBody rest = lattice_body(1, 1, 1, kCellWidth_m);
  const auto bend = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return {x[0] * (1.0 + 0.4 * (x[1] / kCellWidth_m - 0.5)), x[1], x[2]};
  };
  const double half = 0.5 * kCellWidth_m;
  const GaussianAsset asset =
      kernels_at(rest, {{half, 0.0, half}, {half, half, half}, {half, kCellWidth_m, half}}, 14);
  const Skinned skinned = skin(asset, rest, moved_drivers(rest, bend));
  EXPECT_NEAR(skinned.gradients[0](0, 0), 0.8, kGradientTolerance);
  EXPECT_NEAR(skinned.gradients[1](0, 0), 1.0, kGradientTolerance);
  EXPECT_NEAR(skinned.gradients[2](0, 0), 1.2, kGradientTolerance);
}

TEST(SkinLattice, ColourIsInvariantUnderCommonRotation) {
  // SH are evaluated along world_from_asset⁻¹ * view direction, which must equal the direction at rest.
  std::mt19937_64 random(15);
  RestBody rest = lattice_body(3, 3, 3, kCellWidth_m);
  place(rest, 16);
  const GaussianAsset asset = kernels_at(rest, points_inside(rest, 100, 17), 18);
  const Pose pose{uniform3(random, -0.5, 0.5), random_rotation(random)};
  const Skinned at_rest = skin(asset, rest, rest_drivers(rest));
  const Skinned turned =
      skin(asset, rest, moved_drivers(rest, [&](const Eigen::Vector3d& x) { return pose * x; }));
  const Eigen::Vector3d camera_m(0.3, 1.0, -2.0);
  for (size_t k = 0; k < asset.size(); ++k) {
    const auto direction_in_asset = [k](const PosedKernels& kernels,
                                        const Eigen::Vector3d& eye_m) -> Eigen::Vector3d {
      const Eigen::Vector3d view = (kernels.positions_m[k].cast<double>() - eye_m).normalized();
      return kernels.world_from_asset[k].cast<double>().conjugate() * view;
    };
    EXPECT_NEAR(
        (direction_in_asset(at_rest.kernels, camera_m) - direction_in_asset(turned.kernels, pose * camera_m))
            .norm(),
        0.0, 2 * kGradientTolerance);
  }
}

TEST(SkinLattice, CrushedCellsGiveBoundedKernels) {
  RestBody rest = lattice_body(3, 3, 3, kCellWidth_m);
  const GaussianAsset asset = kernels_at(rest, points_inside_and_around(rest), 19);
  const std::vector<Eigen::Vector3d> stretches = {{1, 0, 1},    {0, 0, 1},   {0, 0, 0},      {1, -1, 1},
                                                  {-1, -1, -1}, {100, 1, 1}, {1e-3, 50, -2}, {1e25, 1, 1}};
  for (const Eigen::Vector3d& stretch : stretches) {
    const Skinned skinned =
        skin(asset, rest, moved_drivers(rest, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
               return stretch.cwiseProduct(x);
             }));
    for (size_t k = 0; k < asset.size(); ++k) {
      ASSERT_TRUE(skinned.kernels.positions_m[k].allFinite()) << stretch.transpose();
      ASSERT_NEAR(skinned.kernels.world_from_asset[k].norm(), 1.0f, 1e-5);
      const Eigen::Vector3d sigma =
          Eigen::JacobiSVD<Eigen::Matrix3d>(skinned.gradients[k].cast<double>()).singularValues();
      EXPECT_LE(sigma[0], kMaxKernelStretch * (1.0 + 1e-5)) << stretch.transpose();
      EXPECT_GE(sigma[2], kMinKernelStretch * (1.0 - 1e-4)) << stretch.transpose();
      EXPECT_GT(skinned.gradients[k].determinant(), 0.0f) << stretch.transpose();
      EXPECT_TRUE(matrix_of(skinned.kernels.covariances_m2[k]).allFinite());
    }
  }
}

TEST(SkinLattice, HazeMovesWithTheBody) {
  // The last layer of cells of a long bar rotates by 90 degrees. Haze half a metre beyond it moves with the
  // mean of the bar.
  RestBody rest = lattice_body(20, 1, 1, kCellWidth_m);
  const double end_m = 20 * kCellWidth_m;
  const GaussianAsset asset = kernels_at(rest, {{end_m + 0.5, 0.025, 0.025}}, 20);
  ObjectDrivers drivers = rest_drivers(rest);
  for (size_t n = 0; n < drivers.positions_m.size(); ++n) {
    if (rest.node_coordinates[n][0] == 20) drivers.positions_m[n] += Eigen::Vector3f(-0.05f, 0.05f, 0.0f);
  }
  const Skinned skinned = skin(asset, rest, drivers);
  const double moved_m =
      (skinned.kernels.positions_m[0].cast<double>() - rest_position_m(asset, rest, 0)).norm();
  // The face moved by 71 mm. Rotating the whole offset with the face would add 700 mm. One cell width of it
  // adds up to 71 mm; the mean gradient of the bar, with 1/20 of its cells rotated, adds 0.45 m * 1.41 / 20 =
  // 32 mm.
  EXPECT_LE(moved_m, 0.071 + 0.071 + 0.033);
}

TEST(BindLattice, NearestMaterialSelectsAmongCoincidentCells) {
  // The left and the right third of one cell, each with its own nodes.
  RestBody rest = lattice_body(1, 1, 1, kCellWidth_m);
  std::array<uint32_t, 8> second;
  for (uint32_t c = 0; c < 8; ++c) {
    second[c] = 8 + c;
    rest.node_coordinates.push_back(rest.node_coordinates[rest.cells[0][c]]);
  }
  rest.cells.push_back(second);
  rest.cell_fills = {fill_of_box({0, 0, 0}, {0.33f, 1, 1}), fill_of_box({0.67f, 0, 0}, {1, 1, 1})};
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-0.2, 0.1, 0.3, 0.45, 0.55, 0.7, 0.9, 1.2}) {
    points.push_back(kCellWidth_m * Eigen::Vector3d(x, 0.5, 1.1));
  }
  const Result<KernelBindings> bindings = bind_kernels(kernels_at(rest, points, 25), rest);
  ASSERT_TRUE(bindings);
  for (size_t k = 0; k < points.size(); ++k) EXPECT_EQ(bindings->kernels[k].drivers[0], k < 4 ? 0u : 1u) << k;
}

TEST(BindLattice, KernelsBindToTheContainingOrNearestCell) {
  RestBody rest = ragged_body(6, 5, 4, kCellWidth_m, 21);
  std::mt19937_64 random(22);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2000; ++i) points.push_back(uniform3(random, -0.3, 0.6));
  const GaussianAsset asset = kernels_at(rest, points, 23);
  const Result<KernelBindings> bindings = bind_kernels(asset, rest);
  ASSERT_TRUE(bindings);
  const auto distance_m = [&](size_t cell, const Eigen::Vector3d& point) {
    const Eigen::Vector3d low = node_rest_m(rest, rest.cells[cell][0]),
                          high = node_rest_m(rest, rest.cells[cell][7]);
    return (point - point.cwiseMax(low).cwiseMin(high)).norm();
  };
  for (size_t k = 0; k < points.size(); ++k) {
    double nearest_m = 1e9;
    for (size_t cell = 0; cell < rest.cells.size(); ++cell)
      nearest_m = std::min(nearest_m, distance_m(cell, points[k]));
    EXPECT_NEAR(distance_m(bindings->kernels[k].drivers[0], points[k]), nearest_m, 1e-6);
  }
}

TEST(BindLattice, InvalidRestBodiesNameTheField) {
  const RestBody good = lattice_body(2, 1, 1, kCellWidth_m);
  const GaussianAsset asset = kernels_at(good, {{0.02, 0.02, 0.02}}, 24);
  const auto message = [&](const std::function<void(RestBody&)>& spoil) {
    RestBody rest = good;
    spoil(rest);
    const Result<KernelBindings> bindings = bind_kernels(asset, rest);
    return bindings ? std::string() : bindings.error().message;
  };
  EXPECT_NE(message([](RestBody& r) { r.cells.clear(); }).find("cell"), std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.cells[1][3] = 12; }).find("refers to node 12 of 12"),
            std::string::npos);
  EXPECT_NE(message([](RestBody& r) { std::swap(r.cells[0][1], r.cells[0][2]); }).find("corner 1"),
            std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.cell_fills.resize(3); }).find("3 fills of 2 cells"),
            std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.cell_width_m = 0.0; }).find("cell_width_m"), std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.cell_width_m = NAN; }).find("cell_width_m"), std::string::npos);
  EXPECT_NE(
      message([](RestBody& r) { r.object_from_lattice.position_m[0] = NAN; }).find("object_from_lattice"),
      std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.object_from_asset.scale = -1.0; }).find("scale"), std::string::npos);
  EXPECT_NE(message([](RestBody& r) { r.node_coordinates[11][0] = INT32_MIN; }).find("corner"),
            std::string::npos);
}

}  // namespace
}  // namespace livegs
