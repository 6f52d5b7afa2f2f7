// SPDX-License-Identifier: Apache-2.0
#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"
#include "splat/passes/key_sorter.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/raster/frame_splats.h"

namespace livegs {
namespace {

using LargePasses = OnEveryBackend;
INSTANTIATE_TEST_SUITE_P(Backend, LargePasses, testing::Values("cpu", "vulkan"), backend_name);

std::vector<uint32_t> random_keys(size_t count, uint64_t seed) {
  synthetic::Random random(seed);
  std::vector<uint32_t> keys(count);
  for (uint32_t& key : keys) key = static_cast<uint32_t>(random.uniform(0, 0x1p32));
  return keys;
}

TEST_P(LargePasses, SortFourMillionKeys) {
  const std::vector<uint32_t> keys = random_keys(size_t{4} << 20, 5);
  auto sorter = KeySorter::create(*backend_, size_t{4} << 20);
  ASSERT_TRUE(sorter) << sorter.error().message;
  ASSERT_TRUE(backend_->upload(sorter->keys(), std::as_bytes(std::span(keys))));
  ASSERT_TRUE(sorter->sort(size_t{4} << 20, {.index_values = true}));
  const auto sorted = read_all<uint32_t>(sorter->keys(), keys.size());
  const auto values = read_all<uint32_t>(sorter->values(), keys.size());
  std::vector<bool> seen(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    ASSERT_EQ(sorted[i], keys[values[i]]);
    ASSERT_FALSE(seen[values[i]]);
    seen[values[i]] = true;
    if (i == 0) continue;
    ASSERT_LE(sorted[i - 1], sorted[i]);
    if (sorted[i - 1] == sorted[i]) {
      ASSERT_LT(values[i - 1], values[i]);
    }
  }
}

// More kernels than one part, as required by lavapipe's limit of 128 MiB per buffer. The second part has its
// own poses, shapes and colours.
TEST_P(LargePasses, ProjectAnObjectInTwoParts) {
  constexpr size_t kCount = DeviceKernels::kMaxPartKernels + 1000;
  synthetic::Object object;
  object.asset.resize(kCount);
  object.posed.resize(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const float x = static_cast<float>(i % 1000) * 1e-3f - 0.5f;
    object.asset.opacity_logits[i] = 1.0f;
    object.asset.sh_dc[i] = {x, 0, i < DeviceKernels::kMaxPartKernels ? 0.0f : 1.0f};
    object.posed.positions_m[i] = {x, 0, -static_cast<float>(i) * 1e-6f};
    object.posed.covariances_m2[i] = {1e-4f, 0, 0, 1e-4f, 0, 1e-4f};
    object.posed.world_from_asset[i].setIdentity();
  }
  auto kernels = DeviceKernels::create(*backend_, object.asset);
  ASSERT_TRUE(kernels) << kernels.error().message;
  ASSERT_EQ(kernels->parts().size(), 2u);
  ASSERT_TRUE(kernels->pose(object.posed));
  const Camera eye = look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 320, 240);
  const FrameSplats::Object one{&*kernels, {}};
  FrameSplats frame(*backend_);
  const auto projected = frame.project({&one, 1}, {&eye, 1}, {.order = DepthOrder::ViewZ});
  ASSERT_TRUE(projected) << projected.error().message;
  ASSERT_TRUE(frame.sort());
  EXPECT_EQ(read_all<SortedCount>(frame.counted(), 1)[0].instance_count, kCount);
  const auto order = read_all<uint32_t>(frame.order(), kCount);
  for (size_t i = 1; i < kCount;
       ++i)  // depth may grow by less than a rounding step; equal keys keep their order
    ASSERT_LT(order[i - 1], order[i]) << i;
  const auto rows = read_all<SplatRow>(frame.rows(0), kCount);
  for (size_t i = 0; i < kCount; i += i < DeviceKernels::kMaxPartKernels ? 9973 : 1) {
    const float x = static_cast<float>(i % 1000) * 1e-3f - 0.5f;
    ASSERT_NEAR(rows[i].red, 0.5f + 0.28209479f * x, 1e-6f) << i;
    ASSERT_NEAR(rows[i].blue, i < DeviceKernels::kMaxPartKernels ? 0.5f : 0.78209479f, 1e-6f) << i;
    const double depth = 2.0 + 1e-6 * static_cast<double>(i);
    ASSERT_NEAR(rows[i].centre_x_px, 160.0 + eye.focal_x_px * x / depth, 1e-3) << i;
  }
}

}  // namespace
}  // namespace livegs
