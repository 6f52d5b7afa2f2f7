// SPDX-License-Identifier: Apache-2.0
#include "scene/build/part_materials.h"

#include <gtest/gtest.h>

#include <numeric>

#include "analysis/division/part_places.h"
#include "analysis/physics_file.h"
#include "core/log.h"
#include "gaussian/asset_file.h"
#include "geometry/surface/shape_mesh.h"
#include "scene/build/build_object.h"
#include "scratch_folder.h"
#include "server/analysis/division/composite_objects.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// A bar of 1 m with a heavy end: two parts of equal size with shares of 0.8 and 0.2.
v1::PhysicalParameters bar_parts() {
  v1::PhysicalParameters parameters;
  parameters.mutable_mass_kg()->set_best(2);
  parameters.set_material("hardwood");
  for (const auto& [name, material, share] :
       {std::tuple("head", "carbon steel", 0.8), std::tuple("handle", "hardwood", 0.2)}) {
    v1::MaterialPart& part = *parameters.add_parts();
    part.set_name(name);
    part.set_material(material);
    part.set_mass_share(share);
  }
  set_boxes(std::vector<Eigen::AlignedBox3d>{{Vector3d(0, -1, -1), Vector3d(1, 1, 1)}},
            *parameters.mutable_parts(0));
  return parameters;
}

TEST(PartMaterials, MassPropertiesOfATwoPartBarAreThoseOfTwoBoxes) {
  const TriangleMesh bar = box_mesh(Vector3d(1, 0.1, 0.1));
  v1::PhysicalParameters parameters = bar_parts();
  MassProperties properties = solid_mass_properties(bar);
  weigh_parts(bar, false, parameters, properties);
  // Halves at ±0.25 m with shares 0.8 and 0.2.
  EXPECT_NEAR(properties.centre_of_mass_m.x(), 0.25 * 0.6, 0.01);
  EXPECT_NEAR(properties.centre_of_mass_m.y(), 0, 2e-3);  // an eighth of a sample
  const double across = (0.5 * 0.5 + 0.1 * 0.1) / 12 + 0.8 * 0.1 * 0.1 + 0.2 * 0.4 * 0.4;
  EXPECT_NEAR(properties.inertia_m2(1, 1), across, 0.02 * across);
  EXPECT_NEAR(properties.inertia_m2(2, 2), across, 0.02 * across);
  const double along = (0.1 * 0.1 + 0.1 * 0.1) / 12;
  EXPECT_NEAR(properties.inertia_m2(0, 0), along, 0.1 * along);
  EXPECT_NEAR(parameters.parts(0).density_kg_m3(), 0.8 * 2 / 0.005, 0.02 * 0.8 * 2 / 0.005);
  EXPECT_NEAR(parameters.parts(1).density_kg_m3(), 0.2 * 2 / 0.005, 0.02 * 0.2 * 2 / 0.005);
}

TEST(PartMaterials, PartsOfEqualDensityChangeNothing) {
  const TriangleMesh ball = sphere_mesh(0.1, 4);
  v1::PhysicalParameters parameters = bar_parts();
  for (v1::MaterialPart& part : *parameters.mutable_parts()) part.set_mass_share(0.5);
  const MassProperties even = solid_mass_properties(ball);
  for (const bool shell : {false, true}) {
    MassProperties properties = shell ? shell_mass_properties(ball) : even, before = properties;
    weigh_parts(ball, shell, parameters, properties);
    EXPECT_NEAR((properties.centre_of_mass_m - before.centre_of_mass_m).norm(), 0, 1e-3);
    EXPECT_LT((properties.inertia_m2 - before.inertia_m2).norm(), 0.01 * before.inertia_m2.norm());
  }
  // An object without boxes is homogeneous: bitwise the same.
  for (v1::MaterialPart& part : *parameters.mutable_parts()) part.clear_boxes();
  MassProperties properties = even;
  weigh_parts(ball, false, parameters, properties);
  EXPECT_EQ(properties.centre_of_mass_m, even.centre_of_mass_m);
  EXPECT_EQ(properties.inertia_m2, even.inertia_m2);
}

TEST(PartMaterials, AllOfAPartWithoutMaterialGoesToTheOthers) {
  v1::PhysicalParameters parameters = bar_parts();
  set_boxes(std::vector<Eigen::AlignedBox3d>{{Vector3d(5, 5, 5), Vector3d(6, 6, 6)}},
            *parameters.mutable_parts(0));
  const TriangleMesh bar = box_mesh(Vector3d(1, 0.1, 0.1));
  MassProperties properties = solid_mass_properties(bar);
  weigh_parts(bar, false, parameters, properties);
  EXPECT_NEAR(properties.centre_of_mass_m.norm(), 0, 2e-3);
  EXPECT_EQ(parameters.parts(0).density_kg_m3(), 0);
}

TEST(PartMaterials, RegionsOfAnElasticBodyKeepItsMass) {
  v1::PhysicalParameters parameters = bar_parts();
  ElasticBodyDescription body;
  body.particles = sample_particles(box_mesh(Vector3d(1, 0.1, 0.1)));
  body.material.mass_kg = 2;
  body.material.youngs_modulus_pa = 1e6;
  body.regions.push_back(fixed_box(Vector3d(0.4, -1, -1), Vector3d(1, 1, 1)));
  add_part_regions(parameters, body);
  ASSERT_EQ(body.regions.size(), 3u);
  EXPECT_EQ(body.regions[0].name, "part handle");  // the rest, then the boxes, then those of the scene
  EXPECT_EQ(body.regions[1].name, "part head");
  EXPECT_TRUE(body.regions[2].fixed);
  double mass_kg = 0, volume_m3 = 0;
  for (const double one : body.particles.volumes_m3) volume_m3 += one;
  for (size_t i = 0; i < body.particles.positions_m.size(); ++i) {
    double factor = 1;
    for (const BodyRegion& region : body.regions) {
      if (region.material && region.contains(body.particles.positions_m[i], 0))
        factor = region.material->density_factor;
    }
    mass_kg += factor * 2 / volume_m3 * body.particles.volumes_m3[i];
  }
  EXPECT_NEAR(mass_kg, 2, 1e-9);
  // The handle is of the body's own class; steel is as stiff as a visible difference needs.
  EXPECT_EQ(body.regions[0].material->youngs_modulus_factor, 1);
  EXPECT_EQ(body.regions[1].material->youngs_modulus_factor, 10);
}

class BuiltPartsTest : public ::testing::Test {
 protected:
  BuiltObject built(const CompositeObject& object, const std::string& behavior = "RIGID") {
    const std::string file = object.name + ".ply";
    EXPECT_TRUE(write_asset(folder / file, object.asset));
    v1::Object written;
    written.set_asset(file);
    written.set_name(object.name);
    written.set_scale(1);
    v1::Physics::Behavior value = v1::Physics::RIGID;
    EXPECT_TRUE(v1::Physics::Behavior_Parse(behavior, &value));
    written.mutable_physics()->set_behavior(value);
    ObjectSidecar sidecar;
    sidecar.path = physics_file_path(folder / file);
    auto made = build_object(written, folder / "", 0, "objects[0]", WorldSettings(), sidecar);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  ScratchFolder folder;
};

// The truth is that of the solids the objects are made of, with the shares of their rows.
TEST_F(BuiltPartsTest, CentresOfMassOfEightObjectsAreThoseOfTheirParts) {
  for (const CompositeObject& object : composite_objects()) {
    const BuiltObject one = built(object);
    const auto& properties = std::get<RigidBodyDescription>(one.body).properties;
    const double size_m = one.drawn.physics.longest_side_m().best();
    const double off = (properties.centre_of_mass_m - object.centre_of_mass_m).norm() / size_m;
    const double even =
        (solid_mass_properties(*one.cut_mesh).centre_of_mass_m - object.centre_of_mass_m).norm() / size_m;
    std::printf("%-14s centre of mass off by %.1f %% of the length, %.1f %% if homogeneous\n",
                object.name.c_str(), 100 * off, 100 * even);
    EXPECT_TRUE(PartPlaces(one.drawn.physics.parts()).divided()) << one.drawn.physics.parts_reason();
    EXPECT_LT(off, 0.1) << object.name;
    EXPECT_LT(off, even) << object.name;
  }
}

}  // namespace
}  // namespace livegs
