// SPDX-License-Identifier: Apache-2.0
#include "splat/passes/project_splats.h"

#include <cmath>
#include <cstring>

#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"
#include "splat/project/project_kernels.h"
#include "splat/raster/frame_splats.h"

namespace livegs {
namespace {

using synthetic::Object;

struct Projected {
  std::vector<SplatRow> eye[2];
  std::vector<uint32_t> order;
};

// Projects objects on a backend.
Result<Projected> project_on(Backend& backend, const std::vector<const Object*>& objects,
                             std::span<const Camera> eyes, const FrameSplats::Options& options) {
  std::vector<DeviceKernels> kernels;
  std::vector<FrameSplats::Object> in_frame;
  for (const Object* object : objects) {
    auto made = DeviceKernels::create(backend, object->asset);
    if (!made) return made.error();
    if (auto posed = made->pose(object->posed); !posed) return posed.error();
    kernels.push_back(*std::move(made));
  }
  for (size_t i = 0; i < kernels.size(); ++i) in_frame.push_back({&kernels[i], {}, static_cast<uint32_t>(i)});
  FrameSplats frame(backend);
  if (auto done = frame.project(in_frame, eyes, options); !done) return done.error();
  if (auto done = frame.sort(); !done) return done.error();
  Projected projected;
  for (size_t e = 0; e < eyes.size(); ++e) {
    projected.eye[e].resize(frame.kernel_count());
    const auto bytes = std::as_writable_bytes(std::span(projected.eye[e]));
    if (auto done = backend.read(frame.rows(static_cast<int>(e)), bytes); !done) return done.error();
  }
  SortedCount counted;
  if (auto done = backend.read(frame.counted(), std::as_writable_bytes(std::span(&counted, 1))); !done)
    return done.error();
  projected.order.resize(counted.instance_count);
  if (auto done = backend.read(frame.order(), std::as_writable_bytes(std::span(projected.order))); !done)
    return done.error();
  return projected;
}

Projected twin(const std::vector<const Object*>& objects, std::span<const Camera> eyes,
               const FrameSplats::Options& options) {
  CpuBackend backend;
  auto projected = project_on(backend, objects, eyes, options);
  EXPECT_TRUE(projected) << projected.error().message;
  return projected ? *projected : Projected{};
}

constexpr const char* kFields[9] = {"centre_x",     "centre_y", "across_x", "across_y", "down_y",
                                    "log2_opacity", "red",      "green",    "blue"};

std::array<float, 9> values(const SplatRow& row) {
  std::array<float, 9> fields;
  std::memcpy(fields.data(), &row, sizeof row);
  return fields;
}

Camera ahead(double distance_m = 1.6) {
  return look_at({0.1, 0.2, distance_m}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 320, 240);
}

// Two eyes 64 mm apart with asymmetric frusta, as in a headset.
std::array<Camera, 2> headset(double distance_m) {
  std::array<Camera, 2> eyes;
  for (int e = 0; e < 2; ++e) {
    const double side = e == 0 ? -1.0 : 1.0;
    const Pose pose{{side * 0.032, 0.05, distance_m}, Eigen::Quaterniond::Identity()};
    eyes[e] = camera_from_fov(pose, e == 0 ? -0.9 : -0.7, e == 0 ? 0.7 : 0.9, 0.75, -0.85, 240, 256);
  }
  return eyes;
}

// Flat kernels with a thinnest axis of 15 % of the longest, as in captures, and the same number of needles of
// 1:30.
Object cloud(int sh_degree, uint64_t seed) {
  Object object = synthetic::shell(3000, sh_degree, 0.03, seed);
  synthetic::Random random(seed + 1);
  for (size_t i = 0; i < object.size(); i += 2) {
    object.posed.covariances_m2[i] = synthetic::covariance(random.rotation(), {0.06, 0.002, 0.002});
  }
  return object;
}

class ProjectSplatsTest : public OnEveryBackend {
 protected:
  // Tolerance: a device may fuse and reorder operations. Over about thirty of them, that is 1e-5 of the value
  // or, after a cancellation, of the operands: screen pixels, the size of the roots, a power of two, a colour
  // of order one.
  void expect_the_twin(const std::vector<const Object*>& objects, std::span<const Camera> eyes,
                       const FrameSplats::Options& options) {
    const Projected expected = twin(objects, eyes, options);
    const auto made = project_on(*backend_, objects, eyes, options);
    ASSERT_TRUE(made) << made.error().message;
    size_t seen = 0, differ = 0;
    for (size_t e = 0; e < eyes.size(); ++e) {
      ASSERT_EQ(made->eye[e].size(), expected.eye[e].size());
      for (size_t i = 0; i < expected.eye[e].size(); ++i) {
        const auto a = values(made->eye[e][i]), b = values(expected.eye[e][i]);
        if ((a[5] == kCulled_log2) != (b[5] == kCulled_log2)) {
          ++differ;
          continue;
        }
        seen += b[5] != kCulled_log2;
        const float roots = std::abs(b[2]) + std::abs(b[3]) + std::abs(b[4]);
        const float made_from[9] = {320, 320, roots, roots, roots, 1, 1, 1, 1};
        for (int f = 0; f < 9; ++f) {
          ASSERT_LE(std::abs(a[f] - b[f]), 1e-5f * std::max(std::abs(b[f]), made_from[f]))
              << kFields[f] << " of kernel " << i << ", eye " << e << ": " << a[f] << " for " << b[f];
        }
      }
    }
    EXPECT_GT(seen, 1000u);
    EXPECT_LE(differ, 2u);  // rims that end exactly at the edge of the screen
    EXPECT_NEAR(static_cast<double>(made->order.size()), static_cast<double>(expected.order.size()), 2.0);
  }
};
INSTANTIATE_TEST_SUITE_P(Backend, ProjectSplatsTest, testing::Values("cpu", "vulkan"), backend_name);

TEST_P(ProjectSplatsTest, MatchesTheTwinForEachDegree) {
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    const Object object = cloud(degree, 10 + degree);
    const Camera eye = ahead();
    ASSERT_NO_FATAL_FAILURE(expect_the_twin({&object}, {&eye, 1}, {}));
  }
}

TEST_P(ProjectSplatsTest, MatchesTheTwinForTwoEyes) {
  Object turned = synthetic::moved(
      cloud(3, 20),
      {{0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()))});
  Object smoothed = cloud(1, 21);
  smoothed.asset.antialiased = true;
  const auto eyes = headset(0.6);  // the nearest kernels fade in
  ASSERT_NO_FATAL_FAILURE(expect_the_twin({&turned, &smoothed}, eyes, {}));
  ASSERT_NO_FATAL_FAILURE(expect_the_twin(
      {&turned, &smoothed}, eyes, {.order = DepthOrder::ViewZ, .max_sh_degree = 2, .max_radius_px = 25}));
}

// Each object darkens the other one. The pass and project_kernel, the reference, agree on the light.
TEST_P(ProjectSplatsTest, MatchesTheTwinAndTheReferenceWithShadows) {
  Object above = cloud(1, 22), below = cloud(1, 23);
  for (size_t i = 0; i < above.size(); ++i) {
    above.posed.positions_m[i] = 0.3f * above.posed.positions_m[i] + Eigen::Vector3f(0.05f, 0.3f, 0);
    below.posed.positions_m[i].y() *= 0.2f;
  }
  const std::vector<float> weights(above.size(), 1.0f);
  const std::vector<uint32_t> bodies(above.size(), 0u);
  SceneShadows shadows;
  for (const auto& [id, object] : {std::pair(0u, &above), {1u, &below}})
    shadows.set(id, {object->posed.positions_m, object->posed.covariances_m2, weights, bodies});
  FrameSplats::Options options;
  options.shadows = &shadows.table();
  const Camera eye = ahead();
  ASSERT_NO_FATAL_FAILURE(expect_the_twin({&above, &below}, {&eye, 1}, options));
  ASSERT_NO_FATAL_FAILURE(expect_the_twin({&above, &below}, headset(0.9), options));

  const auto made = project_on(*backend_, {&above, &below}, {&eye, 1}, options);
  ASSERT_TRUE(made) << made.error().message;
  RasteriseOptions rasterised;
  rasterised.shadows = options.shadows;
  const Projection projection(eye);
  size_t dark = 0;
  for (uint32_t id = 0; id < 2; ++id) {
    const Object& object = id == 0 ? above : below;
    for (size_t k = 0; k < object.size(); ++k) {
      ProjectedKernel expected;
      float depth_m = 0;
      const SplatRow& row = made->eye[0][id * above.size() + k];
      if (!project_kernel(projection, {&object.asset, &object.posed, id}, k, 0, rasterised, expected,
                          depth_m) ||
          row.log2_opacity == kCulled_log2)
        continue;
      EXPECT_NEAR(row.red, expected.red, 2e-3);  // half floats in the bands of the pass
      dark += shadow_light(options.shadows->words, object.posed.positions_m[k], id) < 0.8f;
    }
  }
  EXPECT_GT(dark, 300u);
}

// An environment is ordered behind an object whose kernels lie within two of its standard deviations, for
// both orders, by the pass and by the reference.
TEST_P(ProjectSplatsTest, EnvironmentIsOrderedBehindWhatTouchesIt) {
  Object floor = synthetic::shell(1, 0, 0.03, 5), thing = floor;
  const float z_m = 0.0f;
  floor.posed.positions_m[0] = {0, 0, z_m};
  floor.posed.covariances_m2[0] = {4e-4f, 0, 0, 1e-6f, 0, 4e-4f};  // a level disc, 2 cm
  floor.asset.opacity_logits[0] = thing.asset.opacity_logits[0] = 2;
  for (const DepthOrder order : {DepthOrder::ViewZ, DepthOrder::Distance}) {
    for (const float behind_m : {0.02f, 0.08f}) {
      thing.posed.positions_m[0] = {0, 0.002f, z_m - behind_m};
      const Camera eye = look_at({0, 0.3, 1.5}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 320, 240);
      FrameSplats::Options options;
      options.order = order;
      options.environments = {0};
      const auto made = project_on(*backend_, {&floor, &thing}, {&eye, 1}, options);
      ASSERT_TRUE(made) << made.error().message;
      ASSERT_EQ(made->order.size(), 2u);
      EXPECT_EQ(made->order[0], behind_m < 0.04f ? 1u : 0u);
      RasteriseOptions rasterised;
      rasterised.order = order;
      rasterised.environments = {0};
      float depths_m[2];
      ProjectedKernel projected;
      for (uint32_t id = 0; id < 2; ++id) {
        const Object& object = id == 0 ? floor : thing;
        ASSERT_TRUE(project_kernel(Projection(eye), {&object.asset, &object.posed, id}, 0, 0, rasterised,
                                   projected, depths_m[id]));
      }
      EXPECT_EQ(depths_m[1] < depths_m[0], behind_m < 0.04f);
    }
  }
}

TEST_P(ProjectSplatsTest, AcceptsAnEmptyScene) {
  const Object none;
  const Camera eye = ahead();
  for (const auto& objects : {std::vector<const Object*>{}, std::vector<const Object*>{&none}}) {
    const auto made = project_on(*backend_, objects, {&eye, 1}, {});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_TRUE(made->order.empty());
  }
}

// The same kernels are culled by contribution, except those at the threshold.
TEST_P(ProjectSplatsTest, MatchesTheTwinWithContributionCulling) {
  const Object object = cloud(1, 25);
  for (const float threshold_px : {20.0f, 60.0f}) {
    const auto eyes = headset(0.9);
    ASSERT_NO_FATAL_FAILURE(expect_the_twin({&object}, eyes, {.min_contribution_px = threshold_px}));
    const Camera eye = ahead();
    const size_t all = twin({&object}, {&eye, 1}, {}).order.size();
    const auto some = project_on(*backend_, {&object}, {&eye, 1}, {.min_contribution_px = threshold_px});
    ASSERT_TRUE(some) << some.error().message;
    EXPECT_LT(some->order.size(), all - 100);
    EXPECT_GT(some->order.size(), 100u);
  }
}

// A threshold below the minimum (opacity 1/255 on the low-pass only, 0.0074 px) enables the computation but
// culls nothing: the bits are the same as without it.
TEST_P(ProjectSplatsTest, ThresholdZeroCullsNothing) {
  const Object object = cloud(2, 26);
  const auto eyes = headset(0.9);
  const auto none = project_on(*backend_, {&object}, eyes, {.min_contribution_px = 0});
  const auto tiny = project_on(*backend_, {&object}, eyes, {.min_contribution_px = 0.007f});
  const auto plain = project_on(*backend_, {&object}, eyes, {});
  ASSERT_TRUE(none && tiny && plain);
  for (const auto* other : {&*tiny, &*plain}) {
    EXPECT_EQ(none->order, other->order);
    for (int e = 0; e < 2; ++e) {
      ASSERT_EQ(none->eye[e].size(), other->eye[e].size());
      EXPECT_EQ(
          std::memcmp(none->eye[e].data(), other->eye[e].data(), none->eye[e].size() * sizeof(SplatRow)), 0);
    }
  }
}

// The order is that of a stable sort by depth of the kernels of all objects together.
TEST_P(ProjectSplatsTest, OrdersAllObjectsInOneSet) {
  const Object first = cloud(0, 30);
  const Object second = synthetic::moved(first, {{0.05, 0, 0.1}, Eigen::Quaterniond::Identity()});
  const auto eyes = headset(1.5);
  const auto made = project_on(*backend_, {&first, &second}, eyes, {});
  ASSERT_TRUE(made) << made.error().message;
  const Eigen::Vector3f middle(0, 0.05f, 1.5f);
  const auto distance = [&](uint32_t place) {
    const Object& object = place < first.size() ? first : second;
    return (object.posed.positions_m[place % first.size()] - middle).norm();
  };
  ASSERT_GT(made->order.size(), 4000u);
  for (size_t i = 1; i < made->order.size(); ++i)
    ASSERT_LE(distance(made->order[i - 1]), distance(made->order[i]) + 1e-6f) << i;
}

// Floats compared with the reference in doubles. Single-precision products of the covariance give 1e-4 of a
// needle's width; half-float bands give 2^-11 of each of 15 bands of 0.1.
TEST(ProjectSplats, MatchesTheReferenceInFloats) {
  for (const bool antialiased : {false, true}) {
    Object object = cloud(3, 40);
    object.asset.antialiased = antialiased;
    const Camera eye = ahead(0.7);
    const Projected made = twin({&object}, {&eye, 1}, {.order = DepthOrder::ViewZ});
    const Projection projection(eye);
    size_t seen = 0, differ = 0;
    for (size_t i = 0; i < object.size(); ++i) {
      ProjectedKernel p;
      float depth_m;
      const bool visible = project_kernel(projection, object.drawn(), i, 0, {}, p, depth_m);
      const SplatRow& row = made.eye[0][i];
      if (visible != (row.log2_opacity != kCulled_log2)) {
        ++differ;
        continue;
      }
      if (!visible) continue;
      ++seen;
      const float roots = p.across_x + std::abs(p.across_y) + p.down_y;
      ASSERT_NEAR(row.centre_x_px, p.centre_x_px, 1e-4f) << i;
      ASSERT_NEAR(row.centre_y_px, p.centre_y_px, 1e-4f) << i;
      ASSERT_NEAR(row.across_x, p.across_x, 1e-4f * roots) << i;
      ASSERT_NEAR(row.across_y, p.across_y, 1e-4f * roots) << i;
      ASSERT_NEAR(row.down_y, p.down_y, 1e-4f * roots) << i;
      ASSERT_NEAR(row.log2_opacity, p.log2_opacity, antialiased ? 1e-3f : 1e-4f) << i;
      ASSERT_NEAR(row.red, p.red, 1e-3f) << i;
      ASSERT_NEAR(row.green, p.green, 1e-3f) << i;
      ASSERT_NEAR(row.blue, p.blue, 1e-3f) << i;
    }
    EXPECT_GT(seen, 1000u);
    EXPECT_LE(differ, 2u);
  }
}

// A needle a thousand times as long as wide, across the view. Its float covariance defines the width to a few
// per cent, and the projection must keep that. A determinant xx yy - xy² in floats would be noise.
TEST(ProjectSplats, ANeedleKeepsItsWidth) {
  Object object;
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  synthetic::add_kernel(object, {0, 0, 0}, turned, {1.0, 1e-3, 1e-3}, 0.9, {1, 1, 1});
  const Camera eye = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  const SplatRow row = twin({&object}, {&eye, 1}, {}).eye[0][0];
  ProjectedKernel p;
  float depth_m;
  ASSERT_TRUE(project_kernel(Projection(eye), object.drawn(), 0, 0, {}, p, depth_m));
  const double oracle_area = 1.0 / (p.across_x * p.down_y);
  EXPECT_NEAR(1.0 / (row.across_x * row.down_y), oracle_area, 1e-4 * oracle_area);
  // focal² times 1 m by 1 mm, with the low-pass, in the units of the root.
  const double f = eye.focal_x_px;
  const double area = std::sqrt((f * f * 1.0 + 0.3) * (f * f * 1e-6 + 0.3)) / 0.72134752;
  EXPECT_NEAR(oracle_area, area, 0.02 * area);
}

// The contribution is opacity times 2 pi sqrt(det), the integral of a Gaussian: a ball of 0.02 m at 1 m, with
// the low-pass.
TEST(ProjectSplats, CullsKernelsByTheirIntegral) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 0.02, 0.5, {1, 1, 1});
  const Camera eye = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  const double variance_px2 = std::pow(0.02 * eye.focal_x_px, 2) + 0.3;
  const auto contribution_px = static_cast<float>(0.5 * 2.0 * M_PI * variance_px2);
  EXPECT_EQ(twin({&object}, {&eye, 1}, {.min_contribution_px = 0.999f * contribution_px}).order.size(), 1u);
  EXPECT_EQ(twin({&object}, {&eye, 1}, {.min_contribution_px = 1.001f * contribution_px}).order.size(), 0u);
  ProjectedKernel p;
  float depth_m;
  EXPECT_TRUE(project_kernel(Projection(eye), object.drawn(), 0, 0,
                             {.min_contribution_px = 0.999f * contribution_px}, p, depth_m));
  EXPECT_FALSE(project_kernel(Projection(eye), object.drawn(), 0, 0,
                              {.min_contribution_px = 1.001f * contribution_px}, p, depth_m));
}

// Kernels are shrunk until the longest half axis of the rim equals the limit; smaller ones are unchanged.
TEST(ProjectSplats, RadiusLimitBoundsTheLongestAxis) {
  Object object;
  synthetic::add_kernel(object, {0, 0, 0}, Eigen::Quaterniond::Identity(), {0.3, 0.1, 0.1}, 0.9, {1, 1, 1});
  const Camera eye = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  const SplatRow free = twin({&object}, {&eye, 1}, {}).eye[0][0];
  const SplatRow capped = twin({&object}, {&eye, 1}, {.max_radius_px = 50}).eye[0][0];
  const SplatRow roomy = twin({&object}, {&eye, 1}, {.max_radius_px = 5000}).eye[0][0];
  EXPECT_EQ(values(roomy), values(free));
  const double rim_root = std::sqrt(capped.log2_opacity + kSplatLog2Of255);
  EXPECT_NEAR(rim_root / capped.across_x, 50.0, 1e-3);  // the longest axis is along x
  EXPECT_NEAR(capped.down_y / capped.across_x, free.down_y / free.across_x, 1e-4);
  EXPECT_EQ(capped.log2_opacity, free.log2_opacity);
  // The reference applies the same limit.
  ProjectedKernel p;
  float depth_m;
  ASSERT_TRUE(project_kernel(Projection(eye), object.drawn(), 0, 0, {.max_radius_px = 50}, p, depth_m));
  EXPECT_NEAR(std::sqrt(p.rim()) / p.across_x, 50.0, 1e-3);
  EXPECT_NEAR(p.across_x, capped.across_x, 1e-5 * capped.across_x);
  EXPECT_NEAR(p.down_y, capped.down_y, 1e-5 * capped.down_y);
}

}  // namespace
}  // namespace livegs
