// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "export/usd/usda_document.h"
#include "export/usd/usda_text.h"
#include "export/usda_scene.h"
#include "server/export/made_up_scene.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

const UsdaPrim* find_prim(const std::vector<UsdaPrim>& prims, const std::string& path) {
  for (const UsdaPrim& prim : prims) {
    if (prim.path == path) return &prim;
    if (const UsdaPrim* found = find_prim(prim.children, path)) return found;
  }
  return nullptr;
}

TEST(UsdaScene, KernelsAreReadBackAsTheSameFloats) {
  const PortableScene scene = made_up_scene(3);
  const auto back = decode_usda_scene(encode_usda_scene(scene), "scene.usda");
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->bodies.size(), scene.bodies.size());
  for (size_t b = 0; b < scene.bodies.size(); ++b) {
    const GaussianAsset &before = *scene.bodies[b].asset, &after = *back->bodies[b].asset;
    ASSERT_EQ(before.size(), after.size());
    EXPECT_EQ(before.positions, after.positions);
    EXPECT_EQ(before.sh_dc, after.sh_dc);
    EXPECT_EQ(before.sh_rest, after.sh_rest);
    for (size_t i = 0; i < before.size(); ++i) {
      EXPECT_LT((before.log_scales[i] - after.log_scales[i]).norm(), 1e-5f);
      EXPECT_NEAR(before.opacity_logits[i], after.opacity_logits[i], 1e-3f);
      EXPECT_EQ(before.rotations[i].coeffs(), after.rotations[i].coeffs());
    }
    const Similarity &a = scene.bodies[b].object_from_asset, &c = back->bodies[b].object_from_asset;
    EXPECT_EQ(a.scale, c.scale);
    EXPECT_LT(a.rotation.angularDistance(c.rotation), 1e-7);
    EXPECT_EQ(a.translation_m, c.translation_m);
  }
}

// Names, types and units of UsdPhysics.
TEST(UsdaScene, PhysicsHasTheNamesOfUsd) {
  PortableScene scene;
  PortableBody& body = scene.bodies.emplace_back();
  body.name = "box 1";
  body.behavior = v1::Physics::RIGID;
  body.mass_kg = 2;
  body.angular_velocity_rad_s = {0, M_PI, 0};
  PortableShape& shape = body.shapes.emplace_back();
  shape.size_m = {1, 2, 3};
  shape.friction = 0.3;
  const std::string text = encode_usda_scene(scene);
  EXPECT_NE(text.find("quatf physics:principalAxes = (1, 0, 0, 0)"), text.npos);
  const auto document = parse_usda(text, "box.usda");
  ASSERT_TRUE(document) << document.error().message;
  EXPECT_EQ(document->metadata.at("upAxis").texts[0], "Y");
  EXPECT_EQ(document->metadata.at("metersPerUnit").numbers[0], 1);
  EXPECT_EQ(document->metadata.at("defaultPrim").texts[0], "World");
  const UsdaPrim* world = find_prim(document->roots, "/World/physicsScene");
  ASSERT_TRUE(world);
  EXPECT_EQ(world->value("physics:gravityDirection")->numbers, (std::vector<double>{0, -1, 0}));
  EXPECT_EQ(world->value("physics:gravityMagnitude")->numbers[0], 9.81);
  const UsdaPrim* prim = find_prim(document->roots, "/World/box_1");
  ASSERT_TRUE(prim);
  EXPECT_TRUE(prim->has_schema("PhysicsRigidBodyAPI") && prim->has_schema("PhysicsMassAPI"));
  EXPECT_NEAR(prim->value("physics:angularVelocity")->numbers[1], 180, 1e-12) << "degrees per second";
  const UsdaPrim* collider = find_prim(document->roots, "/World/box_1/collider_0");
  ASSERT_TRUE(collider);
  EXPECT_EQ(collider->type, "Cube");
  EXPECT_TRUE(collider->has_schema("PhysicsCollisionAPI"));
  const UsdaPrim* material = find_prim(document->roots, collider->text("material:binding:physics"));
  ASSERT_TRUE(material);
  EXPECT_TRUE(material->has_schema("PhysicsMaterialAPI"));
  EXPECT_EQ(material->value("physics:staticFriction")->numbers[0], 0.3);
}

TEST(UsdaScene, TextsAndNumbersSurvive) {
  for (const std::string text :
       {"", "plain", "a \"b\" \\ c", "two\nlines", "\x01\x7f", "\xc3\xa4\xf0\x9f\x98\x80"}) {
    const auto document = parse_usda("#usda 1.0\n(\n doc = " + usda_string(text) + "\n)\n", "text.usda");
    ASSERT_TRUE(document) << document.error().message;
    EXPECT_EQ(document->metadata.at("doc").texts[0], text);
  }
  EXPECT_EQ(usda_string("\xff"), "\"\xef\xbf\xbd\"") << "invalid UTF-8";
  for (const double number : {0.1, -1e-300, 1.7976931348623157e308, 3.0, 1.0 / 3}) {
    const auto document = parse_usda("#usda 1.0\n(\n x = " + usda_number(number) + "\n)\n", "number.usda");
    ASSERT_TRUE(document) << document.error().message;
    EXPECT_EQ(document->metadata.at("x").numbers[0], number);
  }
}

// Syntax that other programs write.
TEST(UsdaScene, ParsesTheSyntaxOfOtherPrograms) {
  const auto document = parse_usda(R"(#usda 1.0
(
    """A comment
    of two lines"""
    customLayerData = { string creator = "x"; dictionary d = { int a = 1 } }
    upAxis = "Y"
)
# a comment
def Xform "A" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI"]
    kind = "component"
)
{
    float3 xformOp:translate = (1, -2.5e-3, inf) ( doc = "where" )
    float x.timeSamples = { 0: 1, 1.5: 2, }
    custom rel target
    rel other = [</A/B>, </A/C>]
    token[] empty = []
    asset file = @a.png@
    def "B" { }
    over Mesh "C" { bool b = false }
}
)",
                                   "other.usda");
  ASSERT_TRUE(document) << document.error().message;
  ASSERT_EQ(document->roots.size(), 1u);
  const UsdaPrim& a = document->roots[0];
  EXPECT_TRUE(a.has_schema("PhysicsRigidBodyAPI"));
  EXPECT_EQ(a.value("xformOp:translate")->numbers[1], -2.5e-3);
  EXPECT_EQ(a.samples.at("x")[1].first, 1.5);
  EXPECT_EQ(a.value("other")->texts[1], "/A/C");
  ASSERT_EQ(a.children.size(), 2u);
  EXPECT_EQ(a.children[1].path, "/A/C");
}

TEST(UsdaScene, ErrorsNameTheLineAndTheProblem) {
  const auto message = [](const std::string& text) {
    const auto scene = decode_usda_scene(text, "bad.usda");
    return scene ? std::string("none") : scene.error().message;
  };
  const std::string head = "#usda 1.0\n(\n    upAxis = \"Y\"\n    metersPerUnit = 1\n)\n";
  EXPECT_EQ(message("PXR-USDC"),
            "bad.usda: is not a .usda file: its first line is not #usda 1.0; export the stage as .usda");
  EXPECT_EQ(message("#usda 1.0\n(\n    upAxis = \"Z\"\n)\n"),
            "bad.usda: upAxis is not \"Y\"; export the stage with y up");
  EXPECT_EQ(message("#usda 1.0\n(\n    upAxis = \"Y\"\n    metersPerUnit = 0.01\n)\n"),
            "bad.usda: metersPerUnit is not 1; export the stage in metres");
  EXPECT_EQ(message(head + "def Xform \"A\" (\n    references = @b.usda@\n)\n{\n}\n"),
            "bad.usda: line 7: has references, which are not followed; flatten the stage first");
  EXPECT_EQ(message(head + "def Xform \"A\"\n{\n    float x = \n}\n"),
            "bad.usda: line 9: a value is missing; export the file again");
  EXPECT_EQ(message(head + "def Xform \"A\" (prepend apiSchemas = [\"PhysicsRigidBodyAPI\"])\n{\n"
                           "    float physics:mass = -1\n}\n"),
            "bad.usda: /A: has a negative mass or inertia; export the file again");
  EXPECT_EQ(message(head + "def Xform \"A\"\n{\n    double xformOp:rotateX = 3\n"
                           "    uniform token[] xformOpOrder = [\"xformOp:rotateX\"]\n}\n"),
            "bad.usda: /A: has a transform other than translate, orient, scale; export it as these");
}

}  // namespace
}  // namespace livegs
