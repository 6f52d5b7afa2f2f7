// SPDX-License-Identifier: Apache-2.0
#include "analysis/views/object_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "analysis/model/fact_slots.h"
#include "analysis/views/outline.h"

namespace livegs {
namespace {

constexpr uint32_t kTarget = 7, kScreen = 8;

// Round kernels on a grid over a rectangle, dense enough to be opaque.
struct Sheet {
  GaussianAsset asset;
  PosedKernels kernels;
};

Sheet sheet(const Eigen::Vector3d& corner_m, const Eigen::Vector3d& across_m, const Eigen::Vector3d& up_m,
            const Eigen::Vector3f& rgb, int count = 60) {
  Sheet made;
  const double spacing_m = std::max(across_m.norm(), up_m.norm()) / count;
  const auto columns = std::lround(across_m.norm() / spacing_m), rows = std::lround(up_m.norm() / spacing_m);
  const auto variance = static_cast<float>(0.5 * spacing_m * spacing_m);
  made.asset.resize(columns * rows);
  made.kernels.resize(columns * rows);
  for (long i = 0; i < columns * rows; ++i) {
    const double u = (i % columns + 0.5) / columns, v = (i / columns + 0.5) / rows;
    made.kernels.positions_m[i] = (corner_m + u * across_m + v * up_m).cast<float>();
    made.kernels.covariances_m2[i] = {variance, 0, 0, variance, 0, variance};
    made.kernels.world_from_asset[i].setIdentity();
    made.asset.positions[i] = made.kernels.positions_m[i];
    made.asset.opacity_logits[i] = 4.0f;
    made.asset.sh_dc[i] = (rgb.array() - 0.5f).matrix() / 0.28209479f;
  }
  return made;
}

// A red board of 0.4 x 0.4 m that faces the front; a grey screen in front of it occludes its right half.
class HalfHiddenBoard : public testing::Test {
 protected:
  Sheet board = sheet({-0.2, 0, 0}, {0.4, 0, 0}, {0, 0.4, 0}, {0.9f, 0.1f, 0.1f});
  Sheet screen = sheet({0, -0.4, 0.3}, {0.8, 0, 0}, {0, 1.2, 0}, {0.4f, 0.4f, 0.4f}, 120);
  std::vector<DrawnObject> both = {{&board.asset, &board.kernels, kTarget},
                                   {&screen.asset, &screen.kernels, kScreen}};
};

double mean(const Image& image) {
  double sum = 0;
  for (size_t i = 0; i < image.pixels.size(); i += 4) sum += image.pixels[i];
  return sum / (static_cast<double>(image.width) * image.height);
}

TEST_F(HalfHiddenBoard, MaskCoversExactlyTheVisiblePart) {
  const auto views = object_views(both, kTarget, {256, 1, 4.0 / 3});
  ASSERT_TRUE(views) << views.error().message;
  const ObjectView& view = views->front();
  EXPECT_EQ(view.scene.width, 256);
  EXPECT_EQ(view.scene.height, 192);
  // Only the board is red, so the colours of the scene give its visible pixels.
  int wrong = 0, seen = 0;
  for (int y = 0; y < view.mask.height; ++y) {
    for (int x = 0; x < view.mask.width; ++x) {
      const float* rgb = view.scene.at(x, y);
      const bool red = rgb[0] - rgb[1] > 0.4f, masked = view.mask.at(x, y)[0] >= 0.5f;
      wrong += red != masked;
      seen += masked;
    }
  }
  EXPECT_GT(seen, 500);
  EXPECT_LE(wrong, seen / 50);  // boundary pixels with mixed coverage
}

// Expected share from the intercept theorem: from distance d of the board's centre, the screen's edge 0.3 m
// in front of it occludes everything to the right of x = 0, which is half.
TEST_F(HalfHiddenBoard, VisibleShareMatchesGeometry) {
  std::vector<ViewCandidate> ring;
  ASSERT_TRUE(object_views(both, kTarget, {128, 1, 4.0 / 3}, &ring));
  ASSERT_EQ(ring.size(), 12u);
  EXPECT_EQ(ring[0].azimuth_rad, 0.0);
  EXPECT_NEAR(ring[0].visible_share, 0.5, 0.03);
  EXPECT_NEAR(ring[4].visible_share, 1.0, 0.01);  // not occluded from behind
}

TEST_F(HalfHiddenBoard, BestViewShowsTheMost) {
  std::vector<ViewCandidate> ring;
  const auto views = object_views(both, kTarget, {256, 3, 4.0 / 3}, &ring);
  ASSERT_TRUE(views);
  ASSERT_EQ(views->size(), 3u);
  std::vector<double> seen;
  for (const ViewCandidate& candidate : ring) seen.push_back(candidate.area_share);
  std::sort(seen.begin(), seen.end());
  EXPECT_GT((*views)[0].area_share, 1.3 * seen[seen.size() / 2]);
  EXPECT_GT((*views)[0].visible_share, 0.95);
  EXPECT_GE((*views)[0].score, (*views)[1].score);
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < i; ++k) {
      EXPECT_GT(
          ((*views)[i].camera.world_from_camera.position_m - (*views)[k].camera.world_from_camera.position_m)
              .norm(),
          0.8 * (*views)[i].distance_m);
    }
  }
}

TEST_F(HalfHiddenBoard, OutlineSurroundsIt) {
  const auto views = object_views(both, kTarget, {256, 1, 4.0 / 3});
  ASSERT_TRUE(views);
  const ObjectView& view = views->front();
  const auto masked = [&](int x, int y) { return view.mask.at(x, y)[0] >= 0.5f; };
  const auto line = [&](int x, int y) {
    return std::equal(kOutline_rgb, kOutline_rgb + 3, view.outlined.at(x, y));
  };
  int border = 0;
  for (int y = 1; y + 1 < view.mask.height; ++y) {
    for (int x = 1; x + 1 < view.mask.width; ++x) {
      EXPECT_FALSE(masked(x, y) && line(x, y)) << x << ' ' << y;
      if (masked(x, y)) {
        EXPECT_EQ(view.outlined.at(x, y)[0], view.scene.at(x, y)[0]);
        continue;
      }
      if (!masked(x - 1, y) && !masked(x + 1, y) && !masked(x, y - 1) && !masked(x, y + 1)) continue;
      ++border;
      EXPECT_TRUE(line(x, y)) << x << ' ' << y;
    }
  }
  EXPECT_GT(border, 50);
}

TEST_F(HalfHiddenBoard, CutoutIsCompleteAndFillsThePicture) {
  const auto views = object_views(both, kTarget, {256, 1, 4.0 / 3});
  ASSERT_TRUE(views);
  const Image& cutout = views->front().cutout;
  EXPECT_EQ(std::max(cutout.width, cutout.height), 256);
  int red = 0, grey = 0;
  for (size_t i = 0; i < cutout.pixels.size(); i += 4) {
    red += cutout.pixels[i] - cutout.pixels[i + 1] > 0.4f;
    grey += std::abs(cutout.pixels[i] - 0.4f) < 0.1f && std::abs(cutout.pixels[i + 1] - 0.4f) < 0.1f;
  }
  EXPECT_GT(red, cutout.width * cutout.height / 2);
  EXPECT_LT(grey, cutout.width * cutout.height / 100);
}

TEST_F(HalfHiddenBoard, RenderingIsDeterministic) {
  const auto one = object_views(both, kTarget, {128, 2, 4.0 / 3}),
             other = object_views(both, kTarget, {128, 2, 4.0 / 3});
  ASSERT_TRUE(one && other);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*one)[i].outlined.pixels, (*other)[i].outlined.pixels);
    EXPECT_EQ((*one)[i].mask.pixels, (*other)[i].mask.pixels);
    EXPECT_EQ((*one)[i].cutout.pixels, (*other)[i].cutout.pixels);
  }
}

TEST_F(HalfHiddenBoard, DistantObjectsChangeNothing) {
  const auto before = object_views(both, kTarget, {128, 1, 4.0 / 3});
  Sheet aside = sheet({50, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0});
  both.push_back({&aside.asset, &aside.kernels, 9});
  const auto after = object_views(both, kTarget, {128, 1, 4.0 / 3});
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->front().scene.pixels, after->front().scene.pixels);
}

TEST_F(HalfHiddenBoard, NearPlaneDoesNotFadeSmallObjects) {
  Sheet coin = sheet({0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0.8f, 0.6f, 0.2f});
  const DrawnObject small[] = {{&coin.asset, &coin.kernels, kTarget}};
  const auto views = object_views(small, kTarget, {128, 1, 4.0 / 3});
  ASSERT_TRUE(views);
  EXPECT_GT(*std::max_element(views->front().mask.pixels.begin(), views->front().mask.pixels.end()), 0.98f);
  EXPECT_GT(mean(views->front().mask), 0.05);
}

TEST_F(HalfHiddenBoard, StopEndsTheRendering) {
  std::stop_source stop;
  ViewOptions options;
  options.stop = stop.get_token();
  options.long_side_px = 64;
  ASSERT_TRUE(object_views(both, kTarget, options));
  stop.request_stop();
  const auto views = object_views(both, kTarget, options);
  ASSERT_FALSE(views);
  EXPECT_EQ(views.error().message, "cancelled");
}

TEST_F(HalfHiddenBoard, InvalidRequestsNameTheFault) {
  const auto nobody = object_views(both, 99);
  ASSERT_FALSE(nobody);
  EXPECT_NE(nobody.error().message.find("99"), std::string::npos);
  EXPECT_FALSE(object_views(both, kTarget, {8, 1, 1.0}));
  EXPECT_FALSE(object_views(both, kTarget, {256, 0, 1.0}));
  EXPECT_FALSE(object_views(both, kTarget, {256, 1, 9.0}));
  GaussianAsset nothing;
  PosedKernels none;
  const DrawnObject empty[] = {{&nothing, &none, kTarget}};
  EXPECT_FALSE(object_views(empty, kTarget));
}

// Two opaque boards back to back, 4 cm apart: a red one to the front and a green one to the back.
class TwoSidedBoard : public testing::Test {
 protected:
  Sheet front = sheet({-0.2, 0, 0.02}, {0.4, 0, 0}, {0, 0.4, 0}, {0.9f, 0.1f, 0.1f});
  Sheet back = sheet({-0.2, 0, -0.02}, {0.4, 0, 0}, {0, 0.4, 0}, {0.1f, 0.9f, 0.1f});
  std::vector<DrawnObject> drawn = {{&front.asset, &front.kernels, kTarget},
                                    {&back.asset, &back.kernels, kTarget}};

  // Red less green over the pixels that are either, -1 to 1.
  static double redness(const Image& image) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < image.pixels.size(); i += 4) {
      const float difference = image.pixels[i] - image.pixels[i + 1];
      if (std::abs(difference) < 0.4f) continue;
      sum += difference > 0 ? 1 : -1;
      count += 1;
    }
    return count > 0 ? sum / count : 0;
  }
};

TEST_F(TwoSidedBoard, CutoutShowsWhatTheFirstPictureHides) {
  const auto views = object_views(drawn, kTarget, {256, 1, 4.0 / 3});
  ASSERT_TRUE(views);
  const double first = redness(views->front().outlined), second = redness(views->front().cutout);
  EXPECT_GT(std::abs(first), 0.95);
  EXPECT_LT(first * second, -0.9);
}

TEST_F(TwoSidedBoard, SecondViewShowsWhatTheFirstHides) {
  const auto views = object_views(drawn, kTarget, {256, 2, 4.0 / 3});
  ASSERT_TRUE(views);
  ASSERT_EQ(views->size(), 2u);
  EXPECT_LT(redness((*views)[0].scene) * redness((*views)[1].scene), -0.9);
}

// The target fills the outlined picture up to a margin of a quarter on each side, whatever its shape.
TEST(ObjectViews, OutlinedPictureIsCropped) {
  for (const Eigen::Vector2d& size_m : {Eigen::Vector2d(0.4, 0.4), {0.6, 0.05}, {0.05, 0.6}}) {
    Sheet board = sheet({0, 0, 0}, {size_m.x(), 0, 0}, {0, size_m.y(), 0}, {0.9f, 0.1f, 0.1f}, 100);
    Sheet floor = sheet({-2, -0.02, -2}, {4, 0, 0}, {0, 0, 4}, {0.5f, 0.5f, 0.5f}, 200);
    const DrawnObject drawn[] = {{&board.asset, &board.kernels, kTarget},
                                 {&floor.asset, &floor.kernels, kScreen}};
    const auto views = object_views(drawn, kTarget, {256, 1, 4.0 / 3});
    ASSERT_TRUE(views);
    const Image& mask = views->front().mask;
    int left = mask.width, right = -1, top = mask.height, bottom = -1;
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        if (mask.at(x, y)[0] < 0.5f) continue;
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    ASSERT_GE(right, 0);
    const double filled =
        std::max(1.0 * (right - left + 1) / mask.width, 1.0 * (bottom - top + 1) / mask.height);
    EXPECT_GT(filled, 0.6) << size_m.transpose();  // 1 / 1.5, less the edge of the silhouette
    EXPECT_LT(filled, 0.75) << size_m.transpose();
    EXPECT_GT(left, 0);
    EXPECT_GT(top, 0);
    EXPECT_LT(right, mask.width - 1);
    EXPECT_LT(bottom, mask.height - 1);
  }
}

// A low block is slightly larger from steep above than from the side; the upright view still wins. A lower
// block, with almost no side, is seen from above.
TEST(ObjectViews, UprightViewsArePreferred) {
  const auto block = [](double height_m) {
    const Eigen::Vector3d x(0.2, 0, 0), y(0, height_m, 0), z(0, 0, 0.2);
    const Eigen::Vector3f rgb(0.6f, 0.5f, 0.4f);
    std::vector<Sheet> faces;
    faces.push_back(sheet({0, 0, 0}, x, y, rgb));
    faces.push_back(sheet({0, 0, 0.2}, x, y, rgb));
    faces.push_back(sheet({0, 0, 0}, z, y, rgb));
    faces.push_back(sheet({0.2, 0, 0}, z, y, rgb));
    faces.push_back(sheet({0, height_m, 0}, x, z, rgb));
    return faces;
  };
  struct Seen {
    double upright = 0, steep = 0;  // the largest area share from either elevation
    double chosen_elevation_rad = 0;
  };
  const auto look_at_block = [&](double height_m) {
    const std::vector<Sheet> faces = block(height_m);
    std::vector<DrawnObject> drawn;
    for (const Sheet& face : faces) drawn.push_back({&face.asset, &face.kernels, kTarget});
    std::vector<ViewCandidate> candidates;
    const auto views = object_views(drawn, kTarget, {128, 1, 1.0}, &candidates);
    EXPECT_TRUE(views);
    Seen seen;
    for (const ViewCandidate& one : candidates) {
      double& most = one.elevation_rad > 0.6 ? seen.steep : seen.upright;
      most = std::max(most, one.area_share);
    }
    seen.chosen_elevation_rad = views->front().elevation_rad;
    return seen;
  };
  const Seen low = look_at_block(0.16), flat = look_at_block(0.03);
  EXPECT_GT(low.steep, 1.02 * low.upright);
  EXPECT_LT(low.steep, 1.17 * low.upright);  // 1 / 0.85
  EXPECT_LT(low.chosen_elevation_rad, 0.6);
  EXPECT_GT(flat.steep, 1.2 * flat.upright);
  EXPECT_GT(flat.chosen_elevation_rad, 0.6);
}

TEST_F(HalfHiddenBoard, FactSlotsDescribeTheObject) {
  const auto views = object_views(both, kTarget, {64, 1, 4.0 / 3});
  ASSERT_TRUE(views);
  ObjectFacts facts;
  facts.name = "red board";
  facts.mesh.size_m = facts.mesh.box_m = {0.4, 0.4, 0.01};
  facts.mesh.volume_m3 = 1.6e-3;
  facts.mesh.area_m2 = 0.336;
  facts.mesh.mean_wall_m = 0.0095;
  std::vector<SceneObjectFacts> neighbours(20);
  for (size_t i = 0; i < neighbours.size(); ++i) {
    neighbours[i].name = "thing " + std::to_string(i);
    neighbours[i].distance_m = std::abs(static_cast<double>(i) - 7.6);
    neighbours[i].analysed = i % 2 == 1;
  }
  const auto slots = fact_slots(facts, estimate_offline(facts), neighbours);
  for (const char* slot : {"name", "size", "scale_off", "mesh", "neighbours"}) {
    EXPECT_FALSE(slots.at(slot).empty()) << slot;
  }
  const std::string& lines = slots.at("neighbours");
  // The three nearest known ones, nearest first.
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2);
  EXPECT_TRUE(lines.starts_with("- \"thing 7\"")) << lines;
  EXPECT_NE(lines.find("thing 9"), std::string::npos) << lines;
  EXPECT_NE(lines.find("thing 5"), std::string::npos) << lines;
  EXPECT_EQ(slots.count("scale"), 0u);  // guessed
  EXPECT_NE(describe_camera(views->front()).find("m from its centre"), std::string::npos);
  const auto camera = camera_slots(views->front());
  EXPECT_EQ(std::stod(camera.at("camera_elevation")),
            std::round(views->front().elevation_rad * 180 / std::numbers::pi));
}

}  // namespace
}  // namespace livegs
