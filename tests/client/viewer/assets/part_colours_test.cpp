// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/part_colours.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "sample/sample_scene.h"
#include "splat/camera.h"
#include "splat/image.h"
#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

constexpr double kPotHeight_m = 0.14, kSaucerHeight_m = 0.02;

// The sample plant: the pot is up to its rim and as wide as its saucer; all else are leaves.
StreamedObject plant_of_two_parts(const GaussianAsset& asset) {
  StreamedObject plant;
  plant.id = 7;
  plant.name = "plant";
  plant.rest.bodies = {Pose{}};
  plant.rest.object_from_asset.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  Eigen::AlignedBox3d pot_m;
  for (const Eigen::Vector3f& position : asset.positions) {
    const Eigen::Vector3d at_m = plant.rest.object_from_asset * position.cast<double>();
    if (at_m.y() < kSaucerHeight_m) pot_m.extend(at_m);
  }
  pot_m.max().y() = kPotHeight_m;
  v1::MaterialPart& pot = *plant.physics.add_parts();
  pot.set_name("pot");
  v1::MaterialPart::Box& box = *pot.add_boxes();
  box.mutable_min_m()->Add(pot_m.min().data(), pot_m.min().data() + 3);
  box.mutable_max_m()->Add(pot_m.max().data(), pot_m.max().data() + 3);
  plant.physics.add_parts()->set_name("leaves");
  return plant;
}

DriverFrame at_pose(const Pose& pose) {
  DriverFrame frame;
  ObjectDrivers drivers;
  drivers.object_id = 7;
  drivers.poses = {pose};
  frame.objects = {drivers};
  return frame;
}

Camera camera_at(const Eigen::Vector3d& offset_m) {
  return look_at(offset_m + Eigen::Vector3d(0, 0.3, 1.1), offset_m + Eigen::Vector3d(0, 0.24, 0), {0, 1, 0},
                 0.62, 240, 240);
}

Image picture_of(SceneView& view, const Pose& pose, const Eigen::Vector3d& offset_m) {
  const Camera camera = camera_at(offset_m);
  std::vector<Image> pictures;
  EXPECT_TRUE(view.draw(at_pose(pose), {&camera, 1}, pictures));
  return pictures.at(0);
}

Eigen::Vector3f rgb_at(const Image& image, size_t pixel) {
  return {image.pixels[4 * pixel], image.pixels[4 * pixel + 1], image.pixels[4 * pixel + 2]};
}

// The part whose hue a pixel has; nothing for the background and for greys.
std::optional<size_t> part_at(const Image& image, size_t pixel) {
  const Eigen::Vector3f rgb = rgb_at(image, pixel);
  if (rgb.norm() < 0.25f) return std::nullopt;
  for (size_t part = 0; part < 2; ++part) {
    if (rgb.normalized().dot(part_rgb(part).normalized()) > 0.97f) return part;
  }
  return std::nullopt;
}

std::array<size_t, 2> pixels_of_parts(const Image& image) {
  std::array<size_t, 2> counts{};
  for (size_t i = 0; i < image.pixels.size() / 4; ++i) {
    if (const auto part = part_at(image, i)) ++counts[*part];
  }
  return counts;
}

class PlantInColours : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(view_.add(7, asset_, plant_.rest, false)); }
  const std::shared_ptr<const GaussianAsset> asset_ =
      std::make_shared<const GaussianAsset>(make_potted_plant());
  const StreamedObject plant_ = plant_of_two_parts(*asset_);
  SceneView view_;
  PartColours colours_;
};

// Terracotta is red and leaves are green in the plant's own colours. Pixels with such a colour have the
// colours of pot and leaves. Leaves have brown tips, so only red pixels below the rim count.
TEST_F(PlantInColours, PotAndLeavesHaveTheirColoursAndTheOwnOnesComeBack) {
  const Image own = picture_of(view_, {}, {0, 0, 0});
  colours_.show(&plant_, view_);
  const Image coloured = picture_of(view_, {}, {0, 0, 0});
  if (const char* folder = std::getenv("LIVEGS_TEST_PICTURES")) {
    ASSERT_TRUE(write_png(std::string(folder) + "/own.png", own));
    ASSERT_TRUE(write_png(std::string(folder) + "/coloured.png", coloured));
  }
  const auto rim_px = pixel_of(camera_at({0, 0, 0}), {0, kPotHeight_m, 0});
  ASSERT_TRUE(rim_px);
  const size_t below_rim = static_cast<size_t>(rim_px->y()) * 240;
  size_t terracotta = 0, terracotta_right = 0, green = 0, green_right = 0;
  for (size_t i = 0; i < own.pixels.size() / 4; ++i) {
    const Eigen::Vector3f rgb = rgb_at(own, i);
    if (i >= below_rim && rgb.x() > 1.5f * rgb.y() && rgb.x() > 0.25f) {
      ++terracotta;
      terracotta_right += part_at(coloured, i) == 0u;
    } else if (rgb.y() > 1.2f * rgb.x() && rgb.y() > 0.25f) {
      ++green;
      green_right += part_at(coloured, i) == 1u;
    }
  }
  const double pot_share = static_cast<double>(terracotta_right) / static_cast<double>(terracotta),
               leaf_share = static_cast<double>(green_right) / static_cast<double>(green);
  std::printf("terracotta %zu px, %.3f right; green %zu px, %.3f right\n", terracotta, pot_share, green,
              leaf_share);
  ASSERT_GT(terracotta, 1000u);
  ASSERT_GT(green, 1000u);
  EXPECT_GT(pot_share, 0.95);  // the others are at borders
  EXPECT_GT(leaf_share, 0.95);
  colours_.show(nullptr, view_);
  EXPECT_EQ(picture_of(view_, {}, {0, 0, 0}).pixels, own.pixels);
}

// The parts are places of the rest shape, so they move with the object.
TEST_F(PlantInColours, MovedObjectKeepsItsColours) {
  colours_.show(&plant_, view_);
  const auto before = pixels_of_parts(picture_of(view_, {}, {0, 0, 0}));
  ASSERT_GT(before[0], 1000u);
  ASSERT_GT(before[1], 1000u);
  const Eigen::Vector3d offset_m(0.4, 1.3, -0.2);
  const uint64_t version = view_.version();
  colours_.show(&plant_, view_);
  EXPECT_EQ(view_.version(), version);  // nothing to do
  const auto after = pixels_of_parts(picture_of(view_, {offset_m, Eigen::Quaterniond::Identity()}, offset_m));
  for (const size_t part : {0u, 1u})  // the same picture, up to rounding at the threshold of the hue
    EXPECT_NEAR(static_cast<double>(after[part]), static_cast<double>(before[part]), 0.01 * before[part]);
}

TEST_F(PlantInColours, RefinedKernelsAndChangedPartsAreColouredAgain) {
  colours_.show(&plant_, view_);
  auto finer = bind_object(7, asset_, plant_.rest, false);
  ASSERT_TRUE(finer);
  view_.refine(7, *std::move(finer));
  EXPECT_EQ(view_.asset(7), asset_);
  colours_.show(&plant_, view_);
  const auto coloured = view_.asset(7);
  EXPECT_NE(coloured, asset_);
  StreamedObject higher = plant_;
  higher.physics.mutable_parts(0)->mutable_boxes(0)->set_max_m(1, 1.0);
  colours_.show(&higher, view_);
  EXPECT_NE(view_.asset(7), coloured);
  EXPECT_GT(pixels_of_parts(picture_of(view_, {}, {0, 0, 0}))[0], 1000u);
  colours_.show(nullptr, view_);
  EXPECT_EQ(view_.asset(7), asset_);
}

TEST_F(PlantInColours, ObjectsWithoutPlacesAndRemovedOnesAreLeftAlone) {
  StreamedObject whole = plant_;
  whole.physics.mutable_parts(0)->clear_boxes();
  colours_.show(&whole, view_);
  EXPECT_EQ(view_.asset(7), asset_);
  colours_.show(&plant_, view_);
  view_.remove(7);
  colours_.show(&plant_, view_);
  EXPECT_EQ(view_.asset(7), nullptr);
  ASSERT_TRUE(view_.add(7, asset_, plant_.rest, false));
  colours_.show(&plant_, view_);
  EXPECT_NE(view_.asset(7), asset_);
}

TEST(InPartColours, KernelHasTheHueOfItsPartAndItsOwnShade) {
  GaussianAsset asset;
  asset.sh_degree = 1;
  asset.resize(3);
  asset.positions = {{0, 0, 0}, {0, 2, 0}, {0, 2, 0}};
  for (size_t i = 0; i < 3; ++i) asset.rotations[i].setIdentity();
  const float black = -0.5f / kShBand0, white = 0.5f / kShBand0;
  asset.sh_dc = {{black, black, black}, {black, black, black}, {white, white, white}};
  MaterialParts parts;
  v1::MaterialPart::Box& box = *parts.Add()->add_boxes();
  for (const double low_m : {-1.0, -0.1, -1.0}) box.add_min_m(low_m);
  parts.Add();
  // In metres and upright the second and third kernel are at y = -0.2 m, below the box.
  const Similarity object_from_asset{
      0.1, Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())),
      Eigen::Vector3d::Zero()};
  const auto coloured = in_part_colours(asset, object_from_asset, PartPlaces(parts));
  const auto rgb = [&](size_t i) -> Eigen::Vector3f {
    return (0.5f + kShBand0 * coloured->sh_dc[i].array());
  };
  EXPECT_TRUE(rgb(0).isApprox(0.5f * part_rgb(0), 1e-5f));
  EXPECT_TRUE(rgb(1).isApprox(0.5f * part_rgb(1), 1e-5f));
  EXPECT_TRUE(rgb(2).isApprox(part_rgb(1), 1e-5f));
  EXPECT_EQ(coloured->sh_degree, 0);
  EXPECT_TRUE(coloured->sh_rest.empty());
  EXPECT_EQ(coloured->positions, asset.positions);
}

}  // namespace
}  // namespace livegs
