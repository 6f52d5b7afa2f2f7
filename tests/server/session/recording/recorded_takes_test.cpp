// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of sessions in which things of a captured room are taken out of it and put back.
#include "recording/recording_reader.h"
#include "server/session/live/taken_room.h"
#include "session/recording/session_recorder.h"
#include "session/recording/verify_recording.h"
#include "session/simulation/scene_run.h"

namespace livegs {
namespace {

class RecordedTakes : public TakenRoom {
 protected:
  // Takes what the rays meet.
  TickActions take(const v1::TakePartRequest& request, const std::string& name) {
    TickActions actions;
    auto out = things_->take(under(request), environment_);
    if (!out) {
      ADD_FAILURE() << out.error().message;
      return actions;
    }
    environment_ = out->environment;
    *actions.changes.emplace_back().mutable_environment() = environment_;
    out->object.set_name(name);
    *actions.changes.emplace_back().mutable_edit()->mutable_after() = out->object;
    label_ = out->object.part();
    return actions;
  }
  TickActions put_back(const std::string& name) {
    TickActions actions;
    for (int i = 0; i < 2400 && things_->describe(environment_).state() == v1::RoomParts::PREPARING; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    auto back = things_->put_back(label_, environment_);
    if (!back) {
      ADD_FAILURE() << back.error().message;
      return actions;
    }
    environment_ = *back;
    *actions.changes.emplace_back().mutable_environment() = environment_;
    actions.changes.emplace_back().mutable_edit()->set_object(name);
    return actions;
  }
  uint32_t label_ = 0;
};

// The recording starts after the first take, which is in its history. The files of the room are gone when it
// is simulated again.
TEST_F(RecordedTakes, AreSimulatedAgainFromTheRecordingAlone) {
  environment_.set_collide(true);
  v1::Scene file;
  *file.mutable_environment() = environment_;
  things_ = ready();
  auto scene = Scene::build(file, folder_.path(), "desk.scene.json", {});
  ASSERT_TRUE(scene) << scene.error().message;
  AssetStore assets;
  SceneRun run(std::move(*scene));
  SessionRecorder recorder(assets);
  const ScratchFolder recordings;
  RecordingOptions options;
  options.assets = true;
  const auto advance = [&](const TickActions& actions, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const TickActions one = i == 0 ? actions : TickActions();
      const TickResult tick = run.advance(one);
      recorder.record(one, tick, run.scene());
    }
  };
  advance({}, 3);
  v1::TakePartRequest carton, cube, part;
  aim(carton, 0, {0.5, 0.5, 1}, false);
  advance(take(carton, "thing a"), 10);
  EXPECT_EQ(run.scene().file().objects_size(), 1);
  ASSERT_TRUE(recorder.start(recordings / "takes.lvgrec", options));
  advance(put_back("thing a"), 5);
  EXPECT_EQ(run.scene().file().objects_size(), 0);
  aim(cube, 4, {0.5, 0.5, 1}, false);
  advance(take(cube, "thing b"), 10);
  aim(part, 0, {0.5, 0.2, 1}, false);
  aim(part, 0, {0.5, 1, 0.5}, true);
  advance(take(part, "thing c"), 10);
  EXPECT_EQ(run.scene().file().objects_size(), 2);
  ASSERT_TRUE(recorder.stop());
  things_.reset();
  std::filesystem::remove_all(folder_.path());
  auto recording = RecordingReader::open(recordings / "takes.lvgrec");
  ASSERT_TRUE(recording) << recording.error().message;
  const auto seen = verify_recording(*recording, "");
  ASSERT_TRUE(seen) << seen.error().message;
  EXPECT_EQ(seen->ticks, 38u);
  if (seen->difference)
    ADD_FAILURE() << "tick " << seen->difference->tick << ", " << seen->difference->object << " "
                  << seen->difference->what;
}

}  // namespace
}  // namespace livegs
