// SPDX-License-Identifier: Apache-2.0
#include "splat/shadow_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel_for.h"

namespace livegs {
namespace {

using Eigen::Vector3f;

constexpr uint32_t kCaster = 7, kOther = 8;

struct Shape {
  std::vector<Vector3f> positions_m;
  std::vector<Symmetric3f> covariances_m2;
  std::vector<float> weights;
  std::vector<uint32_t> bodies;

  // A closed box of kernels 1 cm apart.
  void add_box(const Vector3f& low, const Vector3f& high, uint32_t body) {
    const float step = 0.01f, variance = 0.006f * 0.006f;
    const Vector3f size = high - low;
    const auto count = [&](int axis) {
      return std::max(1, static_cast<int>(std::lround(size[axis] / step)));
    };
    for (int x = 0; x <= count(0); ++x) {
      for (int y = 0; y <= count(1); ++y) {
        for (int z = 0; z <= count(2); ++z) {
          const bool inside = x > 0 && x < count(0) && y > 0 && y < count(1) && z > 0 && z < count(2);
          if (inside) continue;
          const Vector3f share(static_cast<float>(x) / static_cast<float>(count(0)),
                               static_cast<float>(y) / static_cast<float>(count(1)),
                               static_cast<float>(z) / static_cast<float>(count(2)));
          positions_m.push_back(low + share.cwiseProduct(size));
          covariances_m2.push_back({variance, 0, 0, variance, 0, variance});
          weights.push_back(2.5f);  // as if they overlapped like those of a capture
          bodies.push_back(body);
        }
      }
    }
  }
  ShadowShape shape() const { return {positions_m, covariances_m2, weights, bodies}; }
};

// A block of 30 x 10 x 20 cm whose lowest point is at `height_m`.
Shape block(float height_m) {
  Shape shape;
  shape.add_box({-0.15f, height_m, -0.1f}, {0.15f, height_m + 0.1f, 0.1f}, 0);
  return shape;
}

ShadowTable shadows_of(const Shape& shape) {
  SceneShadows shadows;
  shadows.set(kCaster, shape.shape());
  return shadows.table();
}

float light(const ShadowTable& table, const Vector3f& at_m) {
  return shadow_light(table.words, at_m, kOther);
}

TEST(ShadowTable, RestingBlockHasADarkContactShadow) {
  const ShadowTable table = shadows_of(block(0));
  EXPECT_NEAR(light(table, {0, 0, 0}), 0.15f, 0.04f);  // the whole sky is covered
  const float beside = light(table, {0.17f, 0, 0});    // a wall next to it covers up to half of the sky
  EXPECT_LT(beside, 0.8f);
  EXPECT_GT(beside, 0.55f);
  float last = 0.0f;
  for (float x = 0.15f; x < 0.4f; x += 0.01f) {
    const float here = light(table, {x, 0, 0});
    EXPECT_GE(here, last - 1e-3f) << x;
    last = here;
  }
  EXPECT_EQ(light(table, {0.45f, 0, 0}), 1.0f);  // beyond its border
  EXPECT_EQ(light(table, {0, 0.11f, 0}), 1.0f);  // on top of it
  EXPECT_GT(light(table, {0, 0.09f, 0}), 0.8f);  // a floor is not darkened by what stands in it
}

TEST(ShadowTable, ObjectsDoNotShadeThemselves) {
  const ShadowTable table = shadows_of(block(0));
  EXPECT_EQ(shadow_light(table.words, {0, 0, 0}, kCaster), 1.0f);
  EXPECT_EQ(shadow_light({}, {0, 0, 0}, kOther), 1.0f);
}

TEST(ShadowTable, ShadowFadesAndWidensWithTheGap) {
  float last = 0.0f, last_share = 0.0f;
  for (const float height_m : {0.0f, 0.05f, 0.1f, 0.2f, 0.4f}) {
    const ShadowTable table = shadows_of(block(height_m));
    const float middle = light(table, {0, 0, 0});
    EXPECT_GT(middle, last) << height_m;
    last = middle;
    // Darkness 10 cm beyond the edge compared with that of the middle.
    const float share = (1 - light(table, {0.25f, 0, 0})) / (1 - middle);
    EXPECT_GT(share, last_share) << height_m;
    last_share = share;
  }
  EXPECT_GT(last, 0.85f);                                      // faint
  EXPECT_EQ(light(shadows_of(block(0.7f)), {0, 0, 0}), 1.0f);  // none at two widths
}

// A table on thin legs darkens the floor at each leg, and less between them; a receiver between top and floor
// is shaded by the top.
TEST(ShadowTable, PartsAtDifferentHeightsCastTheirOwn) {
  Shape table_shape;
  table_shape.add_box({-0.3f, 0.4f, -0.3f}, {0.3f, 0.44f, 0.3f}, 0);
  for (const float x : {-0.27f, 0.25f}) {
    for (const float z : {-0.27f, 0.25f}) table_shape.add_box({x, 0, z}, {x + 0.04f, 0.4f, z + 0.04f}, 0);
  }
  const ShadowTable table = shadows_of(table_shape);
  Shape top;
  top.add_box({-0.3f, 0.4f, -0.3f}, {0.3f, 0.44f, 0.3f}, 0);
  const Vector3f leg(0.27f, 0, 0.27f), between(0, 0, 0.27f);
  EXPECT_LT(light(table, leg), light(shadows_of(top), leg) - 0.04f);
  EXPECT_LT(light(table, between), 0.98f);
  EXPECT_LT(light(table, {0, 0.12f, 0}), light(table, {0, 0, 0}));  // nearer to the top
}

TEST(ShadowTable, LightIsContinuous) {
  Shape shape = block(0.02f);
  shape.add_box({0.2f, 0.05f, 0.1f}, {0.24f, 0.08f, 0.16f}, 1);  // a second body, a fragment
  const ShadowTable table = shadows_of(shape);
  // The steepest change is that from dark to light within a texel of 4 mm.
  const float step_m = 5e-4f, most = 0.85f * step_m / 0.004f;
  for (const Vector3f& direction : {Vector3f(1, 0, 0), Vector3f(0, 1, 0), Vector3f(0.6f, 0.0f, 0.8f)}) {
    for (const Vector3f& through : {Vector3f(0, 0, 0), Vector3f(0.21f, 0.01f, 0.12f)}) {
      float last = light(table, through - 0.8f * direction);
      for (int i = 1; i < 3200; ++i) {
        const float here = light(table, through + (static_cast<float>(i) * step_m - 0.8f) * direction);
        ASSERT_LT(std::abs(here - last), most) << i;
        ASSERT_GE(here, 0.02f);
        ASSERT_LE(here, 1.0f);
        last = here;
      }
    }
  }
}

TEST(ShadowTable, ShadowsOfObjectsMultiply) {
  SceneShadows shadows;
  const Shape low = block(0.05f), high = block(0.2f);
  shadows.set(1, low.shape());
  const float first = light(shadows.table(), {0.02f, 0, 0.01f});
  shadows.set(2, high.shape());
  const float both = light(shadows.table(), {0.02f, 0, 0.01f});
  const uint32_t last[] = {2};
  shadows.keep(last);
  const float second = light(shadows.table(), {0.02f, 0, 0.01f});
  EXPECT_NEAR(both, first * second, 1e-6f);
  EXPECT_LT(both, std::min(first, second));
  shadows.keep({});
  EXPECT_TRUE(shadows.table().words.empty());
}

TEST(ShadowTable, VersionChangesWithTheShape) {
  SceneShadows shadows;
  shadows.set(kCaster, block(0).shape());
  const uint64_t first = shadows.table().version;
  EXPECT_EQ(shadows.table().version, first);
  const uint32_t kept[] = {kCaster};
  shadows.keep(kept);
  EXPECT_EQ(shadows.table().version, first);
  shadows.set(kCaster, block(0.1f).shape());
  EXPECT_GT(shadows.table().version, first);
}

TEST(ShadowTable, SameBitsForAnyThreadCount) {
  Shape shape;
  for (uint32_t body = 0; body < 9; ++body) {
    const auto b = static_cast<float>(body);
    shape.add_box({0.1f * b, 0.01f * b, 0}, {0.1f * b + 0.07f, 0.01f * b + 0.05f, 0.04f}, body);
  }
  std::vector<uint32_t> first;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    const ShadowTable table = shadows_of(shape);
    if (first.empty()) first = table.words;
    EXPECT_EQ(table.words, first) << threads;
  }
  set_thread_count(0);
}

// Haze, a point, one kernel and values that are not finite give a table without them or with finite light.
TEST(ShadowTable, DegenerateShapesAreHarmless) {
  Shape point;
  point.positions_m = {{0.1f, 0.2f, 0.3f}};
  point.covariances_m2 = {{0, 0, 0, 0, 0, 0}};
  point.weights = {1};
  point.bodies = {0};
  const float lit = light(shadows_of(point), {0.1f, 0.1f, 0.3f});
  EXPECT_GE(lit, 0.15f - 1e-5f);
  EXPECT_LE(lit, 1.0f);
  point.positions_m = {{NAN, 0, 0}};
  EXPECT_TRUE(shadows_of(point).words.empty());
  Shape spoilt = block(0);
  spoilt.positions_m[100].x() = NAN;
  spoilt.covariances_m2[200][3] = INFINITY;
  EXPECT_NEAR(light(shadows_of(spoilt), {0, 0, 0}), light(shadows_of(block(0)), {0, 0, 0}), 0.01f);
  EXPECT_TRUE(shadows_of(Shape()).words.empty());
}

}  // namespace
}  // namespace livegs
