// SPDX-License-Identifier: Apache-2.0
// A scene in a store: published, served by a server that has no copy, and fetched by clients from the store.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>
#include <span>

#include "core/content_hash.h"
#include "object_store_mock.h"
#include "patience.h"
#include "system/programs/programs_fixture.h"
#include "system/support/read_metrics.h"

namespace livegs {
namespace {

// A cup in a folder above the scene, a box, and a path of a hand.
constexpr const char* kStoredScene = R"({ // a comment
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "cup", "points": "../things/cup.csv", "kernel_per_point": false, "pose": { "position_m": [0, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 0.3, "fill": "SOLID" } },
    { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0.4, 0.1, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })";

class AssetStores : public Programs {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "things");
    std::filesystem::copy_file(LIVEGS_TESTS_DIR "/scenes/cup.csv", folder_ / "things/cup.csv");
    scene_ = folder_.write("rooms/hall.scene.json", kStoredScene);
  }
  void publish() {
    Program tool({LIVEGS_TOOL, "publish", scene_, "--asset-store", mock_.url()});
    ASSERT_EQ(tool.wait(), 0) << tool.err();
    ASSERT_NE(tool.out().find("hall.scene.json"), std::string::npos) << tool.out();
  }
  // A server of the published scene; nothing of the scene is left on this machine.
  std::vector<std::string> stored_server(const std::string& scene, std::vector<std::string> more = {}) {
    std::filesystem::remove_all(folder_ / "things");
    std::filesystem::remove_all(folder_ / "rooms");
    std::vector<std::string> words = {
        LIVEGS_SERVER, scene, "--listen", "127.0.0.1:0", "--print-port", "--threads", "1", "--metrics", "0"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::set<std::string> assets_requested() const {
    std::set<std::string> all;
    for (const SeenRequest& request : mock_.requests()) {
      if (request.method == "GET" && request.path.starts_with("/assets/")) all.insert(request.path);
    }
    return all;
  }
  // Bytes of assets that the server itself has sent.
  static double sent_by(Program& server) {
    EXPECT_TRUE(server.says("/metrics"));
    return metrics_at(metrics_port_in(server.err())).at("livegs_asset_bytes_total");
  }
  std::string scene_;
  ObjectStoreMock mock_;
  std::map<std::string, std::string> objects_;  // as published, by path
};

TEST_F(AssetStores, SignalEndsAFetchAndLeavesNoFiles) {
  publish();
  std::atomic<bool> asked{false};
  mock_.set_fault([&](const SeenRequest& request, int) -> std::optional<Reply> {
    if (request.path.ends_with(".json")) return std::nullopt;
    asked = true;
    Reply silent;
    silent.body = "bytes";
    silent.hang = true;
    silent.cut_after = 1;
    return silent;
  });
  std::filesystem::create_directories(folder_ / "temporary");
  auto words = stored_server(mock_.url() + "/hall.scene.json");
  words.insert(words.begin(), {"/usr/bin/env", "TMPDIR=" + (folder_ / "temporary").string()});
  Program server(words);
  ASSERT_TRUE(wait_until([&] { return asked.load(); }));
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_NE(server.err().find("server: shutting down: stopped by a signal"), std::string::npos)
      << server.err();
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "temporary"));
}

TEST_F(AssetStores, AServerStartsFromTheStoreAndClientsFetchThere) {
  publish();
  const size_t objects = mock_.names().size();
  const size_t written = mock_.requests().size();
  publish();  // again: nothing is written but the scene and its list
  EXPECT_EQ(mock_.names().size(), objects);
  const auto all = mock_.requests();
  EXPECT_EQ(std::count_if(all.begin() + static_cast<long>(written), all.end(),
                          [](const SeenRequest& request) { return request.method == "PUT"; }),
            2);
  Program server(stored_server(mock_.url() + "/hall.scene.json"));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  Program client(client_words(port, {"--seconds", "60", "--no-video", "--every", "0"}));
  // Cup, box, floor and the cup's fragments, which follow while the scene already moves.
  EXPECT_TRUE(wait_until([&] { return assets_requested().size() >= 4; }));
  ASSERT_TRUE(client.says("first picture: ")) << client.err();
  client.send(SIGINT);
  ASSERT_EQ(client.wait(), 0) << client.err();
  EXPECT_EQ(client.err().find("fetching it from the server"), std::string::npos) << client.err();
  EXPECT_GT(ticks_of("view").size(), 0u);
  EXPECT_EQ(assets_requested().size(), 4u);
  EXPECT_EQ(sent_by(server), 0);  // no byte of an asset crosses the simulation's machine
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(AssetStores, ClientsFetchFromTheServerWhenTheStoreFails) {
  publish();
  Program server(stored_server(mock_.url() + "/hall.scene.json"));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const auto faulty = [&](const std::string& name, Reply reply) {
    mock_.set_fault([=](const SeenRequest&, int) { return std::optional<Reply>(reply); });
    std::filesystem::remove_all(folder_ / "cache");
    Program client(client_words(port, {"--seconds", "0.2", "--no-video", "--every", "0"}, "view_" + name));
    EXPECT_EQ(client.wait(), 0) << name << client.err();
    EXPECT_NE(client.err().find("fetching it from the server"), std::string::npos) << name << client.err();
    EXPECT_GT(ticks_of("view_" + name).size(), 0u) << name;
  };
  Reply refused, failing, wrong, cut;
  refused.status = 403;
  failing.status = 503;
  wrong.body = std::string(300, 'x');
  cut.body = std::string(3000, 'x');
  cut.cut_after = 10;
  faulty("refused", refused);
  EXPECT_GT(sent_by(server), 0);
  faulty("failing", failing);
  faulty("wrong", wrong);
  faulty("cut", cut);
}

// Each first reply for an object is cut, slow or a temporary failure; then one refuses, and one is down.
TEST_F(AssetStores, AServerStartsFromAFaultyStoreOrSaysWhy) {
  publish();
  Reply failing, refused;
  failing.status = 503;
  refused.status = 403;
  const auto first_replies = [&](const std::function<std::optional<Reply>(std::string body)>& fault) {
    mock_.set_fault([&, fault](const SeenRequest& request, int index) {
      return index > 0 || request.method != "GET" ? std::nullopt : fault(objects_.at(request.path));
    });
    Program server(stored_server(mock_.url() + "/hall.scene.json"));
    EXPECT_NE(server.first_line(), "") << server.err();
    server.send(SIGTERM);
    EXPECT_EQ(server.wait(), 0) << server.err();
  };
  for (const std::string& name : mock_.names()) objects_["/" + name] = mock_.get(name);
  first_replies([&](const std::string&) { return std::optional<Reply>(failing); });
  first_replies([](std::string body) {
    std::optional<Reply> cut(std::in_place);
    cut->cut_after = body.size() / 2;
    cut->headers.push_back("ETag: " + ObjectStoreMock::etag_of(body));
    cut->body = std::move(body);
    return cut;
  });
  first_replies([](std::string body) {
    std::optional<Reply> slow(std::in_place);
    slow->piece_bytes = body.size() / 4 + 1;
    slow->piece_delay_ms = 100;
    slow->body = std::move(body);
    return slow;
  });
  failing.headers.push_back("Retry-After: 60");  // longer than the patience: reported at once
  for (const Reply& reply : {refused, failing}) {
    mock_.set_fault([&](const SeenRequest&, int) { return std::optional<Reply>(reply); });
    Program server(stored_server(mock_.url() + "/hall.scene.json"));
    EXPECT_NE(server.wait(), 0);
    expect_one_line(server, "hall.files.json: the store answers with status " + std::to_string(reply.status));
  }
}

TEST_F(AssetStores, FilesAreVerified) {
  publish();
  const auto expect_refused = [&](const std::string& message, std::vector<std::string> words) {
    Program server(std::move(words));
    EXPECT_NE(server.wait(), 0);
    expect_one_line(server, message);
  };
  const std::string list = mock_.get("hall.files.json");
  const std::string hash = list.substr(list.find("\"sha256\"") + 11, 64);
  const std::string bytes = mock_.get(hash);
  mock_.set(hash, "#" + bytes.substr(1));
  expect_refused("its bytes have another hash", stored_server(mock_.url() + "/hall.scene.json"));
  mock_.set(hash, bytes);
  const size_t path = list.find("\"path\": \"") + 9;
  std::string outside = list;
  outside.insert(path, "../");
  mock_.set("hall.files.json", outside);
  expect_refused("is not a file of a scene", stored_server(mock_.url() + "/hall.scene.json"));
  mock_.set("hall.files.json", list);
  const std::string scene = mock_.get("hall.scene.json");
  std::string elsewhere = scene;
  elsewhere.insert(elsewhere.find("elsewhere/"), "../../");
  const std::string of_elsewhere = content_hash(std::as_bytes(std::span(elsewhere)));
  mock_.set(of_elsewhere, elsewhere);
  std::string other_list = list;
  const std::string of_scene = content_hash(std::as_bytes(std::span(scene)));
  ASSERT_NE(other_list.find(of_scene), std::string::npos);
  mock_.set("hall.files.json", other_list.replace(other_list.find(of_scene), 64, of_elsewhere));
  expect_refused("is outside the folder of the scene", stored_server(mock_.url() + "/hall.scene.json"));
  expect_refused("does not exist in the store; store the scene with livegs publish",
                 stored_server(mock_.url() + "/other.scene.json"));
}

// Objects of the right size with wrong bytes are kept by a plain publication.
TEST_F(AssetStores, PublishVerifiesAndReplacesDamagedObjects) {
  publish();
  std::map<std::string, std::string> right;
  for (const std::string& name : mock_.names()) right[name] = mock_.get(name);
  const std::vector<std::string> words = {LIVEGS_TOOL, "publish", scene_, "--asset-store", mock_.url()};
  size_t damaged = 0;
  for (auto [name, bytes] : right) {
    if (name.ends_with(".json")) continue;  // written each time
    bytes[bytes.size() / 2] ^= 1;
    mock_.set(name, bytes);
    ++damaged;
  }
  ASSERT_GT(damaged, 4u);
  Program plain(words);
  ASSERT_EQ(plain.wait(), 0) << plain.err();
  EXPECT_NE(plain.out().find("written: 0.0 MB\n"), std::string::npos) << plain.out();
  auto verifying = words;
  verifying.push_back("--verify");
  Program repair(verifying);
  ASSERT_EQ(repair.wait(), 0) << repair.err();
  EXPECT_NE(repair.out().find(", replaced: " + std::to_string(damaged) + "\n"), std::string::npos)
      << repair.out();
  EXPECT_NE(repair.err().find("its bytes have another hash; replacing it"), std::string::npos)
      << repair.err();
  for (const auto& [name, bytes] : right) EXPECT_TRUE(mock_.get(name) == bytes) << name;
}

// A scene file on this machine whose other files are in a folder as store.
TEST_F(AssetStores, ALocalSceneTakesItsMissingFilesFromTheStore) {
  std::filesystem::rename(folder_ / "things/cup.csv", folder_ / "rooms/cup.csv");
  std::string local = kStoredScene;
  local.replace(local.find("../things/"), 10, "");
  scene_ = folder_.write("rooms/hall.scene.json", local);
  Program tool({LIVEGS_TOOL, "publish", scene_, "--asset-store", folder_ / "store"});
  ASSERT_EQ(tool.wait(), 0) << tool.err();
  std::filesystem::remove(folder_ / "rooms/cup.csv");
  Program server({LIVEGS_SERVER, scene_, "--asset-store", folder_ / "store", "--listen", "127.0.0.1:0",
                  "--print-port", "--threads", "1", "--seconds", "0.1"});
  EXPECT_EQ(server.wait(), 0) << server.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "rooms/cup.csv"));
}

}  // namespace
}  // namespace livegs
