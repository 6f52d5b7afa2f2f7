// SPDX-License-Identifier: Apache-2.0
// Compares the tables of `livegs analyze` with the output of --json: value, range, source and reason of each
// cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scratch_folder.h"
#include "system/support/sample_files.h"

namespace livegs {
namespace {

using nlohmann::json;

std::string printed(std::vector<std::string> words) {
  words.insert(words.begin(), {LIVEGS_TOOL, "analyze"});
  words.push_back("--offline");
  Program program(words);
  const int code = program.wait();
  EXPECT_EQ(code, 0) << program.err();
  return program.out();
}

// Splits text into lines and collapses spaces, so that columns are identified by their order.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) {
    std::istringstream words(line);
    std::string squeezed;
    for (std::string word; words >> word;) squeezed += (squeezed.empty() ? "" : " ") + word;
    lines.push_back(squeezed);
  }
  return lines;
}

std::string number(double value, const char* format = "%.4g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

double part(const json& value, const char* which, double factor = 1) {
  return factor * value.value(which, 0.0);
}

std::string source_of(const json& value) {
  const std::string source = value["source"];
  return source == "OFFLINE" ? "offline" : source == "PERSON" ? "person" : "another: " + source;
}

std::string range_of(const json& value, double factor) {
  return number(part(value, "low", factor)) + " to " + number(part(value, "high", factor));
}

// "mass 0.3217 kg 0.3217 to 0.3217 person edited by a person"
std::string value_line(const char* name, const json& value, double factor, const std::string& unit) {
  const std::string line = name + (" " + number(part(value, "best", factor))) +
                           (unit.empty() ? "" : " " + unit) + " " + range_of(value, factor) + " " +
                           source_of(value) + " " + value["reason"].get<std::string>();
  return lines_of(line).at(0);
}

// "cup cup stoneware RIGID 321.7 321.7 to 321.7 4e+04 1.000 yes person 0.49"
std::string table_row(const std::string& object, const json& p) {
  const double stiffness_mpa =
      1e-6 * part(p["structure_coefficient"], "best") * part(p["youngs_modulus_pa"], "best");
  const json& mass = p["mass_kg"];
  std::string row = object;
  for (const std::string& cell :
       {p["label"].get<std::string>(), p["material"].get<std::string>(), p["behavior"].get<std::string>(),
        number(part(mass, "best", 1e3)), range_of(mass, 1e3), number(stiffness_mpa, "%.3g"),
        number(part(p["deformation_resistance"], "best"), "%.3f"),
        std::string(p.value("fragile", false) ? "yes" : "no"), source_of(mass),
        number(p.value("confidence", 0.0), "%.2f")}) {
    row += " " + cell;
  }
  return row;
}

class AnalyzeTable : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::copy(sample_files(LIVEGS_TOOL), scene_);
    folder_.write("scene/cup.physics.json", R"({ "edits": { "mass_kg": 0.3217 } })");
  }

  ScratchFolder folder_;
  const std::string scene_ = folder_ / "scene";
};

TEST_F(AnalyzeTable, AssetTableMatchesJson) {
  const std::string cup = scene_ + "/cup.ply";
  const json p = json::parse(printed({cup, "--json"}));
  const std::vector<std::string> lines = lines_of(printed({cup}));
  const std::string material = p["material"];
  const std::vector<std::string> wanted = {
      "identified as cup, of " + material + " (confidence " + number(p["confidence"], "%.2f") + ")",
      "behaviour RIGID: " + p["behavior_reason"].get<std::string>(),
      "fill OPEN_SHELL: " + p["fill_reason"].get<std::string>(),
      "fragile yes",
      value_line("longest side", p["longest_side_m"], 1, "m"),
      value_line("mass", p["mass_kg"], 1, "kg"),
      value_line("wall thickness", p["wall_thickness_m"], 1e3, "mm"),
      value_line("Young's modulus", p["youngs_modulus_pa"], 1e-6, "MPa"),
      value_line("Poisson ratio", p["poisson_ratio"], 1, ""),
      value_line("structure coefficient", p["structure_coefficient"], 1, ""),
      value_line("deformation resistance", p["deformation_resistance"], 1, ""),
      value_line("plasticity", p["plasticity"], 1, ""),
      value_line("damping", p["damping"], 1, ""),
      value_line("friction", p["friction"], 1, ""),
      value_line("restitution", p["restitution"], 1, ""),
      value_line("break impulse", p["break_impulse_n_s"], 1, "N s")};
  EXPECT_EQ(lines, wanted);
  // Also compares fixed values: an edited mass, and the table of materials for stoneware.
  ASSERT_EQ(lines.size(), wanted.size());
  EXPECT_EQ(lines[5], "mass 0.3217 kg 0.3217 to 0.3217 person edited by a person");
  EXPECT_EQ(lines[9], "structure coefficient 1 1 to 1 offline bulk");
  EXPECT_EQ(lines[7].rfind("Young's modulus 4e+04 MPa 3e+04 to 6e+04 offline stoneware", 0), 0u) << lines[7];
}

TEST_F(AnalyzeTable, SceneTableHasOneRowPerObject) {
  const std::string scene = scene_ + "/sample.scene.json";
  const json objects = json::parse(printed({scene, "--json"}))["objects"];
  const std::vector<std::string> lines = lines_of(printed({scene}));
  std::vector<std::string> wanted = {
      "object identified as material behaviour mass g 90 % range s E MPa d_R fragile source confidence"};
  for (const json& one : objects) wanted.push_back(table_row(one["object"], one["physics"]));
  ASSERT_EQ(objects.size(), 6u);  // stool, plant, pillow, hat, cup and duck
  EXPECT_EQ(lines, wanted);
  const std::string cup = "cup cup stoneware RIGID 321.7 321.7 to 321.7 4e+04 1.000 yes person ";
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                          [&](const std::string& line) { return line.rfind(cup, 0) == 0; }));
}

}  // namespace
}  // namespace livegs
