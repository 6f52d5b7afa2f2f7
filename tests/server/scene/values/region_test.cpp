// SPDX-License-Identifier: Apache-2.0
// Conversion of the regions of a scene file to the input of the physics room.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "scene/build/build_object.h"
#include "scene/check/check_scene.h"
#include "scene/scene.h"
#include "scene/values/region_value.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

v1::Scene parse(const std::string& json) {
  v1::Scene scene;
  const auto status = google::protobuf::util::JsonStringToMessage(json, &scene);
  EXPECT_TRUE(status.ok()) << status.message() << "\n" << json;
  return scene;
}

// A bar of 0.4 m by 0.1 m by 0.1 m with these regions and other fields.
v1::Scene bar(const std::string& regions, const std::string& more = "", const std::string& events = "[]") {
  return parse(R"({ "objects": [ { "name": "bar", "shape": { "box": { "size_m": [0.4, 0.1, 0.1] } },
    "spacing_m": 0.025, )" +
               more + R"( "regions": [)" + regions + R"(] } ], "events": )" + events + " }");
}
constexpr const char* kElastic =
    R"("physics": { "behavior": "ELASTIC", "density_kg_m3": 1000, "youngs_modulus_pa": 1e5, "poisson_ratio": 0.3 },)";

ElasticBodyDescription built(const v1::Scene& scene) {
  const auto checked = check_scene(scene);
  EXPECT_TRUE(checked) << checked.error().message;
  auto object = build_object(scene.objects(0), "", 0, "objects[0]", WorldSettings{});
  EXPECT_TRUE(object) << object.error().message;
  return std::get<ElasticBodyDescription>(object->body);
}

// Returns the error of checking or building the scene.
std::string refusal(const v1::Scene& scene) {
  if (auto checked = check_scene(scene); !checked) return checked.error().message;
  auto made = Scene::build(scene, "", "test", {});
  return made ? "" : made.error().message;
}

TEST(Region, EveryPropertyReachesTheBody) {
  const ElasticBodyDescription body =
      built(bar(R"(
    { "name": "clamp", "box": { "min_m": [-0.2, -0.05, -0.05], "max_m": [-0.19, 0.05, 0.05] }, "fixed": true },
    { "name": "stiff half", "box": { "min_m": [0, -1, -1] },
      "material": { "youngs_modulus_pa": 2e5, "poisson_ratio": 0.1, "density_kg_m3": 800, "plasticity": 0.4 } },
    { "name": "loaded face", "box": { "min_m": [0.19, -1, -1] }, "traction_pa": [500, -1, 2] })",
                kElastic + std::string(R"("initial_deformation": [1,2,3,4,5,6,7,8,9],)")));
  ASSERT_EQ(body.regions.size(), 3u);
  EXPECT_EQ(body.regions[0].name, "clamp");
  EXPECT_TRUE(body.regions[0].fixed);
  EXPECT_FALSE(body.regions[0].motion || body.regions[0].material);
  EXPECT_EQ(body.regions[0].min_m, Vector3d(-0.2, -0.05, -0.05));
  EXPECT_EQ(body.regions[0].max_m, Vector3d(-0.19, 0.05, 0.05));
  // A box without max_m is open on that side.
  EXPECT_EQ(body.regions[1].min_m, Vector3d(0, -1, -1));
  EXPECT_GT(body.regions[1].max_m.minCoeff(), 1e5);
  ASSERT_TRUE(body.regions[1].material);
  EXPECT_EQ(body.regions[1].material->youngs_modulus_pa, 2e5);
  EXPECT_EQ(body.regions[1].material->poisson_ratio, 0.1);
  EXPECT_EQ(body.regions[1].material->density_kg_m3, 800);
  EXPECT_EQ(body.regions[1].material->plasticity, 0.4);
  EXPECT_EQ(body.regions[2].traction_pa, Vector3d(500, -1, 2));
  EXPECT_FALSE(body.regions[2].fixed);
  Eigen::Matrix3d row_by_row;
  row_by_row << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  EXPECT_EQ(body.initial_deformation, row_by_row);
}

TEST(Region, UnsetValuesOfAMaterialStayUnset) {
  const auto body = built(bar(R"({ "box": {}, "material": { "density_kg_m3": 500 } })", kElastic));
  EXPECT_FALSE(body.regions[0].material->youngs_modulus_pa || body.regions[0].material->poisson_ratio ||
               body.regions[0].material->plasticity);
  EXPECT_EQ(body.initial_deformation, Eigen::Matrix3d::Identity());
}

// Compares the motions with their closed forms at a point off the axes.
TEST(Region, MotionsMatchTheirClosedForms) {
  const auto moved = [](const std::string& motion, double time_s) -> Vector3d {
    const auto body = built(bar(R"({ "boundary": true, "motion": )" + motion + " }", kElastic));
    EXPECT_TRUE(body.regions[0].boundary);
    return moved_point(*body.regions[0].motion, Vector3d(0.1, 0.02, -0.03), time_s) -
           Vector3d(0.1, 0.02, -0.03);
  };
  const auto near = [](const Vector3d& a, const Vector3d& b) { return (a - b).norm() < 1e-15; };
  const std::string ramp =
      R"({ "displacement_ramp": { "displacement_m": [0.002, 0, 0.001], "start_s": 0.5, "end_s": 1 } })";
  EXPECT_TRUE(near(moved(ramp, 0.5), Vector3d::Zero()));
  EXPECT_TRUE(near(moved(ramp, 0.75), Vector3d(0.001, 0, 0.0005)));
  EXPECT_TRUE(near(moved(ramp, 9), Vector3d(0.002, 0, 0.001)));

  // A shear of x by y about (0, 0.01, 0) moves x by 0.5 (y - 0.01).
  const std::string affine = R"({ "affine_ramp": { "matrix": [1,0.5,0, 0,1,0, 0,0,1], "about_m": [0, 0.01, 0],
    "start_s": 0, "end_s": 1, "return_end_s": 3 } })";
  EXPECT_TRUE(near(moved(affine, 1), Vector3d(0.005, 0, 0)));
  EXPECT_TRUE(near(moved(affine, 2), Vector3d(0.0025, 0, 0)));
  EXPECT_TRUE(near(moved(affine, 3), Vector3d::Zero()));
  const std::string staying =
      R"({ "affine_ramp": { "matrix": [1,0.5,0, 0,1,0, 0,0,1], "start_s": 0, "end_s": 1 } })";
  EXPECT_TRUE(near(moved(staying, 3), Vector3d(0.01, 0, 0)));  // about the origin

  const std::string pulse =
      R"({ "half_sine_pulse": { "displacement_m": [0, 0.01, 0], "start_s": 1, "width_s": 0.5 } })";
  EXPECT_TRUE(near(moved(pulse, 1.25), Vector3d(0, 0.01, 0)));
  EXPECT_TRUE(near(moved(pulse, 1.5), Vector3d::Zero()));

  const std::string steady = R"({ "constant_velocity": { "velocity_m_s": [0, 0, -2], "start_s": 1 } })";
  EXPECT_TRUE(near(moved(steady, 3.5), Vector3d(0, 0, -5)));  // without an end time the motion continues
  const std::string ending =
      R"({ "constant_velocity": { "velocity_m_s": [0, 0, -2], "start_s": 1, "end_s": 2 } })";
  EXPECT_TRUE(near(moved(ending, 3.5), Vector3d(0, 0, -2)));
}

// Each error names the object, the region, the field and the remedy.
TEST(Region, RefusalsNameObjectRegionFieldAndRemedy) {
  const auto region = [](const std::string& body) {
    return bar(R"({ "name": "r", )" + body + " }", kElastic);
  };
  const auto motion = [&](const std::string& body) {
    return region(R"("box": {}, "motion": { )" + body + " }");
  };
  const std::string box = R"("box": {}, )";
  const struct {
    v1::Scene scene;
    const char* field;
    const char* remedy;
  } cases[] = {
      {region(R"("fixed": true)"), "regions[0].box: ", "give min_m and max_m"},
      {region(R"("box": {})"), "regions[0]: has no effect", "omit the region"},
      {region(R"("box": { "min_m": [0, 0.1, 0], "max_m": [0, 0, 0] }, "fixed": true)"),
       "regions[0].box: ", "min_m above max_m along y"},
      {region(R"("box": { "min_m": [0, 0] }, "fixed": true)"), "box.min_m", "give 3"},
      {region(R"("box": { "min_m": [0, "NaN", 0] }, "fixed": true)"), "box.min_m[1]: is nan", "between"},
      {region(R"("box": { "min_m": [0.3, -1, -1] }, "fixed": true)"), "regions[0].box: does not overlap",
       "(0.2, 0.05, 0.05)"},
      {region(R"("box": { "min_m": [0.2, -1, -1] }, "traction_pa": [1, 0, 0])"),
       "regions[0].box: does not overlap", ""},
      {region(box + R"("traction_pa": [1, 2])"), "traction_pa", "give 3"},
      {region(box + R"("traction_pa": [1e12, 0, 0])"), "traction_pa[0]", "1e+09"},
      {region(box + R"("traction_pa": ["NaN", 0, 0])"), "traction_pa[0]: is nan", ""},
      {region(R"("boundary": true)"), "boundary", "give a motion, or a box"},
      {region(
           R"("boundary": true, "box": {}, "motion": { "displacement_ramp": { "displacement_m": [1,0,0] } })"),
       "boundary: conflicts with box", "give one of them"},
      {region(R"("boundary": true, "motion": { "displacement_ramp": { "displacement_m": [1,0,0] } },
                 "material": { "density_kg_m3": 5 })"),
       "boundary: supports a motion only", "give a box"},
      {region(box + R"("fixed": true, "motion": { "displacement_ramp": { "displacement_m": [1,0,0] } })"),
       "motion: conflicts with fixed", "give one of them"},
      {motion(""), "motion: is empty", "give displacement_ramp"},
      {motion(R"("displacement_ramp": { "end_s": 1 })"), "displacement_ramp.displacement_m: is missing",
       "give [x"},
      {motion(R"("displacement_ramp": { "displacement_m": [1, "Infinity", 0] })"),
       "displacement_m[1]: is inf", ""},
      {motion(R"("displacement_ramp": { "displacement_m": [1,0,0], "start_s": 2, "end_s": 1 })"),
       "displacement_ramp.end_s: is 1, before start_s, which is 2", "swap"},
      {motion(R"("displacement_ramp": { "displacement_m": [1,0,0], "start_s": -1 })"), "start_s: is -1",
       "between 0"},
      {motion(R"("affine_ramp": { "end_s": 1 })"), "affine_ramp.matrix: is missing", "nine numbers"},
      {motion(R"("affine_ramp": { "matrix": [1,0,0,1], "end_s": 1 })"), "affine_ramp.matrix: has 4",
       "give 9"},
      {motion(R"("affine_ramp": { "matrix": [1e3,0,0, 0,1,0, 0,0,1] })"), "affine_ramp.matrix[0]: is 1000",
       "100"},
      {motion(R"("affine_ramp": { "matrix": [1,0,0, 0,1,0, 0,0,1], "end_s": 2, "return_end_s": 1 })"),
       "affine_ramp.return_end_s: is 1, before end_s", ""},
      {motion(R"("half_sine_pulse": { "displacement_m": [1,0,0] })"), "half_sine_pulse.width_s: is 0",
       "between"},
      {motion(R"("constant_velocity": { "velocity_m_s": [1e9,0,0] })"), "velocity_m_s[0]", "1000"},
      {motion(R"("constant_velocity": { "velocity_m_s": [1,0,0], "start_s": 1, "end_s": 0.5 })"), "end_s",
       ""},
      {region(box + R"("material": { "restitution": 1 })"),
       "material.restitution: is not supported in a region",
       "youngs_modulus_pa, poisson_ratio, density_kg_m3, plasticity and friction"},
      {region(box + R"("material": { "friction": 3 })"), "material.friction: is 3", "0 and 2"},
      {region(box + R"("material": { "behavior": "RIGID" })"), "material.behavior", ""},
      {region(box + R"("material": { "mass_kg": 1 })"), "material.mass_kg", ""},
      {region(box + R"("material": { "damping": 1 })"), "material.damping", ""},
      {region(box + R"("material": { "poisson_ratio": 0.5 })"), "material.poisson_ratio: is 0.5",
       "0 and 0.49"},
      {region(box + R"("material": { "youngs_modulus_pa": 0 })"), "material.youngs_modulus_pa: is 0",
       "1 and 1e+12"},
      {region(box + R"("material": { "plasticity": 1.1 })"), "material.plasticity: is 1.1", "0 and 1"},
      {bar(R"({ "name": "r", "box": {}, "fixed": true }, { "name": "r", "box": {}, "fixed": true })",
           kElastic),
       "regions[1].name: is used twice", ""},
      {bar(R"({ "name": "r", "box": {}, "material": { "density_kg_m3": 5 } })",
           R"("physics": { "behavior": "ELASTIC", "mass_kg": 4 },)"),
       "regions[0].material.density_kg_m3: conflicts with objects[0].physics.mass_kg",
       "physics.density_kg_m3 instead"},
  };
  for (const auto& one : cases) {
    const std::string message = refusal(one.scene);
    EXPECT_EQ(message.find("object \"bar\": region \"r\": objects[0]."), 0u) << one.field << "\n" << message;
    EXPECT_NE(message.find(one.field), std::string::npos) << one.field << "\n" << message;
    EXPECT_NE(message.find(one.remedy), std::string::npos) << one.remedy << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Region, RefusesRegionsOfRigidObjects) {
  const std::string moved =
      R"({ "box": {}, "motion": { "constant_velocity": { "velocity_m_s": [1,0,0] } } })";
  for (const char* behavior : {"RIGID", "STATIC"}) {
    const std::string physics = std::string(R"("physics": { "behavior": ")") + behavior + R"(" },)";
    std::string message = refusal(bar(moved, physics));
    EXPECT_NE(message.find("objects[0].regions: is only for elastic objects"), std::string::npos) << message;
    EXPECT_NE(message.find("set physics.behavior to ELASTIC"), std::string::npos) << message;
    message = refusal(bar("", physics + R"("initial_deformation": [2,0,0, 0,1,0, 0,0,1],)"));
    EXPECT_NE(message.find("objects[0].initial_deformation: is only for elastic objects"), std::string::npos)
        << message;
  }
  // AUTO becomes rigid: 1 GPa is above the paper's limit of 200 MPa.
  const std::string message = refusal(bar(moved, R"("physics": { "youngs_modulus_pa": 1e9 },)"));
  EXPECT_EQ(message.find(
                "object \"bar\": objects[0].regions: is only for elastic objects, and this object is RIGID"),
            0u)
      << message;
}

TEST(Region, InitialDeformationIsNineBoundedNumbers) {
  for (const char* matrix : {"[1,0,0]", R"([1,0,0, 0,"NaN",0, 0,0,1])", "[1,0,0, 0,1,0, 0,0,101]"}) {
    const std::string message =
        refusal(bar("", std::string(kElastic) + R"("initial_deformation": )" + matrix + ","));
    EXPECT_EQ(message.find("object \"bar\": objects[0].initial_deformation"), 0u) << message;
  }
  // Singular and mirroring matrices are accepted on purpose: bodies recover from them.
  EXPECT_EQ(refusal(bar("", std::string(kElastic) + R"("initial_deformation": [-1,0,0, 0,0,0, 0,0,1],)")),
            "");
}

TEST(Region, ReleasesNameARegionThatIsHeld) {
  const std::string regions = R"({ "name": "clamp", "box": { "max_m": [-0.19, 1, 1] }, "fixed": true },
    { "name": "soft", "box": {}, "material": { "youngs_modulus_pa": 1e4 } })";
  const auto release = [&](const std::string& target) {
    return refusal(bar(regions, kElastic, R"([ { "time_s": 0.5, "release_region": )" + target + " } ]"));
  };
  EXPECT_EQ(release(R"({ "object": "bar", "region": "clamp" })"), "");
  const std::pair<const char*, const char*> cases[] = {
      {R"({ "object": "bar", "region": "pulled" })",
       "no region called \"pulled\"; fixed or moved regions: clamp"},
      {R"({ "object": "bar" })", "no region called \"\""},
      {R"({ "object": "bar", "region": "soft" })", "neither fixed nor moved"},
      {R"({ "object": "rod", "region": "clamp" })", "no object is called \"rod\""},
  };
  for (const auto& [target, named] : cases) {
    const std::string message = release(target);
    EXPECT_NE(message.find("events[0].release_region."), std::string::npos) << message;
    EXPECT_NE(message.find(named), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace livegs
