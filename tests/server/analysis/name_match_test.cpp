// SPDX-License-Identifier: Apache-2.0
#include "analysis/name_match.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/estimate.h"

namespace livegs {
namespace {

std::string label(const char* name) {
  const NameMatch match = match_name(name);
  return match.row ? match.row->label : "";
}

TEST(NameMatch, NamesAreComparedAsWords) {
  EXPECT_EQ(normalised_name("Lego_House-50k.v2"), "lego house k v");
  EXPECT_EQ(normalised_name("myCoffeeMug"), "my coffee mug");
  EXPECT_EQ(label("myCoffeeMug"), "mug");
  EXPECT_EQ(match_name("037_scissors").alias, "scissors");
  EXPECT_EQ(label("tennis_ball_01"), "tennis ball");  // the longer alias wins over "ball"
  EXPECT_EQ(label("two mugs"), "mug");
  EXPECT_EQ(label("smuggler"), "");  // no part of a word
  EXPECT_EQ(label("capital"), "");
  EXPECT_EQ(label(""), "");
  EXPECT_EQ(label("\xff\x01\xfe"), "");
}

TEST(NameMatch, TheLastOfTwoEqualWordsIsTheThing) { EXPECT_EQ(label("cup bowl"), "bowl"); }

TEST(NameMatch, AMaterialIsTheThingOnlyWhereNothingElseIsNamed) {
  EXPECT_EQ(label("wood"), "wood block");
  EXPECT_EQ(label("engineered wood queen bed"), "bed");
  EXPECT_EQ(label("glass cup"), "mug");
  EXPECT_EQ(label("wine glass"), "wine glass");
  EXPECT_EQ(match_material("glass cup").row->name, "soda-lime glass");
}

TEST(NameMatch, MaterialsAreFoundByNameAndByClass) {
  EXPECT_EQ(match_material("marble_bust").row->name, "marble");
  EXPECT_EQ(match_material("wooden spoon").row->name, "hardwood");
  EXPECT_EQ(match_material("carbon steel pan").row->name, "carbon steel");
  EXPECT_FALSE(match_material("wooden spoon").outright);
  EXPECT_EQ(match_material("teddy").row, nullptr);
}

TEST(Knowledge, TablesAreWholeAndConsistent) {
  EXPECT_GE(material_table().size(), 90u);
  for (const MaterialRow& row : material_table()) {
    for (const Span3& span : {row.density_kg_m3, row.youngs_modulus_pa}) {
      EXPECT_TRUE(0 < span.low && span.low <= span.best && span.best <= span.high) << row.name;
    }
    EXPECT_TRUE(row.poisson_ratio >= 0 && row.poisson_ratio <= 0.49) << row.name;
    EXPECT_TRUE(row.restitution >= 0 && row.restitution <= 1 && row.friction >= 0 && row.friction <= 2)
        << row.name;
    EXPECT_TRUE(row.plasticity >= 0 && row.plasticity <= 1 && row.loss_factor > 0 && row.loss_factor <= 2)
        << row.name;
  }
  for (const ObjectRow& row : object_table()) {
    EXPECT_EQ(material_row(row.material).name, row.material) << row.label;
    EXPECT_TRUE(0 < row.size_m.low && row.size_m.low <= row.size_m.best && row.size_m.best <= row.size_m.high)
        << row.label;
    const bool shell = row.fill == v1::Physics::SHELL || row.fill == v1::Physics::OPEN_SHELL;
    EXPECT_EQ(row.wall_m.best > 0, shell) << row.label;
    EXPECT_TRUE(row.wall_m.low <= row.wall_m.best && row.wall_m.best <= row.wall_m.high) << row.label;
    EXPECT_TRUE(0 < row.structure_coefficient.low && row.structure_coefficient.high <= 1) << row.label;
    EXPECT_TRUE(row.size_m.best >= row.middle_m && row.middle_m >= row.short_m && row.short_m > 0)
        << row.label;
    EXPECT_TRUE(row.mass_kg > 0 && row.mass_log_sd > 0 && row.mass_log_sd <= 1) << row.label;
    EXPECT_TRUE(row.box_filling > 0 && row.box_filling < 1) << row.label;
    for (const std::string& name : row.names) {
      EXPECT_EQ(match_name(name).row, &row) << name;  // no name stands twice
      EXPECT_EQ(match_name(name).alias, name);
    }
    double others = 0;
    for (const ObjectAlternative& other : row.alternatives) {
      EXPECT_NE(find_object_row(other.label), nullptr) << row.label << ": " << other.label;
      others += other.probability;
    }
    EXPECT_LT(others, 1) << row.label;
    double shares = 0;
    for (const ObjectPart& part : row.parts) {
      EXPECT_NE(find_material_row(part.material), nullptr) << row.label << ": " << part.material;
      shares += part.mass_share;
    }
    EXPECT_TRUE(row.parts.empty() || std::abs(shares - 1) < 1e-9) << row.label;
  }
  EXPECT_GE(object_table().size(), 400u);
}

// A usual thing's mass is no more than its box full of the densest of its material, and no less than a
// thousandth of the box's in air would be: catches slips of a factor ten in the table.
TEST(Knowledge, UsualMassesFitUsualSizes) {
  for (const ObjectRow& row : object_table()) {
    const double box_m3 = row.size_m.best * row.middle_m * row.short_m;
    const double mean_kg_m3 = row.mass_kg / box_m3;
    // Of metal and stone whatever its row says: things are of several materials.
    EXPECT_LT(mean_kg_m3, std::max(1.05 * material_row(row.material).density_kg_m3.high, 2500.0))
        << row.label;
    EXPECT_GT(mean_kg_m3, 0.1) << row.label;  // a balloon is the lightest
  }
}

// The table knows kinds of things. Files of one captured object or one benchmark, as they are named, say nothing but
// what common words in them say.
TEST(Knowledge, NoRowNamesOneCapturedObject) {
  for (const char* file : {"fourth_st", "playbot_31k", "leica-sofort-top8192", "angel-kneeling", "narcissus", "massa",
                           "trumpet"}) {
    EXPECT_EQ(label(file), "") << file;
  }
  EXPECT_EQ(match_name("007_tuna_fish_can").alias, "fish can");
  EXPECT_EQ(match_name("019_pitcher_base").alias, "pitcher");
  EXPECT_EQ(match_name("010_potted_meat_can").alias, "potted meat");
  EXPECT_EQ(label("angel_statue_only"), "statue");
  for (const ObjectRow& row : object_table()) EXPECT_FALSE(row.source.empty()) << row.label;
}

TEST(Knowledge, APlasticityIsToldByWhatHasIt) {
  EXPECT_EQ(nearest_plasticity_level(0).plasticity, 0);
  EXPECT_NE(nearest_plasticity_level(0.5).references.find("felt"), std::string::npos);
  EXPECT_NE(nearest_plasticity_level(1).references.find("clay"), std::string::npos);
  for (size_t i = 1; i < plasticity_ladder().size(); ++i) {
    EXPECT_GT(plasticity_ladder()[i].plasticity, plasticity_ladder()[i - 1].plasticity);
  }
}

TEST(SizePrior, IsTheTableRow) {
  EXPECT_EQ(size_prior("red mug").label, "mug");
  EXPECT_EQ(size_prior("qwerty").best_m, 0.0);
}

}  // namespace
}  // namespace livegs
