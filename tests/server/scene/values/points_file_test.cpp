// SPDX-License-Identifier: Apache-2.0
#include "scene/values/points_file.h"

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "geometry/reconstruct_surface.h"
#include "known_gaps.h"
#include "rates.h"
#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

TEST(PointsFile, ReadsPositionsAndVelocitiesInOrder) {
  ScratchFolder folder;
  const auto list =
      read_points_file(folder.write("a.csv", "x,y,z,vx,vy,vz\r\n1,2,3,0,0,-1\n-0.5, 1e-3,4,0,0,2\n"));
  ASSERT_TRUE(list) << list.error().message;
  ASSERT_EQ(list->positions_m.size(), 2u);
  EXPECT_EQ(list->positions_m[1], Eigen::Vector3d(-0.5, 1e-3, 4));
  EXPECT_EQ(list->velocities_m_s[0], Eigen::Vector3d(0, 0, -1));
}

TEST(PointsFile, ErrorsNameFileLineAndColumn) {
  ScratchFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"x;y;z\n1,2,3\n", "line 1"},
      {"x,y,z\n1,2\n", "line 2, column 2"},
      {"x,y,z\n1,2,3,4\n", "line 2, column 3"},
      {"x,y,z\n1,nan,3\n", "column 2"},
      {"x,y,z\n1,2,1e9\n", "column 3"},
      {"x,y,z\n", "no points"},
      {"x,y,z\n1,2,3 metres\n", "line 2"},
      {"", "no points"},
  };
  for (const auto& [text, named] : cases) {
    const auto list = read_points_file(folder.write("b.csv", text));
    ASSERT_FALSE(list) << text;
    EXPECT_NE(list.error().message.find("b.csv"), std::string::npos);
    EXPECT_NE(list.error().message.find(named), std::string::npos) << list.error().message;
  }
}

TEST(PointsFile, MedianSpacingOfAGridIsItsStep) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      for (int k = 0; k < 10; ++k) points.emplace_back(0.01 * i, 0.01 * j, 0.01 * k);
    }
  }
  EXPECT_NEAR(median_spacing_m(points), 0.01, 1e-12);
  EXPECT_EQ(median_spacing_m({Eigen::Vector3d::Zero()}), 0.0);
}

// Points fill their cubes even if each is displaced by up to 0.3 spacings. The total mass must be correct,
// because the modulus scales with it. With 64 points the step is known to 1 % at best: the mean position of
// 16 points varies by 0.04 spacings.
TEST(PointsFile, JitteredListsFillTheirVolume) {
  constexpr double kBar = 0.02;
  const double s = 0.01;
  struct Form {
    const char* name;
    Eigen::Vector3i count;
    bool few = false, ball = false, turned = false;
  };
  for (const Form& form :
       {Form{"block", {9, 9, 9}}, Form{"bar", {32, 8, 8}}, Form{"turned bar", {32, 8, 6}, false, false, true},
        Form{"ball", {17, 17, 17}, false, true}, Form{"slab", {20, 20, 2}}, Form{"sheet", {20, 20, 1}},
        Form{"turned sheet", {30, 20, 1}, false, false, true}, Form{"cord", {60, 1, 1}},
        Form{"rope", {40, 2, 2}}, Form{"64 points", {4, 4, 4}, true}}) {
    for (const double stray : {0.0, 0.1, 0.2, 0.3}) {
      for (unsigned seed = 1; seed <= static_cast<unsigned>(seed_count(1)); ++seed) {
        std::mt19937 random(seed);
        const auto offset = [&] { return stray * (2.0 * (random() * 0x1p-32) - 1.0); };
        const Eigen::Matrix3d turn =
            form.turned ? Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix()
                        : Eigen::Matrix3d::Identity().eval();
        const Eigen::Vector3d middle = 0.5 * (form.count.cast<double>() - Eigen::Vector3d::Ones());
        std::vector<Eigen::Vector3d> points;
        for (int k = 0; k < form.count.z(); ++k) {
          for (int j = 0; j < form.count.y(); ++j) {
            for (int i = 0; i < form.count.x(); ++i) {
              const Eigen::Vector3d at(i, j, k), strayed(i + offset(), j + offset(), k + offset());
              if (!form.ball || (at - middle).norm() <= middle.x()) points.push_back(s * (turn * strayed));
            }
          }
        }
        const auto surface = reconstruct_surface(points, elastic_surface_options());
        ASSERT_TRUE(surface) << surface.error().message;
        const double error = std::abs(std::pow(filling_spacing_m(points, surface->mesh) / s, 3) - 1.0);
        if (form.few && stray > 0) {
          report_gap("points.volume_of_few", error);
        } else {
          EXPECT_LT(error, stray > 0 ? kBar : 1e-9) << form.name << ", " << stray << ", seed " << seed;
        }
      }
    }
  }
}

// Without a detectable grid, the spacing follows from the volume inside the surface.
TEST(PointsFile, RandomListsFillTheirSurface) {
  std::mt19937 random(3);
  const auto anywhere = [&] { return 0.16 * (random() * 0x1p-32); };
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 4096; ++i) points.emplace_back(anywhere(), anywhere(), anywhere());
  const auto surface = reconstruct_surface(points, elastic_surface_options());
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_NEAR(std::pow(filling_spacing_m(points, surface->mesh) / 0.01, 3), 1.0, 0.1);
}

// Each point stands for a cube of its spacing, and the body touches at the faces of the cubes.
TEST(PointsFile, BlockStandsOnItsCubes) {
  const ScratchFolder folder;
  std::ofstream csv(folder.path() / "block.csv");
  csv << "x,y,z\n";
  for (int k = 0; k < 125; ++k)
    csv << 0.02 * (k % 5 - 2) << ',' << 0.02 * (k / 5 % 5 - 2) << ',' << 0.02 * (k / 25 - 2) << '\n';
  csv.close();
  v1::Scene file;
  ASSERT_TRUE(
      google::protobuf::util::JsonStringToMessage(R"({ "environment": { "colliders": [ { "plane": {} } ] },
      "objects": [ { "name": "block", "points": "block.csv", "spacing_m": 0.02, "pose": { "position_m": [0, 0.05, 0] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 300, "youngs_modulus_pa": 1e6 } } ] })",
                                                  &file)
          .ok());
  auto scene = Scene::build(file, folder.path(), "block", {});
  ASSERT_TRUE(scene) << scene.error().message;
  for (int k = 0; k < 90; ++k) scene->step();
  const double height_m = scene->world().elastic_body(scene->find("block")->id)->centre_m().y();
  // rho g h^2 / 2 E = 1.5e-5 m of its own weight
  EXPECT_NEAR(height_m, 0.05, 1e-4);
}

}  // namespace
}  // namespace livegs
