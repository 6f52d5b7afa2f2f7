// SPDX-License-Identifier: Apache-2.0
#include "session/recording/session_recorder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <new>
#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "patience.h"
#include "recording/recording_reader.h"
#include "scene/build/fragile_object.h"
#include "scenes/box_scene.h"
#include "scratch_folder.h"
#include "server/session/simulation/tick_log.h"
#include "session/recording/recorded_files.h"
#include "session/recording/verify_recording.h"
#include "session/simulation/scene_run.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {
namespace {

// Runs ticks and records them one by one.
class RecordedRun {
 public:
  explicit RecordedRun(Scene scene) : run(std::move(scene)) {}

  void start(const std::filesystem::path& path, const RecordingOptions& options = {}) {
    const auto started = recorder.start(path, options);
    ASSERT_TRUE(started) << started.error().message;
  }
  TickResult advance(const TickActions& actions = {}) {
    TickResult tick = run.advance(actions);
    recorder.record(actions, tick, run.scene());
    return tick;
  }
  void replace(Scene scene) { run.replace(std::move(scene)); }
  v1::RecordingStatus stop() {
    auto stopped = recorder.stop();
    EXPECT_TRUE(stopped) << stopped.error().message;
    return stopped ? *stopped : v1::RecordingStatus();
  }

  AssetStore assets;
  SceneRun run;
  SessionRecorder recorder{assets};
};

// A right hand in front of the box or the cube. It rises a millimetre a tick with its trigger pressed, and
// shoots.
InputSample hand_at(uint64_t tick, double x) {
  return hand_sample(tick, {x, 0.1 + 0.001 * static_cast<double>(tick % 128), 1.0}, tick > 5 ? 1.0f : 0.0f,
                     tick % 40 == 0);
}

v1::SceneChange force_on(const std::string& object) {
  v1::SceneChange change;
  v1::Event::Force& force = *change.mutable_force();
  force.set_object(object);
  for (const double value : {0.0, 0.1, 0.1}) force.add_point_m(value);
  for (const double value : {30.0, 5.0, 0.0}) force.add_force_n(value);
  force.set_duration_s(0.2);
  return change;
}

// Every kind of action on a scene, for four seconds.
void play(RecordedRun& recorded, uint64_t ticks = 360) {
  for (uint64_t tick = 1; tick <= ticks; ++tick) {
    TickActions actions;
    actions.samples.push_back({1, {hand_at(tick, -0.5)}});
    if (tick > 20 && tick < 200) actions.samples.push_back({2, {hand_at(tick, 0.5)}});
    if (tick == 200) actions.over.push_back(2);
    if (tick == 60) actions.released.push_back(1);
    if (tick == 30) actions.changes.push_back(force_on("box"));
    if (tick == 40) {
      v1::SceneChange& change = actions.changes.emplace_back();
      change.mutable_set_physics()->set_object("cube");
      *change.mutable_set_physics()->mutable_physics() = recorded.run.scene().find("cube")->physics;
      change.mutable_set_physics()->mutable_physics()->mutable_friction()->set_best(0.9);
    }
    actions.stepped = tick < 100 || tick > 110;
    if (tick == 250) recorded.replace(box_scene(90, 0.2, 1001));
    recorded.advance(actions);
  }
}

void expect_equal(const std::filesystem::path& path, uint64_t ticks) {
  auto recording = RecordingReader::open(path);
  ASSERT_TRUE(recording) << recording.error().message;
  const auto seen = verify_recording(*recording, "");
  ASSERT_TRUE(seen) << seen.error().message;
  EXPECT_EQ(seen->ticks, ticks);
  if (seen->difference) {
    ADD_FAILURE() << "tick " << seen->difference->tick << ", " << seen->difference->object << " "
                  << seen->difference->what;
  }
}

TEST(SessionRecorder, RepeatedRunIsIdentical) {
  const ScratchFolder folder;
  RecordedRun recorded(box_scene());
  recorded.start(folder / "a.lvgrec");
  play(recorded);
  const v1::RecordingStatus status = recorded.stop();
  EXPECT_EQ(status.ticks(), 360u);
  EXPECT_TRUE(status.message().empty()) << status.message();
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->totals().resets(), 1u);
  EXPECT_EQ(recording->totals().changes(), 2u);
  EXPECT_EQ(recording->totals().inputs(), 360u + 179u);
  EXPECT_GT(recording->totals().objects_added(), 4u);  // including balls
  expect_equal(folder / "a.lvgrec", 360);
}

TEST(SessionRecorder, InputsAloneReproduceTheRun) {
  const ScratchFolder folder;
  RecordedRun recorded(box_scene());
  recorded.start(folder / "a.lvgrec", {true, false});
  play(recorded);
  recorded.stop();
  expect_equal(folder / "a.lvgrec", 360);
}

// The recording embeds all files of the scene, from its folder and from elsewhere. The originals are deleted
// before the run is repeated.
TEST(SessionRecorder, FileWithAssetsIsSelfContained) {
  const ScratchFolder folder;
  GaussianAsset ball = synthetic_asset(3000, 0, 5);
  for (size_t i = 0; i < ball.size(); ++i) {
    ball.positions[i] = ball.rotations[i].vec();  // inside a ball
    ball.log_scales[i].setConstant(-3);
    ball.opacity_logits[i] = 4;
  }
  std::filesystem::create_directories(folder / "captures/day one");
  std::filesystem::create_directories(folder / "scene/paths");
  ASSERT_TRUE(write_asset(folder / "captures/day one/ball.ply", ball));
  ASSERT_TRUE(write_asset(folder / "captures/ball.spz", ball));
  folder.write("scene/paths/up.csv", "time_s,x,y,z\n0,-0.4,0.2,0\n1,-0.4,0.6,0.2\n");
  v1::Scene file;
  file.mutable_environment()->add_colliders()->mutable_plane();
  const std::pair<const char*, std::string> placed[] = {{"left", "../captures/day one/ball.ply"},
                                                        {"right", folder / "captures/ball.spz"},
                                                        {"far", "../captures/day one/ball.ply"}};
  for (int i = 0; i < 3; ++i) {
    v1::Object& object = *file.add_objects();
    object.set_name(placed[i].first);
    object.set_asset(placed[i].second);
    object.set_scale(0.1);
    for (const double value : {-0.4 + 0.5 * i, 0.3, 0.0}) object.mutable_pose()->add_position_m(value);
    object.mutable_physics()->set_behavior(i == 1 ? v1::Physics::ELASTIC : v1::Physics::RIGID);
  }
  v1::Event& grabbed = *file.add_events();
  grabbed.set_time_s(0.1);
  grabbed.mutable_grab()->set_object("left");
  for (int i = 0; i < 3; ++i) grabbed.mutable_grab()->add_point_m(0);
  grabbed.mutable_grab()->set_path("paths/up.csv");
  auto scene = Scene::build(file, folder / "scene", "balls", {});
  ASSERT_TRUE(scene) << scene.error().message;
  {
    RecordedRun recorded(std::move(*scene));
    recorded.start(folder / "with.lvgrec", {false, true});
    for (int tick = 0; tick < 60; ++tick) recorded.advance();
    recorded.stop();
    recorded.start(folder / "without.lvgrec");
    for (int tick = 0; tick < 5; ++tick) recorded.advance();
    recorded.stop();
  }
  std::filesystem::remove_all(folder / "captures");
  std::filesystem::remove_all(folder / "scene");
  expect_equal(folder / "with.lvgrec", 60);
  auto without = RecordingReader::open(folder / "without.lvgrec");
  ASSERT_TRUE(without);
  const auto refused = verify_recording(*without, "");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::NotFound) << refused.error().message;

  // File names of a scene resolve only into the temporary folder.
  auto with = RecordingReader::open(folder / "with.lvgrec");
  ASSERT_TRUE(with);
  std::filesystem::path unpacked_at;
  {
    const auto unpacked = UnpackedFiles::unpack(*with);
    ASSERT_TRUE(unpacked) << unpacked.error().message;
    unpacked_at = unpacked->folder();
    const v1::SceneSource scene_there = unpacked->placed(with->start().scene());
    for (const v1::Object& object : scene_there.file().objects()) {
      EXPECT_EQ(object.asset().find(".."), std::string::npos) << object.asset();
      EXPECT_TRUE(std::filesystem::path(object.asset()).is_relative()) << object.asset();
      EXPECT_TRUE(std::filesystem::exists(unpacked_at / object.asset())) << object.asset();
    }
  }
  EXPECT_FALSE(std::filesystem::exists(unpacked_at));
}

// An asset that is a folder, and one that is missing when the recording starts.
TEST(RecordedFiles, ContainEveryFileOfAFolder) {
  const ScratchFolder folder;
  folder.write("thing/meta.json", "{}");
  folder.write("thing/a.webp", "a");
  folder.write("thing/notes.txt", "not of it");
  v1::SceneSource source;
  source.set_folder(folder.path());
  source.mutable_file()->add_objects()->set_asset("thing/");
  source.mutable_file()->add_objects()->set_asset("gone.ply");
  source.mutable_file()->add_objects()->set_points("thing/meta.json");
  std::set<std::string> held;
  v1::RecordingStart start;
  start.set_rate_hz(90);
  auto writer = RecordingWriter::create(folder / "a.lvgrec", start);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(embed_files(source, held, *writer));
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(held, (std::set<std::string>{"thing/a.webp", "thing/meta.json", "gone.ply"}));
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader) << reader.error().message;
  const auto unpacked = UnpackedFiles::unpack(*reader);
  ASSERT_TRUE(unpacked) << unpacked.error().message;
  const v1::SceneSource placed = unpacked->placed(source);
  EXPECT_EQ(std::filesystem::path(placed.file().objects(0).asset()).filename(), "thing");
  EXPECT_EQ(*read_text_file(unpacked->folder() / placed.file().objects(0).asset() / "a.webp"), "a");
  EXPECT_EQ(placed.file().objects(1).asset(), "gone.ply");
}

// A streamed asset has its chunks in folders of their own, a .gltf its buffers.
TEST(RecordedFiles, KeepTheFoldersOfAnAsset) {
  const ScratchFolder folder;
  folder.write("town/lod-meta.json", "{}");
  folder.write("town/0_0/meta.json", "0");
  folder.write("town/0_1/means.webp", "1");
  folder.write("town/1_0.sog", "2");
  folder.write("box/box.gltf", R"({ "buffers": [ { "uri": "data/a%20b.bin" }, { "uri": "data:x" } ] })");
  folder.write("box/data/a b.bin", "3");
  folder.write("scene/empty.json", "{}");
  v1::SceneSource source;
  source.set_folder((folder.path() / "scene").string());
  source.mutable_file()->add_objects()->set_asset("../town");
  source.mutable_file()->add_objects()->set_asset((folder.path() / "box/box.gltf").string());
  std::set<std::string> held;
  v1::RecordingStart start;
  start.set_rate_hz(90);
  auto writer = RecordingWriter::create(folder / "a.lvgrec", start);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(embed_files(source, held, *writer));
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(held.size(), 6u);
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader) << reader.error().message;
  const auto unpacked = UnpackedFiles::unpack(*reader);
  ASSERT_TRUE(unpacked) << unpacked.error().message;
  const v1::SceneSource placed = unpacked->placed(source);
  const std::filesystem::path town = unpacked->folder() / placed.file().objects(0).asset(),
                              box = unpacked->folder() / placed.file().objects(1).asset();
  EXPECT_EQ(*read_text_file(town / "0_0/meta.json"), "0");
  EXPECT_EQ(*read_text_file(town / "0_1/means.webp"), "1");
  EXPECT_EQ(*read_text_file(town / "1_0.sog"), "2");
  EXPECT_EQ(*read_text_file(box.parent_path() / "data/a b.bin"), "3");
}

TEST(SessionRecorder, FracturesAreIdentical) {
  const ScratchFolder folder;
  RecordedRun recorded(breaking_scene());
  recorded.start(folder / "a.lvgrec");
  for (int tick = 0; tick < 150; ++tick) recorded.advance();
  recorded.stop();
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->totals().breaks(), 1u);
  expect_equal(folder / "a.lvgrec", 150);
}

// Fragments computed during ticks are taken at the same tick as in the recorded run.
TEST(SessionRecorder, LateFragmentsArriveAtTheirTick) {
  const ScratchFolder folder;
  v1::Scene file = breaking_scene().file();
  file.mutable_events(0)->set_time_s(3.0);
  SceneOptions options;
  options.wait_for_pieces = false;
  auto scene = Scene::build(file, ".", "breaking", options);
  ASSERT_TRUE(scene);
  RecordedRun recorded(std::move(*scene));
  recorded.start(folder / "a.lvgrec");
  uint64_t cut_at = 0;
  for (uint64_t tick = 1; tick <= 300; ++tick) {
    // Ten seconds for the cut, for a loaded machine.
    if (tick > 20 && cut_at == 0) std::this_thread::sleep_for(std::chrono::milliseconds(40));
    if (!recorded.advance().cuts.empty()) cut_at = tick;
  }
  recorded.stop();
  EXPECT_GT(cut_at, 0u);
  expect_equal(folder / "a.lvgrec", 300);
}

// One changed bit of one input; the tick of the difference is reported.
TEST(SessionRecorder, ReportsTheTickOfADifference) {
  const ScratchFolder folder;
  const auto write = [&](const std::string& name, double nudge) {
    AssetStore assets;
    SceneRun run(box_scene());
    auto start = v1::RecordingStart();
    SessionRecorder recorder(assets);
    EXPECT_TRUE(recorder.start(folder / name));
    for (uint64_t tick = 1; tick <= 120; ++tick) {
      TickActions done, recorded;
      done.samples.push_back({1, {hand_at(tick, -0.5)}});
      recorded = done;
      if (tick == 70) recorded.samples[0].samples[0].hands[1].aim.position_m.y() += nudge;
      const TickResult stepped = run.advance(done);
      recorder.record(recorded, stepped, run.scene());
    }
    EXPECT_TRUE(recorder.stop());
  };
  write("same.lvgrec", 0.0);
  write("other.lvgrec", 1e-12);
  expect_equal(folder / "same.lvgrec", 120);
  auto recording = RecordingReader::open(folder / "other.lvgrec");
  ASSERT_TRUE(recording);
  const auto seen = verify_recording(*recording, "");
  ASSERT_TRUE(seen) << seen.error().message;
  ASSERT_TRUE(seen->difference);
  EXPECT_EQ(seen->difference->tick, 70u);
  EXPECT_EQ(seen->difference->object, "box");
}

// Inputs from before the start are part of the recording, without frames.
TEST(SessionRecorder, LateRecordingIsVerifiedFromTheFirstTick) {
  const ScratchFolder folder;
  RecordedRun recorded(box_scene());
  play(recorded, 300);
  recorded.start(folder / "a.lvgrec");
  for (int tick = 0; tick < 40; ++tick) recorded.advance();
  recorded.stop();
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->totals().first_tick(), 301u);
  EXPECT_EQ(recording->totals().ticks(), 40u);
  EXPECT_EQ(recording->totals().frames(), 40u);
  EXPECT_EQ(recording->totals().resets(), 1u);
  expect_equal(folder / "a.lvgrec", 340);
}

TEST(SessionRecorder, ReportsAnIncompleteHistory) {
  const ScratchFolder folder;
  AssetStore assets;
  SceneRun run(box_scene());
  SessionRecorder recorder(assets, 2000);
  for (uint64_t tick = 1; tick <= 60; ++tick) {
    if (tick == 50) {
      ASSERT_TRUE(recorder.start(folder / "a.lvgrec"));
    }
    TickActions actions;
    actions.samples.push_back({1, {hand_at(tick, -0.5)}});
    const TickResult stepped = run.advance(actions);
    recorder.record(actions, stepped, run.scene());
  }
  ASSERT_TRUE(recorder.stop());
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->totals().ticks(), 11u);
  const auto seen = verify_recording(*recording, "");
  ASSERT_FALSE(seen);
  EXPECT_NE(seen.error().message.find("does not contain all inputs"), std::string::npos);
}

TEST(SessionRecorder, EmbedsEachAssetOnceOnRequest) {
  const ScratchFolder folder;
  RecordedRun recorded(box_scene());
  recorded.start(folder / "a.lvgrec", {false, true});
  play(recorded, 60);
  recorded.stop();
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording);
  const auto objects = recording->seek(0);
  ASSERT_TRUE(objects);
  ASSERT_FALSE(objects->empty());
  for (const v1::ObjectDescription& object : *objects) {
    const auto held = recording->asset(object.asset_hash());
    ASSERT_TRUE(held) << held.error().message;
    EXPECT_EQ(*held, recorded.assets.find(object.asset_hash())->bytes);
  }
}

// Fault 19: the disk is full. The session continues, one line gives the reason, and the recorded part can be
// read.
TEST(SessionRecorder, FullDiskEndsOnlyTheRecording) {
  const ScratchFolder folder;
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  AssetStore assets;
  SessionRecorder recorder(assets);
  loop.record_with(recorder);
  struct rlimit kept;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &kept), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit small = kept;
  small.rlim_cur = 16000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  ASSERT_TRUE(recorder.start(folder / "a.lvgrec"));
  loop.start();
  // The cube is pulled around, so that there is data to write.
  uint64_t sent = 0;
  const bool ended = log.wait([&](const std::vector<TickResult>& ticks) {
    const std::array<InputSample, 1> sample{hand_at(++sent, 0.5)};
    loop.on_input(1, sample);
    return !recorder.status().message().empty() || ticks.size() > 2000;
  });
  setrlimit(RLIMIT_FSIZE, &kept);
  std::signal(SIGXFSZ, handler);
  ASSERT_TRUE(ended);
  const std::string why = recorder.status().message();
  EXPECT_NE(why.find("recording: ended at tick"), std::string::npos) << why;
  EXPECT_NE(why.find("a.lvgrec: cannot be written: File too large (the session continues)"),
            std::string::npos)
      << why;
  EXPECT_EQ(why.find('\n'), std::string::npos);
  const size_t before = log.ticks().size();
  EXPECT_TRUE(log.wait([&](const std::vector<TickResult>& ticks) { return ticks.size() > before + 20; }));
  const auto stopped = recorder.stop();
  if (!stopped) {
    EXPECT_NE(stopped.error().message.find("File too large"), std::string::npos);
  }
  // A new one may begin.
  EXPECT_TRUE(recorder.start(folder / "b.lvgrec"));
  loop.stop();
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_FALSE(recording->ended_in_order());
  expect_equal(folder / "a.lvgrec", recording->totals().ticks());
  EXPECT_GT(recording->totals().ticks(), 5u);
}

// The fragments of the box are encoded by the recorder thread if no other thread has done so.
TEST(SessionRecorder, OutOfMemoryEndsOnlyTheRecording) {
  const ScratchFolder folder;
  SceneRun run(breaking_scene());
  const auto pieces = run.scene().find("box")->broken->asset;
  bool is_short = true;  // used by the recorder thread once
  AssetStore assets([&](const GaussianAsset& asset) {
    if (&asset == pieces.get() && std::exchange(is_short, false)) throw std::bad_alloc();
    return encode_asset(asset);
  });
  SessionRecorder recorder(assets);
  ASSERT_TRUE(recorder.start(folder / "a.lvgrec"));
  uint64_t broken_at = 0;
  const auto advance = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const TickResult tick = run.advance({});
      if (!tick.changed.empty()) broken_at = tick.drivers.tick;
      recorder.record({}, tick, run.scene());
    }
  };
  advance(120);
  ASSERT_GT(broken_at, 1u);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (recorder.status().recording() && std::chrono::steady_clock::now() < until) std::this_thread::yield();
  const v1::RecordingStatus status = recorder.status();
  ASSERT_FALSE(status.recording());
  EXPECT_EQ(status.message(), "recording: ended at tick " + std::to_string(broken_at - 1) + ": " +
                                  std::bad_alloc().what() + " (the session continues)");
  auto recording = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_FALSE(recording->ended_in_order());
  expect_equal(folder / "a.lvgrec", broken_at - 1);
  // A new one may begin.
  ASSERT_TRUE(recorder.start(folder / "b.lvgrec"));
  advance(10);
  const auto stopped = recorder.stop();
  ASSERT_TRUE(stopped) << stopped.error().message;
  EXPECT_TRUE(stopped->message().empty()) << stopped->message();
  EXPECT_EQ(stopped->ticks(), 10u);
}

TEST(SessionRecorder, RefusesUnwritablePaths) {
  const ScratchFolder folder;
  folder.write("there.lvgrec", "kept");
  AssetStore assets;
  SessionRecorder recorder(assets);
  const auto there = recorder.start(folder / "there.lvgrec");
  ASSERT_FALSE(there);
  EXPECT_NE(there.error().message.find("already exists"), std::string::npos);
  const auto film = recorder.start(folder / "film.mp4");
  ASSERT_FALSE(film);
  EXPECT_NE(film.error().message.find("film.mp4: does not end in .lvgrec"), std::string::npos)
      << film.error().message;
  const auto nowhere = recorder.start(folder / "no/such/folder.lvgrec");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("has no folder"), std::string::npos);
  EXPECT_FALSE(recorder.stop());
  ASSERT_TRUE(recorder.start(folder / "a.lvgrec"));
  const auto twice = recorder.start(folder / "b.lvgrec");
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message.find("already in progress"), std::string::npos);
}

}  // namespace
}  // namespace livegs
