// SPDX-License-Identifier: Apache-2.0
// Commands as jobs: inputs and outputs by address, and processes that are killed.
#include <gtest/gtest.h>
#include <zip.h>

#include <atomic>
#include <csignal>
#include <random>
#include <thread>

#include "common/train/run/small_capture.h"
#include "core/file.h"
#include "object_store_mock.h"
#include "scratch_folder.h"
#include "splat/image.h"
#include "system/support/program.h"
#include "system/support/read_metrics.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr int kRetryExitCode = 75;

class Jobs : public ::testing::Test {
 protected:
  void SetUp() override {
    write_small_capture(folder_ / "photos");
    int error = 0;
    zip_t* zip = zip_open((folder_ / "photos.zip").c_str(), ZIP_CREATE, &error);
    ASSERT_NE(zip, nullptr);
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "photos")) {
      if (!entry.is_regular_file()) continue;
      zip_source_t* source = zip_source_file(zip, entry.path().c_str(), 0, -1);
      ASSERT_GE(zip_file_add(zip, entry.path().lexically_relative(folder_.path()).c_str(), source, 0), 0);
    }
    ASSERT_EQ(zip_close(zip), 0);
    mock_.set("in/photos.zip", read_text_file(folder_ / "photos.zip").value());
  }
  // The same training, with all files in the store.
  std::vector<std::string> words(const std::string& steps = "60", std::vector<std::string> more = {}) const {
    std::vector<std::string> all{LIVEGS_TOOL,
                                 "train",
                                 mock_.url() + "/in/photos.zip",
                                 "-o",
                                 mock_.url() + "/out/room.ply",
                                 "--kernels",
                                 "300",
                                 "--steps",
                                 steps,
                                 "--size",
                                 "64",
                                 "--every",
                                 "5",
                                 "--threads",
                                 "1",
                                 "--checkpoints",
                                 mock_.url() + "/state"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  ScratchFolder folder_;
  ObjectStoreMock mock_;
};

TEST_F(Jobs, AKilledTrainingEndsWithTheSameBytes) {
  Program whole({LIVEGS_TOOL, "train", folder_ / "photos", "-o", folder_ / "whole.ply", "--kernels", "300",
                 "--steps", "60", "--size", "64", "--every", "5", "--threads", "1"});
  const auto begun = std::chrono::steady_clock::now();
  ASSERT_EQ(whole.wait(), 0) << whole.err();
  const auto length = std::chrono::steady_clock::now() - begun;
  std::mt19937 random(7);
  int killed = 0, continued = 0;
  for (int runs = 0; killed < 10; ++runs) {
    ASSERT_LT(runs, 100);
    Program job(words());
    // At once, or within a tenth of the training after one or two more states are stored.
    if (const int states = std::uniform_int_distribution(0, 2)(random))
      (void)job.says_often(" held-out photos, ", states);
    std::this_thread::sleep_for(length * std::uniform_real_distribution<double>(0.0, 0.1)(random));
    job.send(SIGKILL);
    const int code = job.wait();
    ASSERT_TRUE(code == 128 + SIGKILL || code == 0) << code << job.err();
    killed += code == 128 + SIGKILL;
    continued += job.err().find("continuing from the checkpoint of step ") != std::string::npos;
    if (code == 0) {  // it ended before the tenth kill: from the begin again
      EXPECT_EQ(mock_.get("out/room.ply"), read_text_file(folder_ / "whole.ply").value());
      mock_.remove_below("state/");
      mock_.remove_below("out/");
    }
  }
  EXPECT_GT(continued, 0);
  Program last(words());
  ASSERT_EQ(last.wait(), 0) << last.err();
  EXPECT_EQ(mock_.get("out/room.ply"), read_text_file(folder_ / "whole.ply").value());
  EXPECT_EQ(mock_.get("out/room.png"), read_text_file(folder_ / "whole.png").value());
  const size_t requests = mock_.requests().size();
  Program again(words());
  EXPECT_EQ(again.wait(), 0) << again.err();
  EXPECT_NE(again.err().find("is done already"), std::string::npos) << again.err();
  for (const auto& all = mock_.requests(); const SeenRequest& request : std::span(all).subspan(requests))
    EXPECT_NE(request.method, "PUT") << request.path;
}

TEST_F(Jobs, AnEvictedTrainingKeepsItsStateAndContinues) {
  Program evicted(words("100000", {"--metrics", "0"}));
  ASSERT_TRUE(evicted.says_often(" held-out photos, ", 2)) << evicted.err();
  const auto values = metrics_at(metrics_port_in(evicted.err()));
  EXPECT_EQ(values.at("livegs_job_steps{command=\"train\"}"), 100'000);
  EXPECT_GE(values.at("livegs_job_checkpoint_step{command=\"train\"}"), 5);
  EXPECT_GE(values.at("livegs_job_steps_done{command=\"train\"}"), 10);
  evicted.send(SIGTERM);
  EXPECT_EQ(evicted.wait(), kRetryExitCode) << evicted.err();
  EXPECT_EQ(mock_.get("out/room.ply"), "");
  Program next(words("100000"));
  ASSERT_TRUE(next.says("continuing from the checkpoint of step ")) << next.err();
  next.send(SIGTERM);
  EXPECT_EQ(next.wait(), kRetryExitCode);
}

TEST_F(Jobs, AnInterruptedTrainingStoresItsSplat) {
  Program interrupted(words("100000"));
  ASSERT_TRUE(interrupted.says_often(" held-out photos, ", 2)) << interrupted.err();
  interrupted.send(SIGINT);
  EXPECT_EQ(interrupted.wait(), 128 + SIGINT) << interrupted.err();
  EXPECT_NE(interrupted.out().find("; the same command continues"), std::string::npos) << interrupted.out();
  EXPECT_NE(mock_.get("out/room.ply"), "");
  for (const std::string& name : mock_.names()) EXPECT_FALSE(name.ends_with(".done")) << name;
}

// The mark has the hash of each output: another object of the same size is not the output.
TEST_F(Jobs, AnotherObjectInItsPlaceIsNotTheOutput) {
  Program first(words());
  ASSERT_EQ(first.wait(), 0) << first.err();
  const std::string whole = mock_.get("out/room.ply");
  std::string other = whole;
  other.back() ^= 1;
  mock_.set("out/room.ply", other);
  Program again(words());
  ASSERT_EQ(again.wait(), 0) << again.err();
  EXPECT_EQ(again.err().find("is done already"), std::string::npos) << again.err();
  EXPECT_EQ(mock_.get("out/room.ply"), whole);
}

// A presigned output: the picture next to it has no signature and is not stored.
TEST_F(Jobs, APresignedOutputIsStored) {
  mock_.set_fault([](const SeenRequest& request, int) {
    std::optional<Reply> refused;
    if (request.method == "PUT" && request.path.find("/out/") == 0 &&
        request.path.find("?signature=1") == std::string::npos)
      refused.emplace().status = 403;
    return refused;
  });
  auto presigned = words();
  presigned[4] += "?signature=1";
  Program job(presigned);
  ASSERT_EQ(job.wait(), 0) << job.err();
  EXPECT_NE(mock_.get("out/room.ply?signature=1"), "");
  EXPECT_NE(job.err().find("/out/room.png: is not stored"), std::string::npos) << job.err();
  Program again(presigned);
  EXPECT_EQ(again.wait(), 0) << again.err();
  EXPECT_NE(again.err().find("is done already"), std::string::npos) << again.err();
}

// Photos outside the folder of the poses belong to the job.
TEST_F(Jobs, PhotosElsewhereBelongToTheJob) {
  const fs::path poses = folder_ / "poses/cams.json";
  fs::create_directories(poses.parent_path());
  std::string text = read_text_file(folder_ / "photos/transforms.json").value();
  for (size_t at = 0; (at = text.find("\"file_path\"", at)) != std::string::npos; at += 20) {
    const size_t quote = text.find('"', text.find(':', at));
    text.insert(quote + 1, "../photos/");
  }
  folder_.write("poses/cams.json", text);
  auto local = words("5");
  local[2] = poses;
  const auto is_done = [&] {
    Program job(local);
    EXPECT_EQ(job.wait(), 0) << job.err();
    return job.err().find("is done already") != std::string::npos;
  };
  EXPECT_FALSE(is_done());
  EXPECT_TRUE(is_done());
  fs::path photo;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "photos")) {
    if (entry.path().extension() == ".png" && (photo.empty() || entry.path() < photo)) photo = entry.path();
  }
  Image picture = read_png(photo).value();
  picture.pixels[0] = 1.0f - picture.pixels[0];
  ASSERT_TRUE(write_png(photo, picture));
  EXPECT_FALSE(is_done());
}

// A short outage while a state is stored does not end the training.
TEST_F(Jobs, ATrainingSurvivesAStateThatIsNotStored) {
  std::atomic<bool> refused = false;
  mock_.set_fault([&](const SeenRequest& request, int) {
    std::optional<Reply> reply;
    if (request.method != "PUT" || request.path.find(".state") == std::string::npos || refused) return reply;
    refused = true;
    reply.emplace().status = 503;
    reply->headers.push_back("Retry-After: 60");  // longer than the patience: reported at once
    return reply;
  });
  Program job(words());
  ASSERT_EQ(job.wait(), 0) << job.err();
  EXPECT_TRUE(refused);
  EXPECT_NE(mock_.get("out/room.ply"), "");
}

TEST_F(Jobs, InputsThatNameOtherFilesAreRefused) {
  const std::string file = folder_.write("hat.scene.json", "{}");
  Program job({LIVEGS_TOOL, "analyze", file, "--offline", "--checkpoints", mock_.url() + "/state"});
  EXPECT_EQ(job.wait(), 2);
  EXPECT_NE(job.err().find("hat.scene.json: names other files"), std::string::npos) << job.err();
}

TEST_F(Jobs, ADamagedStateIsNotUsed) {
  Program evicted(words("100000"));
  ASSERT_TRUE(evicted.says_often(" held-out photos, ", 3)) << evicted.err();
  evicted.send(SIGKILL);
  (void)evicted.wait();
  size_t states = 0;
  for (const std::string& name : mock_.names()) {
    if (name.find(".state") == std::string::npos) continue;
    const std::string bytes = mock_.get(name);
    if (states++ == 0) mock_.set(name, bytes.substr(0, bytes.size() / 2));
  }
  ASSERT_EQ(states, 2u);
  Program next(words("100000"));
  ASSERT_TRUE(next.says("is damaged; the state before it is used")) << next.err();
  ASSERT_TRUE(next.says("continuing from the checkpoint of step ")) << next.err();
}

TEST_F(Jobs, ExitCodesSayWhetherToTryAgain) {
  const auto code_with = [&](int status) {
    mock_.set_fault([status](const SeenRequest&, int) {
      Reply reply;
      reply.status = status;
      reply.headers.push_back("Retry-After: 60");  // longer than the patience: reported at once
      return std::optional<Reply>(reply);
    });
    Program job(words());
    const int code = job.wait();
    EXPECT_NE(job.err().find("/in/photos.zip: "), std::string::npos) << job.err();
    return code;
  };
  EXPECT_EQ(code_with(404), 2);
  EXPECT_EQ(code_with(403), 2);
  EXPECT_EQ(code_with(503), kRetryExitCode);
  mock_.set_fault({});
  mock_.set("in/photos.zip", "no archive");
  Program damaged(words());
  EXPECT_EQ(damaged.wait(), 2) << damaged.err();
}

}  // namespace
}  // namespace livegs
