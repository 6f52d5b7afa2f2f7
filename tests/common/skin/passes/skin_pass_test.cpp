// SPDX-License-Identifier: Apache-2.0
// Compares the skinning passes with skin_kernels.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/compute/backends.h"
#include "common/skin/kernels/rest_bodies.h"
#include "gaussian/asset/posed_kernel_row.h"
#include "skin/device_skin.h"
#include "skin/passes/skin_rigid_pass.h"

namespace livegs {
namespace {

using namespace livegs::testing;

constexpr double kCellWidth_m = 0.05;

class SkinPass : public OnEveryBackend {
 protected:
  struct Bound {
    GaussianAsset asset;
    RestBody rest;
    KernelBindings bindings;
  };
  static Bound bind(const RestBody& rest, const std::vector<Eigen::Vector3d>& points_m, uint64_t seed) {
    Bound bound{kernels_at(rest, points_m, seed), rest, {}};
    auto bindings = bind_kernels(bound.asset, rest);
    EXPECT_TRUE(bindings) << bindings.error().message;
    if (bindings) bound.bindings = *std::move(bindings);
    return bound;
  }

  // Poses the kernels in ranges of `at_once`, as for a frame.
  std::vector<PosedKernelRow> rows_of(const Bound& bound, const ObjectDrivers& drivers, uint32_t at_once,
                                      const std::vector<uint32_t>& kept = {}) {
    auto skin = DeviceSkin::create(*backend_, bound.rest, bound.bindings, kept);
    EXPECT_TRUE(skin) << skin.error().message;
    const auto moved = skin->move(bound.rest, bound.bindings, drivers);
    EXPECT_TRUE(moved) << moved.error().message;
    const BufferId posed = make_buffer(at_once * sizeof(PosedKernelRow));
    std::vector<PosedKernelRow> rows;
    for (uint32_t first = 0; first < skin->size(); first += at_once) {
      const uint32_t count = std::min(
          {at_once, skin->size() - first, DeviceSkin::kMaxPartKernels - first % DeviceSkin::kMaxPartKernels});
      const auto done = skin->pose(first, count, posed);
      EXPECT_TRUE(done) << done.error().message;
      const auto piece = read_all<PosedKernelRow>(posed, count);
      rows.insert(rows.end(), piece.begin(), piece.end());
    }
    EXPECT_TRUE(backend_->destroy_buffer(posed));
    return rows;
  }

  // Tolerance 1e-5 relative to the operands: positions of a metre plus the offset of haze, the size of the
  // kernel, a unit quaternion.
  void expect_the_twin(const Bound& bound, const ObjectDrivers& drivers) {
    const auto rows = rows_of(bound, drivers, static_cast<uint32_t>(bound.asset.size()));
    PosedKernels kernels;
    skin_kernels(bound.asset, bound.rest, bound.bindings, drivers, kernels);
    ASSERT_EQ(rows.size(), bound.asset.size());
    for (size_t k = 0; k < rows.size(); ++k) expect_row(rows[k], kernels, k);
  }
  static void expect_row(const PosedKernelRow& row, const PosedKernels& kernels, size_t k) {
    const Eigen::Vector3f& x = kernels.positions_m[k];
    const float reach = 1.0f + x.cwiseAbs().maxCoeff();
    ASSERT_LE((Eigen::Vector3f(row.x_m, row.y_m, row.z_m) - x).cwiseAbs().maxCoeff(), 1e-5f * reach)
        << "kernel " << k;
    const Symmetric3f& s = kernels.covariances_m2[k];
    const Symmetric3f made{row.sxx_m2, row.sxy_m2, row.sxz_m2, row.syy_m2, row.syz_m2, row.szz_m2};
    for (int i = 0; i < 6; ++i)
      ASSERT_LE(std::abs(made[i] - s[i]), 1e-5f * (s[0] + s[3] + s[5])) << "kernel " << k << ", " << i;
    const Eigen::Vector4f q = kernels.world_from_asset[k].coeffs(), turn(row.qx, row.qy, row.qz, row.qw);
    ASSERT_LE(std::min((turn - q).norm(), (turn + q).norm()), 1e-5f) << "kernel " << k;
  }
};
INSTANTIATE_TEST_SUITE_P(Backend, SkinPass, ::testing::Values("cpu", "vulkan"), backend_name);

std::vector<Eigen::Vector3d> inside_and_around(const RestBody& rest, size_t count, uint64_t seed) {
  std::vector<Eigen::Vector3d> points = points_inside(rest, count - count / 4, seed);
  std::mt19937_64 random(seed + 1);
  while (points.size() < count) points.push_back(node_rest_m(rest, 0) + uniform3(random, -0.5, 0.5));
  return points;
}

RestBody ragged_placed(uint64_t seed) {
  RestBody rest = ragged_body(6, 5, 4, kCellWidth_m, seed);
  place(rest, seed + 1);
  return rest;
}

TEST_P(SkinPass, LatticesMatchTheTwin) {
  const RestBody rest = ragged_placed(7);
  const Bound bound = bind(rest, inside_and_around(rest, 5000, 8), 9);
  std::mt19937_64 random(10);
  const Pose pose{uniform3(random, -0.5, 0.5), random_rotation(random)};
  const std::vector<std::pair<const char*, std::function<Eigen::Vector3d(const Eigen::Vector3d&)>>> motions =
      {{"at rest", [](const Eigen::Vector3d& x) { return x; }},
       {"a rigid pose", [&](const Eigen::Vector3d& x) { return pose * x; }},
       {"a twist",
        [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
          return Eigen::AngleAxisd(6.0 * x[1], Eigen::Vector3d::UnitY()) * x +
                 Eigen::Vector3d(0.02 * std::sin(20 * x[1]), 0, 0);
        }},
       {"a stretch past the clamp", [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
          return {6 * x[0], 0.8 * x[1], x[2]};
        }}};
  for (const auto& [name, motion] : motions) {
    SCOPED_TRACE(name);
    ASSERT_NO_FATAL_FAILURE(expect_the_twin(bound, moved_drivers(rest, motion)));
  }
}

// Nodes displaced by up to a cell width: bent, thin and inverted cells.
TEST_P(SkinPass, TornCellsMatchTheTwin) {
  for (const double amplitude : {0.1, 0.4, 1.0}) {
    SCOPED_TRACE(amplitude);
    const RestBody rest = ragged_placed(11);
    const Bound bound = bind(rest, inside_and_around(rest, 20000, 12), 13);
    std::mt19937_64 random(14);
    ObjectDrivers drivers = rest_drivers(rest);
    for (Eigen::Vector3f& position : drivers.positions_m)
      position += (amplitude * kCellWidth_m * uniform3(random, -1, 1)).cast<float>();
    ASSERT_NO_FATAL_FAILURE(expect_the_twin(bound, drivers));
  }
}

TEST_P(SkinPass, CrushedCellsMatchTheTwin) {
  RestBody rest = lattice_body(3, 3, 3, kCellWidth_m);
  const Bound bound = bind(rest, inside_and_around(rest, 2000, 15), 16);
  std::mt19937_64 random(17);
  const Eigen::Quaterniond turn = random_rotation(random);
  const std::vector<Eigen::Vector3d> stretches = {{1, 0, 1},   {1, 1e-3, 1},   {0, 0, 1},    {1e-5, 1, 1e-5},
                                                  {0, 0, 0},   {1, -1, 1},     {1, -0.2, 1}, {-1, -1, -1},
                                                  {100, 1, 1}, {1e-3, 50, -2}, {5, 5, 5},    {0.1, 0.1, 0.1}};
  for (const Eigen::Vector3d& stretch : stretches) {
    for (const Eigen::Quaterniond& turned : {Eigen::Quaterniond::Identity(), turn}) {
      SCOPED_TRACE(stretch.transpose());
      ASSERT_NO_FATAL_FAILURE(
          expect_the_twin(bound, moved_drivers(rest, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
                            return turned * stretch.cwiseProduct(x);
                          })));
    }
  }
}

RestBody three_bodies(uint64_t seed) {
  std::mt19937_64 random(seed);
  RestBody rest;
  rest.object_from_asset.scale = 0.3;
  rest.object_from_asset.rotation = random_rotation(random);
  for (int b = 0; b < 3; ++b) rest.bodies.push_back({uniform3(random, -0.2, 0.2), random_rotation(random)});
  return rest;
}

ObjectDrivers thrown(const RestBody& rest, uint64_t seed) {
  std::mt19937_64 random(seed);
  ObjectDrivers drivers;
  for (size_t b = 0; b < rest.bodies.size(); ++b)
    drivers.poses.push_back({uniform3(random, -1, 1), random_rotation(random)});
  return drivers;
}

std::vector<Eigen::Vector3d> cloud(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  while (points.size() < count) points.push_back(uniform3(random, -0.3, 0.3));
  return points;
}

TEST_P(SkinPass, RigidBodiesMatchTheTwin) {
  const RestBody rest = three_bodies(18);
  for (const size_t count : {1u, 63u, 64u, 65u, 5000u}) {
    const Bound bound = bind(rest, cloud(count, count), 19);
    for (const uint64_t seed : {20u, 21u})
      ASSERT_NO_FATAL_FAILURE(expect_the_twin(bound, thrown(rest, seed)));
  }
}

TEST_P(SkinPass, RangesMatchTheWhole) {
  const RestBody lattice = ragged_placed(22), rigid = three_bodies(23);
  ObjectDrivers bent = rest_drivers(lattice);
  for (Eigen::Vector3f& position : bent.positions_m) position[0] += 2 * position[1] * position[1];
  for (const auto& [rest, drivers] : {std::pair{&lattice, bent}, std::pair{&rigid, thrown(rigid, 24)}}) {
    const Bound bound = bind(*rest, cloud(3000, 25), 26);
    std::vector<uint32_t> every_third;
    for (uint32_t k = 0; k < 3000; k += 3) every_third.push_back(k);
    const auto whole = rows_of(bound, drivers, 3000), pieces = rows_of(bound, drivers, 700),
               kept = rows_of(bound, drivers, 300, every_third);
    ASSERT_EQ(pieces.size(), whole.size());
    ASSERT_EQ(kept.size(), every_third.size());
    for (size_t k = 0; k < whole.size(); ++k)
      ASSERT_EQ(std::memcmp(&pieces[k], &whole[k], sizeof whole[k]), 0) << k;
    for (size_t i = 0; i < kept.size(); ++i)
      ASSERT_EQ(std::memcmp(&kept[i], &whole[3 * i], sizeof kept[i]), 0) << i;
  }
}

TEST_P(SkinPass, SecondPartHasItsOwnKernels) {
  const RestBody rest = three_bodies(27);
  const Bound bound = bind(rest, cloud(DeviceSkin::kMaxPartKernels + 1000, 28), 29);
  const ObjectDrivers drivers = thrown(rest, 30);
  const auto rows = rows_of(bound, drivers, DeviceSkin::kMaxPartKernels);
  PosedKernels kernels;
  skin_kernels(bound.asset, rest, bound.bindings, drivers, kernels);
  ASSERT_EQ(rows.size(), kernels.positions_m.size());
  for (size_t k = 0; k < rows.size(); k += k < DeviceSkin::kMaxPartKernels ? 997 : 1)
    ASSERT_NO_FATAL_FAILURE(expect_row(rows[k], kernels, k));
}

TEST_P(SkinPass, BodiesPastTheEndUseTheLast) {
  const std::vector<RestKernelRow> rest = {{1, 0.1f, 0.2f, 0.3f, 1, 0, 0, 1, 0, 1},
                                           {UINT32_MAX, 0.1f, 0.2f, 0.3f, 1, 0, 0, 1, 0, 1}};
  const std::vector<RigidPoseRow> poses = {{1, 0, 0, 9, 0, 1, 0, 9, 0, 0, 1, 9, 0, 0, 0, 1},
                                           {0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0.6f, 0.8f}};
  const BufferId posed = make_buffer(2 * sizeof(PosedKernelRow));
  const SkinRigidConstants constants{2, 0, 2};
  const std::array buffers{make_buffer_of(rest), make_buffer_of(poses), posed};
  ASSERT_TRUE(backend_->dispatch(skin_rigid_pass(), buffers, std::as_bytes(std::span(&constants, 1)), 2));
  for (const PosedKernelRow& row : read_all<PosedKernelRow>(posed, 2)) {
    EXPECT_FLOAT_EQ(row.x_m, 0.8f);
    EXPECT_FLOAT_EQ(row.y_m, 2.1f);
    EXPECT_FLOAT_EQ(row.z_m, 3.3f);
    EXPECT_FLOAT_EQ(row.qz, 0.6f);
  }
}

}  // namespace
}  // namespace livegs
