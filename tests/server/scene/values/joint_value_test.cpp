// SPDX-License-Identifier: Apache-2.0
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <fstream>

#include "scene/scene.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

// Returns the error of building a scene with a rigid lid, a static table, a soft pillow and `rest`.
std::string refusal(const std::string& rest, const std::filesystem::path& folder = ".") {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({ "objects": [
      { "name": "lid", "shape": { "box": { "size_m": [0.2, 0.02, 0.2] } }, "physics": { "behavior": "RIGID" } },
      { "name": "table", "shape": { "box": { "size_m": [1, 0.02, 1] } }, "physics": { "behavior": "STATIC" } },
      { "name": "pillow", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 1, 0] },
        "physics": { "behavior": "ELASTIC", "youngs_modulus_pa": 1e4 } } ], )" +
                                                                      rest + " }",
                                                                  &file);
  EXPECT_TRUE(parsed.ok()) << parsed.message();
  auto scene = Scene::build(file, folder, "test", {});
  return scene ? "" : scene.error().message;
}

std::string joint_refusal(const std::string& joint) { return refusal("\"joints\": [ " + joint + " ]"); }

TEST(JointValue, ErrorsNameTheJointTheFieldAndTheRemedy) {
  EXPECT_EQ(joint_refusal("{}"), "joints[0]: has no type; give ball or hinge");
  EXPECT_EQ(joint_refusal(R"({ "ball": {} })"),
            "joints[0].ball.object: is missing; name the object that moves");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "led" } })"),
            "joints[0].ball.object: no object is called \"led\"; name an object of the scene");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "lid", "other": "box" } })"),
            "joints[0].ball.other: no object is called \"box\"; omit it to attach to the world");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "lid", "other": "lid" } })"),
            "joints[0].ball.other: is the same object; name another one, or omit it");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "table", "other": "lid" } })"),
            "joints[0].ball.object: \"table\" is STATIC; name the moving object here, and this one as other");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "lid", "other": "pillow" } })"),
            "joints[0].ball: \"pillow\" is ELASTIC, but joints need rigid objects; make it RIGID, or use a "
            "fixed region");
  EXPECT_EQ(joint_refusal(R"({ "ball": { "object": "lid", "point_m": [0, 1] } })"),
            "joints[0].ball.point_m: has 2 numbers; give 3");
  EXPECT_EQ(joint_refusal(R"({ "hinge": { "object": "lid" } })"),
            "joints[0].hinge.axis: is missing; give [x, y, z]");
  EXPECT_EQ(joint_refusal(R"({ "hinge": { "object": "lid", "axis": [0, 0, 0] } })"),
            "joints[0].hinge.axis: is zero; give a direction");
  EXPECT_EQ(joint_refusal(R"({ "hinge": { "object": "lid", "other": "table", "axis": [1, 0, 0] } })"), "");
}

TEST(JointValue, GrabPathsAreChecked) {
  const ScratchFolder folder;
  const auto path_refusal = [&](const std::string& text) {
    std::ofstream(folder.path() / "path.csv") << text;
    return refusal(R"("events": [ { "grab": { "object": "lid", "path": "path.csv" } } ])", folder.path());
  };
  EXPECT_EQ(path_refusal("time_s,x,y,z\n0,0,1,0\n1,0,2,0\n"), "");
  EXPECT_EQ(path_refusal("x,y,z\n"),
            "path.csv: line 1 must be the header time_s,x,y,z or time_s,x,y,z,qw,qx,qy,qz");
  EXPECT_EQ(path_refusal("time_s,x,y,z\n"), "path.csv: contains no rows; give at least one");
  EXPECT_EQ(path_refusal("time_s,x,y,z\n0,nan,1,0\n"), "path.csv: line 2, column 2: expected 4 numbers");
  EXPECT_EQ(path_refusal("time_s,x,y,z\n0,0,1\n"), "path.csv: line 2, column 3: expected 4 numbers");
  EXPECT_EQ(path_refusal("time_s,x,y,z\n1,0,1,0\n1,0,2,0\n"),
            "path.csv: line 3: time_s must increase, from 0 to 1e6");
  EXPECT_EQ(path_refusal("time_s,x,y,z\n0,1e9,1,0\n"), "path.csv: line 2: position is beyond 1000 m");
  EXPECT_EQ(path_refusal("time_s,x,y,z,qw,qx,qy,qz\n0,0,1,0,2,0,0,0\n"),
            "path.csv: line 2: qw,qx,qy,qz is not a unit quaternion");
  EXPECT_EQ(refusal(R"("events": [ { "grab": { "object": "table", "path": "p" } } ])"),
            "events[0].grab.object: \"table\" is STATIC and cannot be moved; name a moving object");
  EXPECT_EQ(refusal(R"("events": [ { "grab": { "object": "lid" } } ])"),
            "events[0].grab.path: is missing; name a CSV file with the path of the hand");
  EXPECT_EQ(refusal(R"("events": [ { "pull": { "object": "lid" } } ])"),
            "events[0].pull.path: is missing; name a CSV file with the path of the hand");
}

}  // namespace
}  // namespace livegs
