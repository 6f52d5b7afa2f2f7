// SPDX-License-Identifier: Apache-2.0
// segment, analyze and fit as jobs: all files by address, repeated, and killed at random moments.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <functional>
#include <future>
#include <map>
#include <random>
#include <thread>

#include "analysis/physics_file.h"
#include "capture/capture.h"
#include "capture/read/pose_files.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "object_store_mock.h"
#include "sample/made_room.h"
#include "scratch_folder.h"
#include "server/fit/hidden_motion.h"
#include "server/parts/part_scores.h"
#include "splat/camera_file.h"
#include "system/support/program.h"
#include "system/support/read_metrics.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int kKills = 10;
constexpr double kSpacing_m = 0.01;  // of the kernels of a small room

constexpr const char* kHall = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "ball", "shape": { "sphere": { "radius_m": 0.1 } }, "pose": { "position_m": [0, 0.1, 0] } },
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.4, 0.1, 0] } } ] })";

class JobCommands : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return mock_.url() + "/" + name; }
  void store_file(const std::string& name, const fs::path& path) {
    mock_.set(name, read_text_file(path, kMaxFileBytes).value());
  }
  void publish(const fs::path& scene, const std::string& folder) {
    Program tool({LIVEGS_TOOL, "publish", scene, "--asset-store", at(folder)});
    ASSERT_EQ(tool.wait(), 0) << tool.err();
  }
  void store_room() {
    MadeRoomOptions options;
    options.spacing_m = kSpacing_m;
    const MadeRoom room = make_room(RoomKind::Apart, options);
    ASSERT_TRUE(write_asset(folder_ / "room.ply", room.asset));
    store_file("in/room.ply", folder_ / "room.ply");
    Capture photos;
    for (const Camera& camera : orbit(room.middle_m, {0, -1, 0}, 1.1, 8, 160, 0.0, 2 * M_PI)) {
      photos.views.emplace_back().camera = camera;
      photos.views.back().picture = "v" + std::to_string(photos.views.size()) + ".png";
    }
    mock_.set("in/transforms.json", transforms_text(photos));
  }
  void store_hall() { publish(folder_.write("hall.scene.json", kHall), "in"); }
  static Words job(Words words) {
    words.insert(words.begin(), LIVEGS_TOOL);
    words.insert(words.end(), {"--threads", "1"});
    return words;
  }
  // With another folder for temporary files.
  static Words with_folder(const ScratchFolder& folder, Words words) {
    words.insert(words.begin(), {"/usr/bin/env", "TMPDIR=" + folder.path().string()});
    return words;
  }
  Words marked(Words words) const {
    words.insert(words.end(), {"--checkpoints", at("state")});
    return job(words);
  }
  // Everything but the marks.
  std::map<std::string, std::string> objects() const {
    std::map<std::string, std::string> all;
    for (const std::string& name : mock_.names()) {
      if (!name.starts_with("state/")) all[name] = mock_.get(name);
    }
    return all;
  }
  // Names of the objects that are not those given.
  std::string others_than(const std::map<std::string, std::string>& given) const {
    std::string names;
    const auto now = objects();
    for (const auto& [name, bytes] : now) {
      if (const auto found = given.find(name); found == given.end() || found->second != bytes)
        names += name + " ";
    }
    for (const auto& [name, bytes] : given) {
      if (!now.contains(name)) names += name + " ";
    }
    return names;
  }
  void reset(const std::map<std::string, std::string>& objects) {
    mock_.remove_below("");
    for (const auto& [name, bytes] : objects) mock_.set(name, bytes);
  }
  // The repetition of a finished job writes nothing.
  void expect_done(const Words& words) {
    const size_t seen = mock_.requests().size();
    Program again(words);
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_NE(again.err().find("is done already"), std::string::npos) << again.out() << again.err();
    for (const auto& all = mock_.requests(); const SeenRequest& request : std::span(all).subspan(seen))
      EXPECT_NE(request.method, "PUT") << request.path;
  }
  // Runs the job undisturbed, then killed at random moments and repeated: the store has the same bytes.
  void expect_same_bytes_after_kills(const Words& words) {
    const auto before = objects();
    const auto begun = std::chrono::steady_clock::now();
    Program whole(words);
    ASSERT_EQ(whole.wait(), 0) << whole.err();
    const auto length = std::chrono::steady_clock::now() - begun;
    const auto after = objects();
    EXPECT_GT(after.size(), before.size());
    expect_done(words);
    reset(before);
    std::mt19937 random(7);
    for (int killed = 0, runs = 0; killed < kKills; ++runs) {
      ASSERT_LT(runs, 100);
      Program job(words);
      std::this_thread::sleep_for(length * std::uniform_real_distribution<double>(0.0, 1.0)(random));
      job.send(SIGKILL);
      const int code = job.wait();
      ASSERT_TRUE(code == 128 + SIGKILL || code == 0) << code << job.err();
      killed += code == 128 + SIGKILL;
      if (code == 0) {  // it ended before the kill: from the begin again
        EXPECT_EQ(others_than(after), "");
        reset(before);
      }
    }
    Program last(words);
    ASSERT_EQ(last.wait(), 0) << last.err();
    EXPECT_EQ(others_than(after), "");
    expect_done(words);
  }
  // Runs the job and kills it at the PUT that `at` chooses. The store keeps the object. Returns the exit
  // code.
  int run_and_kill(const Words& words, const std::function<bool(const SeenRequest& put)>& at) {
    std::promise<pid_t> process;
    mock_.set_fault([&, id = process.get_future().share()](const SeenRequest& request, int) {
      if (request.method == "PUT" && at(request)) ::kill(id.get(), SIGKILL);
      return std::optional<Reply>();
    });
    Program job(words);
    process.set_value(job.process());
    const int code = job.wait();
    mock_.set_fault({});
    return code;
  }
  // As above, with a kill at each write: the store keeps the object, and the job never sees the reply.
  void expect_same_bytes_after_a_kill_at_each_write(const Words& words) {
    const auto before = objects();
    Program whole(words);
    ASSERT_EQ(whole.wait(), 0) << whole.err();
    const auto after = objects();
    reset(before);
    for (int write = 0, code = 128 + SIGKILL; code != 0; ++write) {
      std::atomic<int> seen = 0;
      code = run_and_kill(words, [&](const SeenRequest&) { return seen++ == write; });
      ASSERT_TRUE(code == 128 + SIGKILL || code == 0) << code;
      if (code == 0) EXPECT_GT(write, 2);
      Program next(words);
      ASSERT_EQ(next.wait(), 0) << next.err();
      EXPECT_EQ(others_than(after), "") << "killed at write " << write;
      reset(before);
    }
  }
  ScratchFolder folder_;
  ObjectStoreMock mock_;
};

TEST_F(JobCommands, AKilledSegmentationEndsWithTheSameBytes) {
  store_room();
  expect_same_bytes_after_kills(
      marked({"segment", at("in/room.ply"), "--cameras", at("in/transforms.json"), "-o", at("out/things")}));
}

TEST_F(JobCommands, AKilledAnalysisEndsWithTheSameBytes) {
  store_hall();
  expect_same_bytes_after_kills(
      marked({"analyze", at("in/hall.scene.json"), "--offline", "--explain", at("out/pages")}));
}

// The scene is input and output.
TEST_F(JobCommands, AKilledAnalysisThatWritesEndsWithTheSameBytes) {
  store_hall();
  expect_same_bytes_after_kills(marked({"analyze", at("in/hall.scene.json"), "--offline", "--write"}));
}

TEST_F(JobCommands, AnAnalysisIsKilledAtEachOfItsWrites) {
  store_hall();
  expect_same_bytes_after_a_kill_at_each_write(
      marked({"analyze", at("in/hall.scene.json"), "--offline", "--write"}));
}

TEST_F(JobCommands, AKilledFitEndsWithTheSameBytes) {
  HiddenMotion motion;
  motion.truth = scene_of(held_block(5e4, 0.05));
  motion.request.camera = look_at({0.2, 0.1, 0.9}, {0.03, 0, 0}, Eigen::Vector3d::UnitY(), 0.6, 320, 240);
  motion.seconds = 0.4;
  ASSERT_TRUE(write_camera_file(folder_ / "camera.json", motion.request.camera));
  ASSERT_TRUE(write_tracks_file(folder_ / "paths.csv", exact_tracks(motion, 20)));
  store_file("in/camera.json", folder_ / "camera.json");
  store_file("in/paths.csv", folder_ / "paths.csv");
  // Also an object with a file, which the fitted scene names as the scene does.
  fs::copy_file(LIVEGS_TESTS_DIR "/scenes/cup.csv", folder_ / "cup.csv");
  std::string scene = held_block(2e5, 0.05);
  const std::string objects = "\"objects\": [";
  ASSERT_NE(scene.find(objects), std::string::npos) << scene;
  scene.insert(scene.find(objects) + objects.size(),
               R"( { "name": "cup", "points": "cup.csv", "kernel_per_point": false,
                     "pose": { "position_m": [3, 0.1, 0] },
                     "physics": { "behavior": "STATIC" } }, )");
  publish(folder_.write("block.scene.json", scene), "in");
  const Words words = marked({"fit", at("in/block.scene.json"), "--tracks", at("in/paths.csv"), "--camera",
                              at("in/camera.json"), "--find", "block=youngs_modulus_pa", "-o", at("out/fit"),
                              "--every", "0"});
  expect_same_bytes_after_kills(words);
  // Killed after its first state, it continues there.
  const auto whole = JobCommands::objects();
  mock_.remove_below("out/");
  mock_.remove_below("state/");
  EXPECT_EQ(run_and_kill(words, [](const SeenRequest& put) { return put.path.ends_with(".state0"); }),
            128 + SIGKILL);
  Program next(words);
  ASSERT_EQ(next.wait(), 0) << next.err();
  EXPECT_NE(next.err().find("continuing from the checkpoint of step "), std::string::npos) << next.err();
  EXPECT_EQ(others_than(whole), "");
  EXPECT_NE(mock_.get("out/fit/fitted.scene.json").find("\"cup.csv\""), std::string::npos)
      << mock_.get("out/fit/fitted.scene.json");
}

// SIGTERM during the fetch of an input: the job does not wait for the store, and no temporary file is left.
TEST_F(JobCommands, AnEvictedFetchEndsAtOnceAndLeavesNothing) {
  store_room();
  store_hall();
  const ScratchFolder temporary;
  for (const Words& words : {Words{"segment", at("in/room.ply"), "-o", at("out/things")},
                             Words{"analyze", at("in/hall.scene.json"), "--offline"}}) {
    std::atomic<int> gets = 0;
    std::promise<void> arrived, ended;
    mock_.set_fault([&, waits = ended.get_future().share()](const SeenRequest& request, int) {
      const bool list = request.path.ends_with(".files.json");
      if (list || gets++ > 0) return std::optional<Reply>();
      arrived.set_value();
      waits.wait();
      return std::optional<Reply>();
    });
    Program evicted(with_folder(temporary, job(words)));
    arrived.get_future().wait();
    EXPECT_FALSE(fs::is_empty(temporary.path()));
    evicted.send(SIGTERM);
    EXPECT_EQ(evicted.wait(), 75) << evicted.err();
    ended.set_value();
    EXPECT_EQ(evicted.err().find("/in/"), std::string::npos) << evicted.err();  // no message of the store
    EXPECT_TRUE(fs::is_empty(temporary.path())) << words[0];
  }
}

// The files of the work vanish under it, which must not change the exit code.
TEST_F(JobCommands, AnEvictedJobLeavesNothingAtAnyMoment) {
  store_hall();
  const ScratchFolder temporary;
  const Words words = with_folder(
      temporary, job({"analyze", at("in/hall.scene.json"), "--offline", "--explain", at("out/pages")}));
  const auto begun = std::chrono::steady_clock::now();
  Program whole(words);
  ASSERT_EQ(whole.wait(), 0) << whole.err();
  EXPECT_TRUE(fs::is_empty(temporary.path()));
  const auto length = std::chrono::steady_clock::now() - begun;
  int evictions = 0;
  for (int moment = 1; moment < 8; ++moment) {
    const size_t seen = mock_.requests().size();
    Program evicted(words);
    while (mock_.requests().size() == seen) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(length * moment / 10);
    evicted.send(SIGTERM);
    const int code = evicted.wait();
    EXPECT_TRUE(code == 75 || code == 0) << code << evicted.err();
    evictions += code == 75;
    EXPECT_TRUE(fs::is_empty(temporary.path())) << moment;
  }
  EXPECT_GT(evictions, 0);
}

// The input is replaced by a shorter one while it is fetched.
TEST_F(JobCommands, AChangedInputIsFetchedFromItsBeginning) {
  store_room();
  const auto segment_to = [&](const std::string& folder) {
    Program program(
        job({"segment", at("in/room.ply"), "--cameras", at("in/transforms.json"), "-o", at(folder)}));
    EXPECT_EQ(program.wait(), 0) << program.err();
  };
  segment_to("out/first");
  const std::string before = mock_.get("in/room.ply") + std::string(100'000, 'x');
  mock_.set_fault([&](const SeenRequest& request, int index) {
    if (request.path != "/in/room.ply" || index > 0) return std::optional<Reply>();
    Reply cut;
    cut.body = before;
    cut.cut_after = before.size() - 1;
    cut.headers.push_back("ETag: " + ObjectStoreMock::etag_of(before));
    return std::optional<Reply>(cut);
  });
  segment_to("out/second");
  EXPECT_EQ(mock_.get("out/second/room.ply"), mock_.get("out/first/room.ply"));
  EXPECT_NE(mock_.get("out/first/room.ply"), "");
}

// A job that is killed between its output and its mark replaces its output; a folder of other files is
// refused.
TEST_F(JobCommands, AKilledSegmentationIntoAFolderEndsWithTheSameBytes) {
  store_room();
  const Words words =
      marked({"segment", at("in/room.ply"), "--cameras", at("in/transforms.json"), "-o", folder_ / "things"});
  EXPECT_EQ(run_and_kill(words, [](const SeenRequest& put) { return put.path.ends_with(".done"); }),
            128 + SIGKILL);
  EXPECT_TRUE(fs::exists(folder_ / "things/room.scene.json"));
  for (const std::string& name : mock_.names()) {  // the store kept the mark
    if (name.ends_with(".done")) mock_.remove_below(name);
  }
  Program next(words);
  ASSERT_EQ(next.wait(), 0) << next.err();
  EXPECT_NE(next.out().find(folder_ / "things/room.scene.json"), std::string::npos) << next.out();
  EXPECT_TRUE(fs::exists(folder_ / "things/room.scene.json"));
  EXPECT_FALSE(fs::exists(folder_ / "things/.part"));
  expect_done(words);
  Words other = words;
  other.insert(other.end(), {"--scale", "2"});
  Program refused(other);
  EXPECT_EQ(refused.wait(), 2);
  EXPECT_NE(refused.err().find("things: exists and is not empty"), std::string::npos) << refused.err();
}

// The values next to an asset and their log are inputs too.
TEST_F(JobCommands, FilesNextToAnInputBelongToTheJob) {
  MadeRoomOptions options;
  options.spacing_m = kSpacing_m;
  const std::string asset = folder_ / "room.ply";
  ASSERT_TRUE(write_asset(asset, make_room(RoomKind::Apart, options).asset));
  const Words words = marked({"analyze", asset, "--offline"});
  const auto is_done = [&] {
    Program job(words);
    EXPECT_EQ(job.wait(), 0) << job.err();
    return job.err().find("is done already") != std::string::npos;
  };
  EXPECT_FALSE(is_done());
  EXPECT_TRUE(is_done());
  folder_.write("room.physics.log", "");
  EXPECT_FALSE(is_done());
  folder_.write("rooms.physics.json", "{}");  // of another asset
  EXPECT_TRUE(is_done());
}

TEST_F(JobCommands, APresignedFolderIsRefusedBeforeTheWork) {
  store_room();
  Program refused(job({"segment", at("in/room.ply"), "-o", at("out/things") + "?signature=1"}));
  EXPECT_EQ(refused.wait(), 2);
  EXPECT_NE(refused.err().find("/out/things: is a presigned address"), std::string::npos) << refused.err();
  EXPECT_EQ(refused.err().find("signature"), std::string::npos) << refused.err();
  Program scene(job({"analyze", at("in/hall.scene.json") + "?signature=1", "--offline"}));
  EXPECT_EQ(scene.wait(), 2);
  EXPECT_NE(scene.err().find("hall.scene.json: is a presigned address"), std::string::npos) << scene.err();
}

// Messages name addresses, not the temporary files behind them.
TEST_F(JobCommands, MessagesNameTheAddresses) {
  store_room();
  Program done(
      job({"segment", at("in/room.ply"), "--cameras", at("in/transforms.json"), "-o", at("out/things")}));
  ASSERT_EQ(done.wait(), 0) << done.err();
  EXPECT_NE(done.out().find("run livegs-server " + at("out/things/room.scene.json")), std::string::npos)
      << done.out();
  mock_.set("in/bad.json", "{");
  Program failed(job({"segment", at("in/room.ply"), "--cameras", at("in/bad.json"), "-o", at("out/others")}));
  EXPECT_EQ(failed.wait(), 2);
  EXPECT_NE(failed.err().find("livegs: bad.json: "), std::string::npos) << failed.err();
  EXPECT_EQ((done.out() + failed.err()).find("livegs_job_"), std::string::npos) << done.out() << failed.err();
}

// Ctrl-C ends a job as SIGTERM does, with its own exit code.
TEST_F(JobCommands, AnInterruptedJobLeavesNothing) {
  store_room();
  const ScratchFolder temporary;
  std::promise<void> arrived, ended;
  mock_.set_fault([&, waits = ended.get_future().share()](const SeenRequest&, int index) {
    if (index > 0) return std::optional<Reply>();
    arrived.set_value();
    waits.wait();
    return std::optional<Reply>();
  });
  Program program(with_folder(temporary, job({"segment", at("in/room.ply"), "-o", at("out/things")})));
  arrived.get_future().wait();
  program.send(SIGINT);
  EXPECT_EQ(program.wait(), 128 + SIGINT) << program.err();
  ended.set_value();
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

// A proposal is part of the published scene, and a decision on it publishes the scene again.
TEST_F(JobCommands, ProposalsOfAStoredSceneAreKept) {
  const std::string scene = folder_.write("hall.scene.json", kHall);
  Program local(job({"analyze", scene, "--offline", "--write"}));
  ASSERT_EQ(local.wait(), 0) << local.err();
  const fs::path sidecar = folder_ / "hall.scene.physics.ball.json";
  auto values = read_physics_file(sidecar);
  ASSERT_TRUE(values) << values.error().message;
  v1::PhysicalParameters proposal = values->physics();
  proposal.mutable_friction()->set_best(0.123);
  proposal.mutable_friction()->set_low(0.1);
  proposal.mutable_friction()->set_high(0.2);
  ASSERT_TRUE(log_proposal(sidecar, proposal, values->analysis()));
  publish(scene, "in");
  Program accepted(job({"analyze", at("in/hall.scene.json"), "--accept", "ball"}));
  ASSERT_EQ(accepted.wait(), 0) << accepted.err();
  const std::string list = mock_.get("in/hall.files.json");
  EXPECT_NE(list.find("hall.scene.physics.ball.log"), std::string::npos) << list;
  const size_t at_path = list.find("hall.scene.physics.ball.json");
  ASSERT_NE(at_path, std::string::npos) << list;
  const size_t hash = list.find("\"sha256\": \"", at_path) + 11;
  EXPECT_NE(mock_.get("in/" + list.substr(hash, 64)).find("0.123"), std::string::npos);
}

// A job without an output file is done once it has printed its result; other values make it another job.
TEST_F(JobCommands, APrintedAnalysisIsDoneOnce) {
  MadeRoomOptions options;
  options.spacing_m = kSpacing_m;
  const std::string asset = folder_ / "room.ply";
  ASSERT_TRUE(write_asset(asset, make_room(RoomKind::Apart, options).asset));
  const Words words = marked({"analyze", asset, "--offline"});
  Program first(words);
  ASSERT_EQ(first.wait(), 0) << first.err();
  expect_done(words);
  Program again(words);
  EXPECT_EQ(again.wait(), 0);
  EXPECT_EQ(again.out(), first.out());
  EXPECT_NE(first.out(), "");
  Program writing(job({"analyze", asset, "--offline", "--write"}));
  ASSERT_EQ(writing.wait(), 0) << writing.err();
  ASSERT_TRUE(fs::exists(folder_ / "room.physics.json"));
  Program other(words);
  ASSERT_EQ(other.wait(), 0) << other.err();
  EXPECT_EQ(other.err().find("is done already"), std::string::npos) << other.err();
}

TEST_F(JobCommands, ValuesOfAnAssetAtAnAddressHaveNoPlace) {
  store_room();
  Program refused(job({"analyze", at("in/room.ply"), "--offline", "--write"}));
  EXPECT_EQ(refused.wait(), 2);
  EXPECT_NE(refused.err().find("room.ply: has no place for the values of --write"), std::string::npos)
      << refused.err();
}

// The last request of the job waits, so that the metrics show its end.
TEST_F(JobCommands, TheMetricsShowTheProgress) {
  store_room();
  store_hall();
  const auto steps_of = [&](const std::string& command, Words words, const std::string& last) {
    words.insert(words.end(), {"--metrics", "0"});
    std::promise<void> arrived, read;
    mock_.set_fault([&, waits = read.get_future().share()](const SeenRequest& request, int) {
      if (request.method != "PUT" || request.path != last) return std::optional<Reply>();
      arrived.set_value();
      waits.wait();
      return std::optional<Reply>();
    });
    Program program(job(words));
    EXPECT_TRUE(program.says("/metrics"));
    arrived.get_future().wait();
    const auto values = metrics_at(metrics_port_in(program.err()));
    read.set_value();
    EXPECT_EQ(program.wait(), 0) << program.err();
    mock_.set_fault({});
    return std::pair(values.at("livegs_job_steps_done{command=\"" + command + "\"}"),
                     values.at("livegs_job_steps{command=\"" + command + "\"}"));
  };
  EXPECT_EQ(
      steps_of("segment",
               {"segment", at("in/room.ply"), "--cameras", at("in/transforms.json"), "-o", at("out/things")},
               "/out/things/room.scene.json"),
      std::pair(1000.0, 1000.0));
  EXPECT_EQ(steps_of("analyze", {"analyze", at("in/hall.scene.json"), "--offline", "--write"},
                     "/in/hall.files.json"),
            std::pair(2.0, 2.0));
}

}  // namespace
}  // namespace livegs
