// SPDX-License-Identifier: Apache-2.0
#include "analysis/knowledge/name_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "analysis/estimate.h"

namespace livegs {
namespace {

std::string label(const char* name) {
  const NameMatch match = match_name(name);
  return match.row ? match.row->label : "";
}

TEST(NameMatch, ComparesNamesByWords) {
  EXPECT_EQ(normalised_name("Lego_House-50k.v2"), "lego house k v");
  EXPECT_EQ(normalised_name("myCoffeeMug"), "my coffee mug");
  EXPECT_EQ(label("myCoffeeMug"), "mug");
  EXPECT_EQ(match_name("037_scissors").alias, "scissors");
  EXPECT_EQ(label("tennis_ball_01"), "tennis ball");  // the longer alias wins over "ball"
  EXPECT_EQ(label("two mugs"), "mug");
  EXPECT_EQ(label("smuggler"), "");  // not part of a word
  EXPECT_EQ(label("capital"), "");
  EXPECT_EQ(label(""), "");
  EXPECT_EQ(label("\xff\x01\xfe"), "");
}

TEST(NameMatch, LastOfTwoAliasesIsTheObject) { EXPECT_EQ(label("cup bowl"), "bowl"); }

// The last noun is the object. Words after a preposition, colours, numbers and words of files are skipped.
TEST(NameMatch, LastNounIsTheObject) {
  const std::pair<const char*, const char*> names[] = {{"bird cage", "bird cage"},
                                                       {"mouse_pad", "mouse pad"},
                                                       {"violin case", "instrument case"},
                                                       {"curtain rod", "pipe"},
                                                       {"paperclip", "paper clip"},
                                                       {"shower curtain", "blanket"},
                                                       {"snow globe", "snow globe"},
                                                       {"kitchen scale", "kitchen scale"},
                                                       {"piggy-bank", "piggy bank"},
                                                       {"hotdog", "burger"},
                                                       {"bird house", "mailbox"},
                                                       {"lamp shade", "lampshade"},
                                                       {"tooth brush", "toothbrush"},
                                                       {"tennisball_03", "tennis ball"},
                                                       {"door mat", "mat"},
                                                       {"dog bed", "pillow"},
                                                       {"key chain", "key"},
                                                       {"tea towel", "towel"},
                                                       {"chair cushion", "pillow"},
                                                       {"banana bread", "bread"},
                                                       {"apple pie", "cake"},
                                                       {"ice bucket", "bucket"},
                                                       {"dog bowl blue", "metal bowl"},
                                                       {"fish tank", "fish tank"},
                                                       {"camera bag", "bag"},
                                                       {"toilet brush", "paint brush"},
                                                       {"butter dish", "plate"},
                                                       {"candle holder", "candlestick"},
                                                       {"egg timer", "timer"},
                                                       {"bread knife", "kitchen knife"},
                                                       {"knife block", "wood block"},
                                                       {"cheese board", "wood block"},
                                                       {"guitar_scan_final", "guitar"},
                                                       {"red mug with a spoon", "mug"},
                                                       {"vase on table", "vase"},
                                                       {"can of tuna", "tuna"},
                                                       {"box of crackers", "cracker box"},
                                                       {"cup of coffee", "mug"},
                                                       {"bag of candy", "candy"},
                                                       {"statue of a horse", "statue"},
                                                       {"chair leather old", "chair"},
                                                       {"boxes", "box"},
                                                       {"crème brûlée dish", "plate"},
                                                       {"Cafe\xCC\x81 cup", "mug"},
                                                       {"fur block", "wood block"},
                                                       {"angel_statue_only", "statue"}};
  for (const auto& [name, thing] : names) {
    EXPECT_EQ(label(name), thing) << name;
    EXPECT_EQ(match_name(name).tail, NameMatch::Tail::Nothing) << name << ": " << match_name(name).tail_words;
  }
  EXPECT_EQ(match_material("fur block").row->name, "plush");
}

// Another noun after the alias gives an unknown object; other words may be anything.
TEST(NameMatch, NotesWordsAfterTheObject) {
  for (const char* name :
       {"cake stand", "wine rack", "phone case", "guitar stand", "book holder", "dog house", "chair leg",
        "coffee grinder", "tv stand", "pencil sharpener", "stand for a guitar"}) {
    const NameMatch match = match_name(name);
    EXPECT_NE(match.row, nullptr) << name;
    EXPECT_EQ(match.tail, NameMatch::Tail::AnotherThing) << name << ": " << match.alias;
    EXPECT_EQ(size_prior(name).best_m, 0.0) << name;
  }
  for (const char* name : {"mug tuesday", "hammer_berlin", "slice of pizza"}) {
    EXPECT_EQ(match_name(name).tail, NameMatch::Tail::Unknown) << name;
  }
  EXPECT_EQ(match_name("mug tuesday").tail_words, "tuesday");
}

TEST(NameMatch, UncertainNameWidensTheMassRange) {
  ObjectFacts facts;
  facts.scale_known = true;
  facts.mesh.size_m = facts.mesh.principal_size_m = {0.3, 0.25, 0.25};
  facts.mesh.volume_m3 = facts.mesh.hull_volume_m3 = 0.012;
  facts.mesh.area_m2 = 0.3;
  facts.mesh.mean_wall_m = 0.08;
  facts.mesh.solidity = 1;
  const auto estimate = [&](const char* name) {
    facts.name = name;
    return estimate_offline(facts);
  };
  const auto width = [](const v1::PhysicalParameters& p) {
    return std::log(p.mass_kg().high() / p.mass_kg().low());
  };
  for (const char* noun : {"cake", "guitar", "dog"}) {
    const std::string name = noun;
    const auto plain = estimate(noun), unknown = estimate((name + " tuesday").c_str()),
               other = estimate((name + " stand").c_str());
    EXPECT_GT(plain.confidence(), unknown.confidence()) << noun;
    EXPECT_GT(unknown.confidence(), other.confidence()) << noun;
    EXPECT_GT(width(unknown), 1.2 * width(plain)) << noun;
    EXPECT_GT(width(other), 1.2 * width(plain)) << noun;
    EXPECT_EQ(plain.label(), noun);
    EXPECT_EQ(other.label(), "object");
    EXPECT_NE(other.mass_kg().best(), plain.mass_kg().best());
  }
}

TEST(NameMatch, MaterialIsTheObjectOnlyIfAlone) {
  EXPECT_EQ(label("wood"), "wood block");
  EXPECT_EQ(label("engineered wood queen bed"), "bed");
  EXPECT_EQ(label("glass cup"), "mug");
  EXPECT_EQ(label("wine glass"), "wine glass");
  EXPECT_EQ(match_material("glass cup").row->name, "soda-lime glass");
}

TEST(NameMatch, FindsMaterialsByNameAndClass) {
  EXPECT_EQ(match_material("marble_bust").row->name, "marble");
  EXPECT_EQ(match_material("wooden spoon").row->name, "hardwood");
  EXPECT_EQ(match_material("carbon steel pan").row->name, "carbon steel");
  EXPECT_FALSE(match_material("wooden spoon").outright);
  EXPECT_EQ(match_material("teddy").row, nullptr);
}

TEST(Knowledge, TablesAreCompleteAndConsistent) {
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
      EXPECT_EQ(match_name(name).row, &row) << name;  // names are unique
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

// A typical mass lies between a thousandth of the box in air and the box filled with the densest of its
// material. Catches factor-of-ten slips in the table.
TEST(Knowledge, TypicalMassesFitTypicalSizes) {
  for (const ObjectRow& row : object_table()) {
    const double box_m3 = row.size_m.best * row.middle_m * row.short_m;
    const double mean_kg_m3 = row.mass_kg / box_m3;
    // Up to metal and stone for every row, because objects have several materials.
    EXPECT_LT(mean_kg_m3, std::max(1.05 * material_row(row.material).density_kg_m3.high, 2500.0))
        << row.label;
    EXPECT_GT(mean_kg_m3, 0.1) << row.label;  // a balloon is the lightest
  }
}

// Rows describe classes of objects. File names of single captures and benchmark items match only by their
// common words.
TEST(Knowledge, NoRowIsASingleCapturedObject) {
  for (const char* file : {"fourth_st", "playbot_31k", "leica-sofort-top8192", "angel-kneeling", "narcissus",
                           "massa", "trumpet", "lego_house_50k"}) {
    EXPECT_EQ(label(file), "") << file;
  }
  EXPECT_EQ(match_name("007_tuna_fish_can").alias, "fish can");
  EXPECT_EQ(match_name("019_pitcher_base").alias, "pitcher");
  EXPECT_EQ(match_name("010_potted_meat_can").alias, "meat can");
  EXPECT_EQ(match_name("ponytail_palm").alias, "palm");
  EXPECT_EQ(label("angel_statue_only"), "statue");
  for (const ObjectRow& row : object_table()) EXPECT_FALSE(row.source.empty()) << row.label;
}

bool any_row_is_called(const std::string& name) {
  return std::any_of(object_table().begin(), object_table().end(), [&](const ObjectRow& row) {
    return std::find(row.names.begin(), row.names.end(), name) != row.names.end();
  });
}

// Names of two or more words that a measured object's file or label shares with the table must be common
// household terms. Any other would have been copied from the data.
bool is_ordinary(const std::string& name) {
  for (const char* one : {"coffee can", "cracker box", "mustard bottle", "power drill", "cordless drill",
                          "wood block", "wooden block", "marker pen", "tennis ball", "golf ball",
                          "metal bowl", "metal mug", "metal plate", "plastic pitcher", "plastic chain"}) {
    if (name == one) return true;
  }
  return false;
}

TEST(Knowledge, NoNameIsABrandOrATestObject) {
  for (const char* brand :
       {"cheez it",  "windex",       "spam",        "pringles",     "jello",           "nutella",
        "kleenex",   "tupperware",   "pyrex",       "lego",         "duplo",           "hot wheels",
        "barbie",    "transformer",  "rubiks cube", "rubik s cube", "sharpie",         "scotch tape",
        "play doh",  "nerf",         "nerf gun",    "nerf ball",    "polaroid",        "iphone",
        "ipad",      "kindle",       "macbook",     "xbox",         "xbox controller", "playstation",
        "arduino",   "raspberry pi", "hoover",      "crocs",        "vespa",           "coke can",
        "tetra pak", "stanley knife"}) {
    EXPECT_FALSE(any_row_is_called(brand)) << brand;
  }
  std::ifstream known(std::filesystem::path(LIVEGS_TESTS_DIR) / "server/analysis/estimate/known_objects.csv");
  size_t labels = 0;
  std::string line, label;
  for (std::getline(known, line); std::getline(known, line); ++labels) {
    std::istringstream cells(line);
    std::getline(cells, label, ',') && std::getline(cells, label, ',');
    label = normalised_name(label);
    EXPECT_TRUE(label.find(' ') == std::string::npos || is_ordinary(label) || !any_row_is_called(label))
        << label;
  }
  EXPECT_GT(labels, 20u);
}

TEST(Knowledge, NoNameIsThatOfACapture) {
  const std::filesystem::path data(LIVEGS_SHARED_DATA_DIR);
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "shared data is not here";
  size_t names = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data)) {
    const std::string name = normalised_name(entry.path().stem().string());
    if (name.find(' ') == std::string::npos) continue;
    ++names;
    EXPECT_TRUE(is_ordinary(name) || !any_row_is_called(name)) << entry.path();
  }
  EXPECT_GT(names, 30u);
}

TEST(Knowledge, FindsPlasticityByReferenceObject) {
  EXPECT_EQ(nearest_plasticity_level(0).plasticity, 0);
  EXPECT_NE(nearest_plasticity_level(0.5).text().find("felt"), std::string::npos);
  EXPECT_NE(nearest_plasticity_level(1).text().find("clay"), std::string::npos);
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
