// SPDX-License-Identifier: Apache-2.0
// Pictures with kernels that the device skins from drivers.
#include <random>

#include "client/render/renderer/renderer_fixture.h"
#include "common/skin/kernels/rest_bodies.h"
#include "compute/cpu_backend.h"
#include "render/scene_view.h"
#include "skin/device_skin.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/raster/frame_splats.h"

namespace livegs {
namespace {

using namespace livegs::testing;

constexpr double kCellWidth_m = 0.05;

// Kernels of three bands within 0.3 m, coloured by position.
std::shared_ptr<const GaussianAsset> cloud_asset(const RestBody& rest, size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  while (points.size() < count) points.push_back(uniform3(random, -0.15, 0.15));
  auto asset = std::make_shared<GaussianAsset>(kernels_at(rest, points, seed + 1));
  asset->sh_degree = 3;
  asset->resize(count);
  for (size_t k = 0; k < count; ++k) {
    asset->opacity_logits[k] = 1.5f;
    asset->sh_dc[k] = (8.0 * points[k]).cast<float>();
    for (size_t c = 0; c < asset->sh_rest_count(); ++c)
      asset->sh_rest[k * asset->sh_rest_count() + c] = uniform3(random, -0.1, 0.1).cast<float>();
  }
  return asset;
}

// One object of each driver kind, side by side.
struct Things {
  RestBody rigid, lattice, particles;

  Things() {
    for (const double x : {-0.1, 0.1}) rigid.bodies.push_back({{x, 0, 0}, Eigen::Quaterniond::Identity()});
    lattice = lattice_body(6, 6, 6, kCellWidth_m, nullptr, {-3, -3, -3});
    particles.kind = DriverKind::Particles;
    std::mt19937_64 random(1);
    for (int p = 0; p < 100; ++p)
      particles.particles_m.push_back(uniform3(random, -0.15, 0.15).cast<float>());
  }

  void add_to(SceneView& view, size_t kernels = 1500) const {
    uint32_t id = 0;
    for (const RestBody* rest : {&rigid, &lattice, &particles}) {
      ++id;
      const auto added = view.add(id, cloud_asset(*rest, kernels, id), *rest, false);
      ASSERT_TRUE(added) << added.error().message;
    }
  }

  // Poses at a given time: rotated, bent, twisted; the third object has its own time.
  DriverFrame at(double moment, double third) const {
    DriverFrame frame;
    ObjectDrivers apart;
    for (const double side : {-1.0, 1.0}) {
      apart.poses.push_back({{-0.5 + side * (0.1 + 0.05 * moment), 0, 0},
                             Eigen::Quaterniond(Eigen::AngleAxisd(side * moment, Eigen::Vector3d::UnitZ()))});
    }
    frame.objects.push_back(apart);
    frame.objects.push_back(moved_drivers(lattice, [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
      return Eigen::AngleAxisd(4 * moment * x.y(), Eigen::Vector3d::UnitY()) *
             Eigen::Vector3d(x.x(), (1 + moment) * x.y(), x.z());
    }));
    const Eigen::AngleAxisd turn(third, Eigen::Vector3d::UnitY());
    frame.objects.push_back(moved_drivers(
        particles,
        [&](const Eigen::Vector3d& x) -> Eigen::Vector3d { return Eigen::Vector3d(0.5, 0, 0) + turn * x; },
        Eigen::Quaterniond(turn)));
    for (uint32_t i = 0; i < 3; ++i) frame.objects[i].object_id = i + 1;
    return frame;
  }
};

class DeviceSkinning : public VulkanPictures {
 protected:
  const Camera eye_ = look_at({0.2, 0.4, 1.5}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 200, 120);
  const Things things_;
};

TEST_F(DeviceSkinning, MovedObjectsMatchReference) {
  SceneView device(std::move(renderer_)), host;
  things_.add_to(device);
  things_.add_to(host);
  const std::pair<double, double> moments[] = {{0, 0}, {0.4, 0}, {0.8, 0.7}, {0.8, 0.7}};
  const size_t moved[] = {3, 2, 3, 0},
               skinned_on_host[] = {1, 0, 1, 0};  // passes skin all kinds except particles
  for (size_t i = 0; i < std::size(moments); ++i) {
    const DriverFrame frame = things_.at(moments[i].first, moments[i].second);
    std::vector<Image> made, expected;
    ASSERT_TRUE(device.draw(frame, {&eye_, 1}, made));
    EXPECT_NE(device.renderer_name(), "cpu");
    EXPECT_EQ(device.last_times().objects_moved, moved[i]) << i;
    EXPECT_EQ(device.last_times().objects_skinned, skinned_on_host[i]) << i;
    ASSERT_TRUE(host.draw(frame, {&eye_, 1}, expected));
    for (float& value : expected[0].pixels) value = std::min(value, 1.0f);
    const double db = psnr_db(made[0], expected[0]);
    RecordProperty("moment_" + std::to_string(i), std::to_string(db));
    EXPECT_GE(db, kBar_db) << i;
  }
}

// Independent of the number of buffers: bodies and lattices are posed by passes, particles on the host.
TEST_F(DeviceSkinning, SplitBuffersGiveSamePicture) {
  SceneView whole(std::move(renderer_));
  things_.add_to(whole);
  const DriverFrame frame = things_.at(0.4, 0.7);
  size_t kernels = 0;
  std::vector<Image> expected, made;
  ASSERT_TRUE(whole.draw(frame, {&eye_, 1}, expected));
  for (uint32_t id = 1; id <= 3; ++id) kernels += whole.drawn_object(id)->asset->size();
  make_renderer({.method = DrawMethod::Quads,
                 .precision = BlendPrecision::Half,
                 .max_part_rows = static_cast<uint32_t>(kernels / 2 - 300)});
  SceneView parted(std::move(renderer_));
  things_.add_to(parted);
  ASSERT_TRUE(parted.draw(frame, {&eye_, 1}, made));
  EXPECT_EQ(parted.notice(), "");
  EXPECT_EQ(made[0].pixels, expected[0].pixels);
}

// Position queries give the same result as a view that draws on the CPU, and skin only the queried objects.
TEST_F(DeviceSkinning, QueriesSkinOnlyQueriedObjects) {
  SceneView device(std::move(renderer_)), host;
  things_.add_to(device);
  things_.add_to(host);
  const DriverFrame frame = things_.at(0.5, 0.2);
  std::vector<Image> images;
  ASSERT_TRUE(device.draw(things_.at(0.4, 0.2), {&eye_, 1}, images));
  ASSERT_TRUE(device.pose(frame));
  ASSERT_TRUE(host.pose(frame));
  const Eigen::Vector3d from(-0.6, 0, 1.5), along = -Eigen::Vector3d::UnitZ();
  const auto there = device.pick(from, along), expected = host.pick(from, along);
  ASSERT_TRUE(there && expected);
  EXPECT_EQ(there->object_id, 1u);
  EXPECT_EQ(there->kernel, expected->kernel);
  EXPECT_EQ(there->point_m, expected->point_m);
  EXPECT_EQ(device.last_times().objects_skinned, 1u);
  EXPECT_FALSE(device.pick({0, 5, 1.5}, along));
  const Eigen::AlignedBox3f at_the_end(Eigen::Vector3f(-0.75f, -0.1f, -0.1f),
                                       Eigen::Vector3f(-0.7f, 0.1f, 0.1f));
  ASSERT_EQ(device.drawn_near(at_the_end).size(), 1u);
  EXPECT_EQ(device.drawn_near(at_the_end)[0].object_id, 1u);
  EXPECT_EQ(device.last_times().objects_skinned, 1u);
  EXPECT_EQ(device.kernel_position_m(2, 7), host.kernel_position_m(2, 7));
  EXPECT_EQ(device.last_times().objects_skinned, 2u);
  EXPECT_FALSE(device.drawn_object(9));
}

// A frame of moving objects is one submission with nodes, bodies and eyes only.
TEST_F(DeviceSkinning, FrameUploadsDriversInOneSubmission) {
  struct Thing {
    const RestBody* rest;
    std::shared_ptr<const GaussianAsset> asset;
    KernelBindings bindings;
  };
  std::vector<Thing> things;
  for (const RestBody* rest : {&things_.rigid, &things_.lattice}) {
    auto asset = cloud_asset(*rest, 3000, 5);
    auto bindings = bind_kernels(*asset, *rest);
    ASSERT_TRUE(bindings);
    things.push_back({rest, asset, *std::move(bindings)});
  }
  std::vector<Image> images;
  for (uint64_t picture = 1; picture <= 3; ++picture) {
    const DriverFrame frame = things_.at(0.2 * static_cast<double>(picture), 0);
    std::vector<RenderedObject> objects;
    for (uint32_t i = 0; i < 2; ++i)
      objects.push_back({{things[i].asset.get(), nullptr, i},
                         picture,
                         i + 1,
                         {things[i].rest, &things[i].bindings, &frame.objects[i]}});
    const std::array eyes{eye_, eye_};
    const auto done = renderer_->draw(objects, eyes, {}, images);
    ASSERT_TRUE(done) << done.error().message;
    if (picture == 1) continue;  // assets, and the multiview check
    EXPECT_EQ(renderer_->last_times().uploaded_bytes,
              2 * 64 + things_.lattice.node_coordinates.size() * 64 + sizeof(FrameViews));
    EXPECT_EQ(renderer_->last_times().submissions, 1u);
    ASSERT_TRUE(renderer_->last_times().device);
    EXPECT_GT(renderer_->last_times().device->skin_ms, 0.0);
  }
}

// Three bands in stereo, including drivers and sorting, without pictures: at first, after small and large
// growth of the scene, and after it has shrunk.
TEST(DeviceBytes, KernelUsesAtMost256BytesAfterResizing) {
  const RestBody rest = lattice_body(6, 6, 6, kCellWidth_m, nullptr, {-3, -3, -3});
  CpuBackend backend;
  FrameSplats frame(backend);
  const std::array<Camera, 2> eyes{};
  std::vector<DeviceKernels> kernels;
  std::vector<DeviceSkin> skins;
  const auto drivers = rest_drivers(rest);
  const auto add = [&](size_t count) {
    const auto asset = cloud_asset(rest, count, count);
    const auto bindings = bind_kernels(*asset, rest);
    ASSERT_TRUE(bindings);
    auto skin = DeviceSkin::create(backend, rest, *bindings);
    auto made = DeviceKernels::create(backend, *asset);
    ASSERT_TRUE(skin && made);
    ASSERT_TRUE(skin->move(rest, *bindings, drivers));
    skins.push_back(*std::move(skin));
    kernels.push_back(*std::move(made));
  };
  const auto bytes_a_kernel = [&] {
    std::vector<FrameSplats::Object> objects;
    size_t bytes = 0, count = 0;
    for (size_t i = 0; i < kernels.size(); ++i) {
      objects.push_back({&kernels[i], [&skins, i](uint32_t first, uint32_t some, BufferId posed) {
                           return skins[i].pose(first, some, posed);
                         }});
      bytes += kernels[i].device_bytes() + skins[i].device_bytes();
      count += kernels[i].size();
    }
    const auto projected = frame.project(objects, eyes, {});
    EXPECT_TRUE(projected) << projected.error().message;
    return static_cast<double>(bytes + frame.device_bytes()) / static_cast<double>(count);
  };
  add(60'000);
  EXPECT_LE(bytes_a_kernel(), 256.0);
  EXPECT_GE(bytes_a_kernel(), 236.0);  // nothing is left out
  for (const size_t more : {500u, 20'000u, 90'000u}) {
    add(more);
    EXPECT_LE(bytes_a_kernel(), 256.0) << more;
  }
  kernels.erase(kernels.begin() + 1, kernels.end());
  skins.erase(skins.begin() + 1, skins.end());
  EXPECT_LE(bytes_a_kernel(), 256.0);
}

}  // namespace
}  // namespace livegs
