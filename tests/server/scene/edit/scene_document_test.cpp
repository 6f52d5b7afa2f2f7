// SPDX-License-Identifier: GPL-3.0-or-later
// The document of authors: edits, the log of steps, the journal and saving.
#include "scene/edit/scene_document.h"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

using google::protobuf::util::MessageDifferencer;

constexpr const char* kTwo = R"({ "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [ { "name": "cup", "shape": { "box": { "size_m": [0.1, 0.1, 0.1] } } },
               { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } } } ],
  "events": [ { "time_s": 1, "force": { "object": "cup", "point_m": [0, 0, 0], "force_n": [1, 0, 0],
                                        "duration_s": 1 } } ] })";

Result<ObjectMeasures> no_measure(const v1::Object&) { return invalid_argument("measure: not expected"); }

class Documents : public ::testing::Test {
 protected:
  SceneDocument open(const std::string& file = "two.scene.json") {
    auto text = read_scene(folder_ / file);
    EXPECT_TRUE(text) << text.error().message;
    auto document = SceneDocument::open(*text);
    EXPECT_TRUE(document) << document.error().message;
    return *document;
  }
  // Applies a request as a step.
  Result<std::vector<std::string>> edit(SceneDocument& document, const v1::EditSceneRequest& request) {
    std::vector<std::string> names;
    auto step = document.prepare(request, no_measure, names);
    if (!step) return step.error();
    EXPECT_EQ(document.commit(*step), "");
    return names;
  }
  static v1::EditSceneRequest moved(const std::string& name, double x) {
    v1::EditSceneRequest request;
    v1::ObjectEdit& edit = *request.add_objects();
    edit.set_object(name);
    for (const double coordinate : {x, 0.5, 0.0})
      edit.mutable_value()->mutable_pose()->add_position_m(coordinate);
    edit.add_fields("pose");
    return request;
  }
  static v1::EditSceneRequest with(const std::string& name,
                                   const std::function<void(v1::ObjectEdit&)>& change) {
    v1::EditSceneRequest request;
    request.add_objects()->set_object(name);
    change(*request.mutable_objects(0));
    return request;
  }
  v1::SceneDocument described(const SceneDocument& document) {
    v1::SceneDocument message;
    document.describe(message);
    return message;
  }

  ScratchFolder folder_;
  std::filesystem::path scene_ = folder_.write("two.scene.json", kTwo);
};

TEST_F(Documents, StepsAreUndoneAndRedoneInOrder) {
  SceneDocument document = open();
  const v1::Scene first = document.scene();
  ASSERT_TRUE(edit(document, moved("cup", 1)));
  ASSERT_TRUE(edit(document, moved("box", 2)));
  const v1::Scene last = document.scene();
  EXPECT_EQ(described(document).undo(), "move box");
  document.take(false);
  document.take(false);
  EXPECT_TRUE(MessageDifferencer::Equals(document.scene(), first));
  EXPECT_EQ(document.next(false), nullptr);
  EXPECT_EQ(described(document).redo(), "move cup");
  document.take(true);
  document.take(true);
  EXPECT_TRUE(MessageDifferencer::Equals(document.scene(), last));
  document.take(false);
  ASSERT_TRUE(edit(document, moved("cup", 3)));
  EXPECT_EQ(document.next(true), nullptr) << "a new step forgets what was undone";
}

TEST_F(Documents, FieldsKeepWhatOthersWrote) {
  SceneDocument document = open();
  ASSERT_TRUE(edit(document, moved("cup", 1)));
  ASSERT_TRUE(edit(document, with("cup", [](v1::ObjectEdit& edit) {
                     edit.mutable_value()->set_label("marble bust");
                     edit.add_fields("label");
                   })));
  ASSERT_TRUE(edit(document, with("cup", [](v1::ObjectEdit& edit) {
                     edit.mutable_value()->mutable_physics()->set_behavior(v1::Physics::RIGID);
                     edit.add_fields("physics.behavior");
                   })));
  const v1::Object& cup = document.scene().objects(0);
  EXPECT_EQ(cup.pose().position_m(0), 1);
  EXPECT_EQ(cup.label(), "marble bust");
  EXPECT_EQ(cup.physics().behavior(), v1::Physics::RIGID);
  ASSERT_TRUE(edit(document, with("cup", [](v1::ObjectEdit& edit) { edit.add_fields("label"); })));
  EXPECT_EQ(document.scene().objects(0).label(), "") << "a field that is left out is cleared";
}

TEST_F(Documents, NamesStayUniqueAndReferencesFollow) {
  SceneDocument document = open();
  const auto renamed = edit(document, with("cup", [](v1::ObjectEdit& edit) {
                              edit.mutable_value()->set_name("box");
                              edit.add_fields("name");
                            }));
  ASSERT_TRUE(renamed);
  EXPECT_EQ(renamed->at(0), "box 2");
  EXPECT_EQ(document.scene().events(0).force().object(), "box 2");
  v1::EditSceneRequest copy;
  copy.add_objects()->set_copy_of("box 2");
  ASSERT_EQ(edit(document, copy).value().at(0), "box 3");
}

TEST_F(Documents, RefusesWhatCannotBe) {
  SceneDocument document = open();
  const auto refusal = [&](const v1::EditSceneRequest& request) {
    const auto done = edit(document, request);
    return done ? "accepted" : done.error().message;
  };
  EXPECT_EQ(refusal(with("cup", [](v1::ObjectEdit& edit) { edit.set_remove(true); })),
            "object \"cup\": is named by events[0] of the scene; remove that first");
  EXPECT_EQ(refusal(moved("jug", 1)), "object: \"jug\" is not in the scene; it may have been deleted");
  EXPECT_EQ(refusal(with("cup", [](v1::ObjectEdit& edit) { edit.add_fields("weight"); })),
            "object \"cup\": fields: \"weight\" is not a field of an object; see Object in scene.proto");
  EXPECT_EQ(refusal({}), "edit: changes nothing; give the fields to set");
  EXPECT_NE(refusal(moved("cup", INFINITY)).find("pose.position_m"), std::string::npos);
  EXPECT_EQ(document.revision(), 1u) << "a refused edit is no step";

  ASSERT_TRUE(edit(document, with("box", [](v1::ObjectEdit& edit) {
                     edit.mutable_value()->set_locked(true);
                     edit.add_fields("locked");
                   })));
  EXPECT_EQ(refusal(moved("box", 1)), "object \"box\": is locked; unlock it first");
  EXPECT_TRUE(edit(document, with("box", [](v1::ObjectEdit& edit) { edit.add_fields("locked"); })));
  EXPECT_TRUE(edit(document, moved("box", 1)));
}

TEST_F(Documents, TheJournalKeepsEveryStepUntilASave) {
  v1::Scene last;
  {
    SceneDocument document = open();
    ASSERT_TRUE(edit(document, moved("cup", 0.1 + 0.2)));
    ASSERT_TRUE(edit(document, moved("box", 1.0 / 3.0)));
    last = document.scene();
  }  // as if the server was killed
  SceneDocument again = open();
  EXPECT_TRUE(MessageDifferencer::Equals(again.scene(), last)) << "to the bit";
  EXPECT_TRUE(again.unsaved());
  EXPECT_EQ(described(again).undo(), "changes of the last run");
  ASSERT_TRUE(again.save("", false));
  EXPECT_FALSE(again.unsaved());
  const SceneDocument saved = open();
  EXPECT_FALSE(saved.unsaved());
  EXPECT_TRUE(MessageDifferencer::Equals(saved.scene(), last));
  EXPECT_EQ(read_text_file(folder_ / "two.scene.json.bak").value(), kTwo) << "comments and layout are kept";
}

TEST_F(Documents, SavesOnlyIntoTheFolder) {
  SceneDocument document = open();
  for (const char* bad : {"../other", "/tmp/other", ".hidden", "a/b.scene.json"}) {
    const auto saved = document.save(bad, false);
    ASSERT_FALSE(saved) << bad;
    EXPECT_NE(saved.error().message.find("is not a plain file name"), std::string::npos);
  }
  folder_.write("there.scene.json", "{}");
  EXPECT_EQ(document.save("there", false).error().message,
            "file: there.scene.json exists; replace it, or give another name");
  EXPECT_EQ(document.save("fresh", false).value(), "fresh.scene.json");
  EXPECT_EQ(described(document).file(), "fresh.scene.json");
}

TEST_F(Documents, SeesThatAnotherProgramChangedTheFile) {
  SceneDocument document = open();
  EXPECT_FALSE(document.changed_on_disk());
  folder_.write("two.scene.json", R"({ "objects": [] })");
  std::filesystem::last_write_time(scene_,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(2));
  EXPECT_TRUE(document.changed_on_disk());
  EXPECT_EQ(document.save("", false).error().message,
            "file: two.scene.json was changed by another program; replace it, or save under another name");
  EXPECT_TRUE(document.save("", true));
}

TEST(SceneEdits, BetweenTwoScenesAreFewest) {
  v1::Scene before, after;
  for (const char* name : {"a", "b", "c"}) before.add_objects()->set_name(name);
  after = before;
  EXPECT_TRUE(edits_between(before, after, {}).empty());
  after.mutable_objects(1)->set_name("d");  // renamed
  after.mutable_objects(2)->set_hidden(true);
  const auto edits = edits_between(before, after, {{"b", "d"}});
  ASSERT_EQ(edits.size(), 2u);
  EXPECT_EQ(edits[0].object(), "b");
  EXPECT_EQ(edits[0].after().name(), "d");
  EXPECT_EQ(edits[1].object(), "c");
  after.mutable_objects()->DeleteSubrange(0, 1);
  after.add_objects()->set_name("e");
  const auto more = edits_between(before, after, {{"b", "d"}});
  ASSERT_GE(more.size(), 3u);
  EXPECT_FALSE(more[0].has_after()) << "removals come first";
}

}  // namespace
}  // namespace livegs
