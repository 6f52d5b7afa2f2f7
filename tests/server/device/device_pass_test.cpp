// SPDX-License-Identifier: Apache-2.0
// The elastic passes compared with their twins, on blocks that need no solver. Also part of
// livegs-gpu-report.
#include <memory>

#include "common/compute/backends.h"
#include "device/device_elastic.h"
#include "server/device/comparing_backend.h"
#include "server/device/flat_block.h"

namespace livegs::test {
namespace {

std::vector<std::unique_ptr<FlatBlock>> blocks() {
  std::vector<std::unique_ptr<FlatBlock>> all;
  const auto add = [&](const FlatBlock::Options& options) {
    all.push_back(std::make_unique<FlatBlock>(options));
  };
  add({.cells = {4, 3, 5}, .steps = 6, .height_m = 0.034});
  add({.cells = {9, 2, 3}, .steps = 3, .height_m = 0.2, .held = true});
  add({.cells = {3, 6, 3}, .steps = 4, .height_m = 0.5, .loaded = true});
  add({.cells = {1, 1, 1}, .steps = 5, .height_m = 0.3, .touches = false});
  add({.cells = {12, 2, 9}, .steps = 4, .height_m = 0.024});
  return all;
}

// A floor, with a box and a ball in it that the first and the last block meet as well.
std::vector<Collider> ground() {
  std::vector<Collider> all(3);
  all[0].shape = PlaneShape{};
  all[1].shape = BoxShape{.size_m = {0.03, 0.02, 0.05}};
  all[1].world_from_collider.position_m = {0.02, 0.0, 0.0};
  all[1].world_from_collider.orientation = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized());
  all[2].shape = SphereShape{.radius_m = 0.03};
  all[2].world_from_collider.position_m = {-0.02, -0.02, 0.01};
  return all;
}

// Some ticks of all blocks in one call.
void run(DeviceElastic& device, std::vector<std::unique_ptr<FlatBlock>>& all, int ticks) {
  const std::vector<Collider> colliders = ground();
  for (int k = 0; k < ticks; ++k) {
    FlatTick tick;
    tick.duration_s = 1.0 / 90.0;
    tick.start_s = k * tick.duration_s;
    tick.substeps = 4;
    tick.gravity_m_s2 = {0.0, -9.81, 0.0};
    tick.colliders = colliders;
    std::vector<DeviceBody> bodies;
    for (const auto& block : all) bodies.push_back({block.get(), {}});
    device.step(bodies, tick);
    for (const DeviceBody& body : bodies) ASSERT_EQ(body.reason, nullptr) << device.failure();
  }
}

class ElasticPass : public OnEveryBackend {};
INSTANTIATE_TEST_SUITE_P(Backend, ElasticPass, ::testing::Values("vulkan"), backend_name);

TEST_P(ElasticPass, EachMatchesItsTwin) {
  CpuBackend cpu;
  ComparingBackend both(cpu, *backend_);
  auto all = blocks();
  {
    DeviceElastic device(both);
    ASSERT_NO_FATAL_FAILURE(run(device, all, 3));
  }
  EXPECT_TRUE(all.front()->touched() && all.back()->touched());
  for (const auto& block : all) EXPECT_TRUE(block->finite());
  for (const char* pass :
       {"elastic_predict", "elastic_cells", "elastic_contact", "elastic_advance", "elastic_ledger"})
    EXPECT_EQ(both.compared().count(pass), 1u) << pass;
}

TEST_P(ElasticPass, TwoRunsHaveTheSameBits) {
  auto once = blocks(), again = blocks();
  for (auto* all : {&once, &again}) {
    DeviceElastic device(*backend_);
    ASSERT_NO_FATAL_FAILURE(run(device, *all, 4));
  }
  for (size_t i = 0; i < once.size(); ++i) {
    const auto& a = once[i]->state().now;
    const auto& b = again[i]->state().now;
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]), 0) << "block " << i;
  }
}

}  // namespace
}  // namespace livegs::test
