// SPDX-License-Identifier: Apache-2.0
#include "session/support/scene_memory.h"

#include <gtest/gtest.h>

#include <string>

#include "livegs/v1/scene.pb.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

constexpr uint64_t kMb = 1'000'000, kGb = 1'000'000'000;

TEST(SceneMemory, SizesComeFromFilesWithoutDecoding) {
  const ScratchFolder folder;
  folder.write("room.ply",
               "ply\nformat binary_little_endian 1.0\nelement vertex 120000\nproperty float x\nend_header\n");
  folder.write("cup.splat", std::string(32 * 500, 'x'));
  folder.write("cushion.spz", std::string(16 * 700, 'x'));
  folder.write("toy/meta.json", std::string(100, 'x'));
  folder.write("toy/means.webp", std::string(9'900, 'x'));
  folder.write("duck.gltf", R"({ "buffers": [ { "uri": "duck.bin" } ] })");
  folder.write("duck.bin", std::string(32 * 900, 'x'));
  v1::Scene file;
  file.mutable_environment()->set_asset("room.ply");
  for (const char* asset : {"cup.splat", "cushion.spz", "toy", "duck.gltf", "gone.ply"})
    file.add_objects()->set_asset(asset);
  file.add_objects()->mutable_shape()->mutable_box();
  const SceneSize size = scene_size(file, folder.path(), 64);
  EXPECT_EQ(size.kernels, 120'000u + 500 + 700 + 1000 + 901);  // with 40 bytes of JSON
  EXPECT_EQ(size.bodies, 6u);
  EXPECT_EQ(size.clients, 64u);
}

TEST(SceneMemory, EstimateGrowsWithKernelsBodiesAndClients) {
  const uint64_t empty = scene_bytes({});
  EXPECT_LT(empty, 100 * kMb);
  EXPECT_EQ(scene_bytes({.kernels = 1'000'000}) - empty, 800 * kMb);
  EXPECT_EQ(scene_bytes({.bodies = 2}) - empty, 2 * (scene_bytes({.bodies = 1}) - empty));
  EXPECT_EQ(scene_bytes({.clients = 64}) - empty, 64u << 20);
}

TEST(SceneMemory, RefusesAnOversizedSceneInOneLine) {
  EXPECT_TRUE(check_memory(3 * kGb, 3 * kGb));
  const auto refused = check_memory(5 * kGb + 210 * kMb, 3 * kGb + 900 * kMb);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::Unavailable);
  EXPECT_EQ(refused.error().message,
            "scene: needs about 5210 MB, 3900 MB are free; use fewer or smaller assets, fewer --clients, or "
            "a machine with more memory");
}

TEST(SceneMemory, FreeMemoryIsTheMachinesWithoutLimits) {
  const ScratchFolder root;
  root.write("proc/meminfo",
             "MemTotal:       16000000 kB\nMemFree:          100000 kB\nMemAvailable:    8000000 kB\n");
  EXPECT_EQ(free_bytes(root.path()), uint64_t{8'000'000} * 1024);
  root.write("proc/self/cgroup", "0::/\n");
  root.write("sys/fs/cgroup/memory.max", "max\n");
  root.write("sys/fs/cgroup/memory.current", "1000\n");
  EXPECT_EQ(free_bytes(root.path()), uint64_t{8'000'000} * 1024);
}

TEST(SceneMemory, MissingMeminfoLeavesTheWholeMachine) {
  const ScratchFolder root;
  EXPECT_GT(free_bytes(root.path()), 100 * kMb);
}

// The file cache can be dropped, so it counts as free.
TEST(SceneMemory, TheTightestGroupBoundsFreeMemory) {
  const ScratchFolder root;
  root.write("proc/meminfo", "MemAvailable:    8000000 kB\n");
  root.write("proc/self/cgroup", "0::/system.slice/livegs.service\n");
  root.write("sys/fs/cgroup/system.slice/memory.max", "2000000000\n");
  root.write("sys/fs/cgroup/system.slice/memory.current", "900000000\n");
  root.write("sys/fs/cgroup/system.slice/memory.stat", "anon 500000000\ninactive_file 300000000\n");
  root.write("sys/fs/cgroup/system.slice/livegs.service/memory.max", "max\n");
  root.write("sys/fs/cgroup/system.slice/livegs.service/memory.current", "100000000\n");
  EXPECT_EQ(free_bytes(root.path()), 1'400'000'000u);
  root.write("sys/fs/cgroup/system.slice/livegs.service/memory.max", "50000000\n");
  EXPECT_EQ(free_bytes(root.path()), 0u) << "more than the limit is used";
}

// In a container the group's path may not exist below the mount; the mount root is the group.
TEST(SceneMemory, ReadsControlGroupsV1) {
  const ScratchFolder root;
  root.write("proc/meminfo", "MemAvailable:    8000000 kB\n");
  root.write("proc/self/cgroup", "5:cpuset:/\n4:memory:/docker/abc\n0::/\n");
  root.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "1000000000\n");
  root.write("sys/fs/cgroup/memory/memory.usage_in_bytes", "400000000\n");
  EXPECT_EQ(free_bytes(root.path()), 600'000'000u);
}

TEST(SceneMemory, UnreadableSceneIsLeftToTheLoader) {
  EXPECT_TRUE(check_scene_memory("/no/such.scene.json", 64));
}

}  // namespace
}  // namespace livegs
