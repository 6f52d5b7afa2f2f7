// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/object_panel.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace livegs {
namespace {

ObjectPanel::Objects pillow_and_room() {
  ObjectPanel::Objects objects;
  objects[1].name = "room";
  objects[1].environment = true;
  StreamedObject& pillow = objects[2];
  pillow.id = 2;
  pillow.name = "pillow";
  pillow.mass_kg = 0.72;
  pillow.physics.set_label("pillow");
  pillow.physics.set_material("foam");
  pillow.physics.set_confidence(0.8);
  pillow.physics.set_behavior(v1::Physics::ELASTIC);
  v1::EstimatedValue& mass = *pillow.physics.mutable_mass_kg();
  mass.set_low(0.4);
  mass.set_best(0.72);
  mass.set_high(1.2);
  mass.set_source(v1::EstimatedValue::OFFLINE);
  mass.set_reason("as pillows of its size weigh");
  return objects;
}

size_t row_of(const ObjectsPanel& panel, const std::string& name) {
  for (size_t i = 0; i < panel.rows.size(); ++i) {
    if (panel.rows[i].name == name) return i;
  }
  ADD_FAILURE() << "no row " << name;
  return 0;
}

TEST(ObjectPanel, ShowsValuesRangesReasonsAndSources) {
  ObjectPanel panel;
  panel.select("pillow");
  const ObjectsPanel shown = panel.shown(pillow_and_room());
  ASSERT_EQ(shown.entries.size(), 1u);  // the environment is not listed
  EXPECT_EQ(shown.entries[0].kind, "foam, elastic");
  EXPECT_EQ(shown.entries[0].mass, "0.72 kg");
  EXPECT_EQ(shown.selected, 0u);
  EXPECT_EQ(shown.facts.at(0), "pillow: likely pillow of foam (80 %)");
  const ValueRow& mass = shown.rows.at(row_of(shown, "Mass"));
  EXPECT_EQ(mass.value, "0.72 kg");
  EXPECT_EQ(mass.origin, "estimate, 0.4 to 1.2 kg");
  EXPECT_EQ(mass.reason, "as pillows of its size weigh");
  EXPECT_LT(mass.range_low, mass.position);
  EXPECT_GT(mass.range_high, mass.position);
  EXPECT_EQ(mass.text_at(mass.position), "0.72 kg");
}

// An object made unbreakable by the user keeps its precomputed pieces.
TEST(ObjectPanel, ShowsFractureForFragileObjectsOnly) {
  StreamedObject cup;
  cup.name = "cup";
  cup.physics.set_behavior(v1::Physics::RIGID);
  cup.physics.set_fragile(true);
  cup.fragility.emplace();
  cup.fragility->set_pieces(32);
  cup.fragility->set_drop_height_m(0.5);
  EXPECT_EQ(object_facts(cup),
            (std::vector<std::string>{"Rigid", "Up to 32 fragments after a drop of 0.50 m"}));
  cup.physics.set_fragile(false);
  EXPECT_EQ(object_facts(cup), (std::vector<std::string>{"Rigid"}));
}

TEST(ObjectPanel, ListsThePartsOfAnObject) {
  StreamedObject hammer;
  hammer.name = "hammer";
  hammer.physics.set_behavior(v1::Physics::RIGID);
  for (const auto& [name, material, share] :
       {std::tuple("head", "carbon steel", 0.7), std::tuple("handle", "hardwood", 0.3)}) {
    v1::MaterialPart& part = *hammer.physics.add_parts();
    part.set_name(name);
    part.set_material(material);
    part.set_mass_share(share);
  }
  EXPECT_EQ(object_facts(hammer).back(), "Parts: head of carbon steel (70 %), handle of hardwood (30 %)");
}

// The places of parts are known in the whole object only, and one part is no division.
TEST(ObjectPanel, PartsAreShownInColoursWhileAskedAndTheObjectIsWhole) {
  ObjectPanel::Objects objects = pillow_and_room();
  StreamedObject& pillow = objects[2];
  ObjectPanel panel;
  panel.select("pillow");
  EXPECT_TRUE(panel.shown(objects).parts.empty());
  for (const auto& [name, share] : {std::pair("cover", 0.2), std::pair("core", 0.8)}) {
    v1::MaterialPart& part = *pillow.physics.add_parts();
    part.set_name(name);
    part.set_material("foam");
    part.set_mass_share(share);
  }
  EXPECT_TRUE(panel.shown(objects).parts.empty());  // without places
  pillow.physics.mutable_parts(1)->add_boxes();
  const ObjectsPanel off = panel.shown(objects);
  ASSERT_EQ(off.parts.size(), 2u);
  EXPECT_FALSE(off.parts_shown);
  EXPECT_EQ(off.parts[0].text, "cover of foam (20 %)");
  EXPECT_NE(off.parts[0].rgb, off.parts[1].rgb);
  EXPECT_EQ(panel.in_part_colours(objects), nullptr);

  PanelActions actions;
  actions.show_parts = true;
  EXPECT_TRUE(panel.act(actions, objects).empty());
  EXPECT_TRUE(panel.shown(objects).parts_shown);
  EXPECT_EQ(panel.in_part_colours(objects), &pillow);
  pillow.rest.revision = 1;  // broken
  EXPECT_TRUE(panel.shown(objects).parts.empty());
  EXPECT_EQ(panel.in_part_colours(objects), nullptr);
  pillow.rest.revision = 0;
  actions.show_parts = false;
  panel.act(actions, objects);
  EXPECT_EQ(panel.in_part_colours(objects), nullptr);
}

PanelActions part_action(PartEdit::Kind kind, size_t part, const std::string& text = "") {
  PanelActions actions;
  actions.parts_open = true;
  actions.part_edit.emplace();
  actions.part_edit->kind = kind;
  actions.part_edit->object = "pillow";
  actions.part_edit->part = part;
  actions.part_edit->text = text;
  return actions;
}

class ObjectPanelParts : public ::testing::Test {
 protected:
  using Kind = PartEdit::Kind;
  // The parts of the call for an edit, which is the only one.
  MaterialParts sent(const PanelActions& actions) {
    const auto calls = panel_.act(actions, objects_);
    EXPECT_EQ(calls.size(), 1u);
    const auto* set = calls.size() == 1 ? std::get_if<SetPhysicsCall>(&calls[0]) : nullptr;
    return set ? set->physics.parts() : MaterialParts();
  }
  // As the server does: the object has the parts, and the call is answered.
  void answer(const MaterialParts& parts) {
    stream(parts);
    reply(parts);
  }
  void stream(const MaterialParts& parts) {
    *objects_[2].physics.mutable_parts() = parts;
    objects_[2].physics.set_parts_source(v1::EstimatedValue::PERSON);
  }
  void reply(const MaterialParts& parts) {
    v1::PhysicsReply reply;
    *reply.mutable_parameters() = objects_[2].physics;
    *reply.mutable_parameters()->mutable_parts() = parts;
    panel_.take_reply("pillow", reply);
  }
  PartsPanel shown() { return panel_.shown(objects_).division.value(); }
  void SetUp() override {
    panel_.select("pillow");
    PanelActions open;
    open.parts_open = true;
    EXPECT_TRUE(panel_.act(open, objects_).empty());
  }

  const Eigen::AlignedBox3d body_{Eigen::Vector3d(-0.2, 0, -0.3), Eigen::Vector3d(0.2, 0.1, 0.3)};
  ObjectPanel::Objects objects_ = pillow_and_room();
  ObjectPanel panel_{[this](const StreamedObject&) { return body_; }};
};

// A text may be finished by selecting another object, or a field of another part.
TEST_F(ObjectPanelParts, AnEditIsOfItsOwnObjectAndPart) {
  answer(sent(part_action(Kind::Add, 0)));
  PanelActions other;
  other.part_selected = 1;
  EXPECT_TRUE(panel_.act(other, objects_).empty());
  answer(sent(part_action(Kind::Name, 0, "cover")));
  EXPECT_EQ(shown().selected, 1u);
  panel_.select("room");
  const auto calls = panel_.act(part_action(Kind::Name, 0, "seam"), objects_);
  ASSERT_EQ(calls.size(), 1u);
  const auto* set = std::get_if<SetPhysicsCall>(&calls[0]);
  ASSERT_TRUE(set);
  EXPECT_EQ(set->object, "pillow");
  EXPECT_EQ(set->physics.parts(0).name(), "seam");
}

TEST_F(ObjectPanelParts, ObjectIsDividedAndItsPartsAreEditedByOneCallEach) {
  EXPECT_TRUE(shown().parts.empty());
  EXPECT_TRUE(panel_.marked_boxes(objects_).empty());
  answer(sent(part_action(Kind::Add, 0)));
  ASSERT_EQ(shown().parts.size(), 2u);
  EXPECT_EQ(shown().selected, 1u);
  EXPECT_EQ(shown().parts[1].material, "foam");
  ASSERT_EQ(shown().parts[1].boxes.size(), 1u);
  EXPECT_TRUE(shown().edited);
  ASSERT_EQ(panel_.marked_boxes(objects_).size(), 1u);
  EXPECT_NEAR(panel_.marked_boxes(objects_)[0].min().y(), 0.05, 1e-4);
  EXPECT_EQ(panel_.in_part_colours(objects_), &objects_[2]) << "the open section shows them";
  EXPECT_TRUE(panel_.shown(objects_).parts_shown);

  answer(sent(part_action(Kind::Material, 1, "down")));
  EXPECT_EQ(shown().parts[1].material, "down");
  PanelActions share = part_action(Kind::Share, 0);
  share.part_edit->share = 0.8;
  answer(sent(share));
  EXPECT_NEAR(shown().parts[1].share, 0.2, 1e-12);
  PanelActions box = part_action(Kind::MoveBox, 1);
  box.part_edit->moved.min_m = {0, 0, 0};  // open above
  answer(sent(box));
  EXPECT_FALSE(shown().parts[1].boxes[0].max_m);
  const auto marked = panel_.marked_boxes(objects_);
  ASSERT_EQ(marked.size(), 1u);
  EXPECT_EQ(marked[0].max(), body_.max());
  EXPECT_TRUE(panel_.act(part_action(Kind::Material, 1, "down"), objects_).empty()) << "no change";
}

// An edit before the answer to the last one is of what that one left.
TEST_F(ObjectPanelParts, EditsBuildOnWhatIsNotYetAnswered) {
  sent(part_action(Kind::Add, 0));
  EXPECT_EQ(sent(part_action(Kind::Name, 1, "top"))[1].name(), "top");
  EXPECT_EQ(shown().parts[1].name, "top");
  const char* why = "physics.parts[1].name: is already that of another part; give another name";
  panel_.take_refusal("pillow", why);
  EXPECT_EQ(shown().parts[1].name, "top") << "the second edit may be accepted";
  panel_.take_refusal("pillow", why);
  EXPECT_TRUE(shown().parts.empty()) << "as the server has it";
  EXPECT_TRUE(panel_.shown(objects_).messages.at(0).refusal);
}

// The stream and the replies come at any time after an edit, in this order each.
TEST_F(ObjectPanelParts, NoEditInFlightIsLost) {
  for (int order = 0; order < 20; ++order) {  // of the six messages about three edits
    SetUp();
    std::vector<MaterialParts> states;
    int streamed = 0, replied = 0;
    const auto arrive = [&](int messages) {
      for (; messages > 0; --messages) {
        const int edits = static_cast<int>(states.size());
        const bool from_stream =
            streamed < edits && (replied == edits || (order + streamed + replied) % 3 == 0);
        if (from_stream)
          stream(states[static_cast<size_t>(streamed++)]);
        else if (replied < edits)
          reply(states[static_cast<size_t>(replied++)]);
        EXPECT_TRUE(panel_.act({}, objects_).empty());
        EXPECT_TRUE(shown().parts.size() == 2) << order;
      }
    };
    states.push_back(sent(part_action(Kind::Add, 0)));
    arrive(order % 3);
    states.push_back(sent(part_action(Kind::Name, 1, "top")));
    arrive(order % 4);
    states.push_back(sent(part_action(Kind::Material, 1, "down")));
    EXPECT_EQ(states.back()[1].name(), "top") << order;
    for (int left = 6 - streamed - replied; left > 0; --left) {
      EXPECT_EQ(shown().parts[1].name, "top") << order;
      EXPECT_EQ(shown().parts[1].material, "down") << order;
      arrive(1);
    }
    // Then the stream counts: another client has changed the object.
    MaterialParts other = states.back();
    other[1].set_material("hardwood");
    stream(other);
    EXPECT_TRUE(panel_.act({}, objects_).empty());
    EXPECT_EQ(shown().parts[1].material, "hardwood") << order;
    objects_ = pillow_and_room();
    EXPECT_TRUE(panel_.act({}, objects_).empty());
  }
}

// A name that was refused is corrected before the refusal is here.
TEST_F(ObjectPanelParts, ACorrectionSurvivesARefusal) {
  answer(sent(part_action(Kind::Add, 0)));
  sent(part_action(Kind::Name, 1, shown().parts[0].name));
  const MaterialParts corrected = sent(part_action(Kind::Name, 1, "top"));
  panel_.take_refusal("pillow", "physics.parts[1].name: is already that of another part; give another name");
  EXPECT_TRUE(panel_.act({}, objects_).empty());
  EXPECT_EQ(sent(part_action(Kind::Material, 1, "down"))[1].name(), "top");
  reply(corrected);
  panel_.take_refusal("pillow", "physics.parts[1].material: is not in the table");
  EXPECT_EQ(shown().parts[1].name, "top") << "the last one that the server accepted";
  EXPECT_EQ(shown().parts[1].material, "foam");
}

TEST_F(ObjectPanelParts, EditsInFlightAreOfTheirObject) {
  sent(part_action(Kind::Add, 0));
  objects_[3] = objects_[2];
  objects_[3].id = 3;
  objects_[3].name = "cushion";
  PanelActions other = part_action(Kind::Add, 0);
  other.part_edit->object = "cushion";
  panel_.select("cushion");
  sent(other);
  v1::PhysicsReply reply;
  *reply.mutable_parameters() = objects_[3].physics;
  panel_.take_reply("cushion", reply);
  EXPECT_EQ(sent(part_action(Kind::Name, 1, "top"))[1].name(), "top");
}

// The scene file overrules the edit, or undo takes it back.
TEST_F(ObjectPanelParts, ShowsWhatTheServerDecides) {
  const MaterialParts divided = sent(part_action(Kind::Add, 0));
  answer(MaterialParts());
  EXPECT_TRUE(shown().parts.empty());
  answer(divided);
  panel_.act({}, objects_);
  answer(MaterialParts());
  EXPECT_TRUE(shown().parts.empty());
}

TEST_F(ObjectPanelParts, GoBackToTheEstimate) {
  answer(sent(part_action(Kind::Add, 0)));
  const auto calls = panel_.act(part_action(Kind::Estimate, 0), objects_);
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_EQ(std::get<RestoreEstimateCall>(calls[0]).fields, std::vector<std::string>{"parts"});
}

// The line of the facts and the rows with colours say the same.
TEST_F(ObjectPanelParts, AreListedOnce) {
  answer(sent(part_action(Kind::Add, 0)));
  const auto lines = [&] {
    const ObjectsPanel shown = panel_.shown(objects_);
    return std::count_if(shown.facts.begin(), shown.facts.end(),
                         [](const std::string& fact) { return fact.starts_with("Parts: "); });
  };
  EXPECT_EQ(lines(), 0);
  PanelActions closed;
  closed.parts_open = false;
  panel_.act(closed, objects_);
  EXPECT_EQ(lines(), 0);
  EXPECT_EQ(panel_.shown(objects_).parts.size(), 2u);
  objects_[2].rest.revision = 1;  // broken
  EXPECT_FALSE(panel_.shown(objects_).division);
  EXPECT_EQ(lines(), 1) << "without places there is no list with colours";
}

TEST(ObjectPanel, SliderReleaseIsOneCall) {
  const auto objects = pillow_and_room();
  ObjectPanel panel;
  panel.select("pillow");
  EXPECT_TRUE(panel.act({}, objects).empty());
  PanelActions actions;
  SliderRange range;
  for (const auto& [id, object] : objects) {
    if (object.name == "pillow")
      range = slider_range(SliderParameter::YoungsModulus,
                           shown_value(SliderParameter::YoungsModulus, object.physics));
  }
  actions.released = {row_of(panel.shown(objects), "Young's modulus"), slider_position(range, 5e4)};
  const auto calls = panel.act(actions, objects);
  ASSERT_EQ(calls.size(), 1u);
  const auto& set = std::get<SetPhysicsCall>(calls[0]);
  EXPECT_EQ(set.object, "pillow");
  EXPECT_DOUBLE_EQ(set.physics.youngs_modulus_pa(), 5e4);
  EXPECT_NE(panel.shown(objects).progress, "");
  v1::PhysicsReply reply;
  reply.add_warnings("behavior: it stays ELASTIC until the scene is reloaded");
  panel.take_reply("pillow", reply);
  EXPECT_EQ(panel.shown(objects).progress, "");
  ASSERT_EQ(panel.shown(objects).messages.size(), 1u);
  EXPECT_FALSE(panel.shown(objects).messages[0].refusal);
}

TEST(ObjectPanel, TypedValueIsCalledOrRefused) {
  const auto objects = pillow_and_room();
  ObjectPanel panel;
  panel.select("pillow");
  PanelActions actions;
  actions.typed = {row_of(panel.shown(objects), "Mass"), "350 g"};
  const auto calls = panel.act(actions, objects);
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_DOUBLE_EQ(std::get<SetPhysicsCall>(calls[0]).physics.mass_kg(), 0.35);
  panel.take_refusal("pillow", "physics.mass_kg: is 2e+09; it must be between 1e-06 and 1e+06");
  EXPECT_TRUE(panel.shown(objects).messages.at(0).refusal);

  actions.typed->text = "heavy";
  EXPECT_TRUE(panel.act(actions, objects).empty());
  ASSERT_EQ(panel.shown(objects).messages.size(), 1u);
  EXPECT_EQ(panel.shown(objects).messages[0].text.rfind("Mass: \"heavy\" is not a number", 0), 0u);
}

TEST(ObjectPanel, ButtonsProduceCalls) {
  const auto objects = pillow_and_room();
  ObjectPanel panel;
  PanelActions actions;
  actions.undo = actions.analyse = true;
  EXPECT_TRUE(panel.act(actions, objects).empty());  // nothing is selected
  panel.select("pillow");
  auto calls = panel.act(actions, objects);
  ASSERT_EQ(calls.size(), 2u);
  EXPECT_FALSE(std::get<UndoPhysicsCall>(calls[0]).redo);
  EXPECT_EQ(std::get<AnalyzeCall>(calls[1]).objects, std::vector<std::string>{"pillow"});
  actions = {};
  actions.analyse_all = actions.redo = true;
  calls = panel.act(actions, objects);
  ASSERT_EQ(calls.size(), 2u);
  EXPECT_TRUE(std::get<UndoPhysicsCall>(calls[0]).redo);
  EXPECT_TRUE(std::get<AnalyzeCall>(calls[1]).objects.empty());
}

TEST(ObjectPanel, ShowsAnalysisProgress) {
  const auto objects = pillow_and_room();
  ObjectPanel panel;
  panel.select("pillow");
  v1::AnalysisProgress progress;
  progress.set_object("pillow");
  progress.set_stage(v1::AnalysisProgress::ASKED);
  panel.take_progress(progress);
  EXPECT_EQ(panel.shown(objects).progress, "Analysing pillow: waiting for the model");
  progress.set_stage(v1::AnalysisProgress::FINISHED);
  progress.set_finished(1);
  progress.set_objects(2);
  progress.set_message("no endpoint is set");
  panel.take_progress(progress);
  EXPECT_EQ(panel.shown(objects).progress, "Analysed 1 of 2: pillow");
  EXPECT_EQ(panel.shown(objects).messages.at(0).text, "no endpoint is set");
  panel.take_analysis_end("");
  EXPECT_EQ(panel.shown(objects).progress, "");
}

// One line, also if the analysis was requested in this window and ended with the same text.
TEST(ObjectPanel, ShowsReviewReasonOnce) {
  auto objects = pillow_and_room();
  ObjectPanel panel;
  panel.select("pillow");
  const std::string why = "mass_g.best: 8000 g is unlikely; size and kind suggest 720 g";
  v1::AnalysisProgress progress;
  progress.set_object("pillow");
  progress.set_stage(v1::AnalysisProgress::FINISHED);
  progress.set_verdict(v1::AnalysisProgress::NEEDS_REVIEW);
  progress.set_message(why);
  panel.take_progress(progress);
  ASSERT_EQ(panel.shown(objects).messages.size(), 1u);
  EXPECT_EQ(panel.shown(objects).messages[0].text, why);
  objects[2].warnings = {"a repaired surface", "needs review: " + why};
  ASSERT_EQ(panel.shown(objects).messages.size(), 2u);
  EXPECT_EQ(panel.shown(objects).messages[1].text, "needs review: " + why);
  EXPECT_FALSE(panel.shown(objects).messages[1].refusal);
}

TEST(ObjectPanel, ProposalCanBeAccepted) {
  auto objects = pillow_and_room();
  ObjectPanel panel;
  panel.select("pillow");
  PanelActions accept, decline;
  accept.accept = true;
  decline.decline = true;
  EXPECT_TRUE(panel.act(accept, objects).empty());  // no proposal
  EXPECT_TRUE(panel.act(decline, objects).empty());
  // Independent of the client that requested it.
  v1::PhysicalParameters proposal;
  proposal.set_material("down");
  proposal.set_behavior(v1::Physics::ELASTIC);
  proposal.mutable_mass_kg()->set_low(7);
  proposal.mutable_mass_kg()->set_best(8);
  proposal.mutable_mass_kg()->set_high(9);
  objects[2].proposal = proposal;
  EXPECT_EQ(panel.shown(objects).proposal, "Proposed: 8 kg (7 to 9 kg) of down, elastic");
  auto calls = panel.act(accept, objects);
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_EQ(std::get<AcceptProposalCall>(calls[0]).object, "pillow");
  EXPECT_FALSE(std::get<AcceptProposalCall>(calls[0]).decline);
  EXPECT_EQ(panel.shown(objects).proposal, "");     // not yet confirmed by the server
  EXPECT_TRUE(panel.act(accept, objects).empty());  // only once
  panel.take_refusal("pillow", "the disk is full");
  EXPECT_NE(panel.shown(objects).proposal, "");  // still open
  calls = panel.act(decline, objects);
  ASSERT_EQ(calls.size(), 1u);
  EXPECT_TRUE(std::get<AcceptProposalCall>(calls[0]).decline);
  EXPECT_EQ(panel.shown(objects).proposal, "");
  objects[2].proposal.reset();
  EXPECT_TRUE(panel.act({}, objects).empty());
  objects[2].proposal = proposal;  // an equal proposal is a new one
  EXPECT_NE(panel.shown(objects).proposal, "");
}

}  // namespace
}  // namespace livegs
