// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "sample/sample_scene.h"

// The seven sample assets, their documented sizes, and checks that apply to all of them.

namespace livegs {

struct Specimen {
  const char* name;
  GaussianAsset (*make)(uint64_t seed);
  // Size over x and z from the header; 0 if it is random.
  double width_m, height_m, depth_m;
};

inline void PrintTo(const Specimen& specimen, std::ostream* out) { *out << specimen.name; }

inline const Specimen kSpecimens[] = {
    {"cup", make_cup, 0.116, 0.100, 0.084},       {"pillow", make_pillow, 0.45, 0.150, 0.45},
    {"hat", make_felt_hat, 0.288, 0.132, 0.301},  {"plant", make_potted_plant, 0, 0.50, 0},
    {"duck", make_toy_duck, 0.094, 0.118, 0.137}, {"stool", make_wooden_stool, 0.33, 0.450, 0.33},
    {"room", make_room_corner, 3.0, 2.4, 3.0}};

struct Box {
  Eigen::Vector3f low, high;
  Eigen::Vector3f size() const { return high - low; }
};

inline Box box_of(const GaussianAsset& asset) {
  Box box{asset.positions.front(), asset.positions.front()};
  for (const Eigen::Vector3f& p : asset.positions) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                                   a.size() * sizeof(T)) == 0);
}

inline bool same_bits(const GaussianAsset& a, const GaussianAsset& b) {
  return a.sh_degree == b.sh_degree && same_bits(a.positions, b.positions) &&
         same_bits(a.log_scales, b.log_scales) && same_bits(a.rotations, b.rotations) &&
         same_bits(a.opacity_logits, b.opacity_logits) && same_bits(a.sh_dc, b.sh_dc) &&
         same_bits(a.sh_rest, b.sh_rest);
}

inline void expect_invariants(const GaussianAsset& asset) {
  const size_t count = asset.size();
  EXPECT_GE(asset.sh_degree, 1);
  EXPECT_LE(asset.sh_degree, 3);
  ASSERT_EQ(asset.log_scales.size(), count);
  ASSERT_EQ(asset.rotations.size(), count);
  ASSERT_EQ(asset.opacity_logits.size(), count);
  ASSERT_EQ(asset.sh_dc.size(), count);
  ASSERT_EQ(asset.sh_rest.size(), count * asset.sh_rest_count());
  for (size_t i = 0; i < count; ++i) {
    ASSERT_TRUE(asset.positions[i].allFinite() && asset.log_scales[i].allFinite() &&
                asset.sh_dc[i].allFinite() && std::isfinite(asset.opacity_logits[i]))
        << "kernel " << i;
    // Four float roundings of a unit quaternion.
    ASSERT_NEAR(asset.rotations[i].norm(), 1.0f, 4 * 1.2e-7f) << "kernel " << i;
  }
  for (const Eigen::Vector3f& c : asset.sh_rest) ASSERT_TRUE(c.allFinite());
}

inline void expect_size(const GaussianAsset& asset, const Specimen& specimen) {
  const Eigen::Vector3f size = box_of(asset).size();
  // 6 % for the variation between seeds: the pillow's wrinkles move its top and bottom by 4 mm each.
  if (specimen.width_m > 0) {
    EXPECT_NEAR(size.x(), specimen.width_m, 0.06 * specimen.width_m);
  }
  EXPECT_NEAR(size.y(), specimen.height_m, 0.06 * specimen.height_m);
  if (specimen.depth_m > 0) {
    EXPECT_NEAR(size.z(), specimen.depth_m, 0.06 * specimen.depth_m);
  }
}

inline void expect_small_capture(const GaussianAsset& asset) {
  EXPECT_GE(asset.size(), 20000u);
  EXPECT_LE(asset.size(), 80000u);
}

}  // namespace livegs
