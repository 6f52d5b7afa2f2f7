// SPDX-License-Identifier: Apache-2.0
// Things of a captured room that are taken out of it, put back, and kept over a crash, through the server's
// calls.
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <condition_variable>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include "gaussian/asset_file.h"
#include "sample/made_room.h"
#include "stream/session/scene_control.h"
#include "stream/session/session_client.h"
#include "system/programs/programs_fixture.h"
#include "system/support/counting_sink.h"
#include "viewer/assets/asset_library.h"

namespace livegs {
namespace {

using google::protobuf::util::MessageDifferencer;

class RoomTaking : public Programs {
 protected:
  void SetUp() override {
    room_ = make_room(RoomKind::Apart);
    ASSERT_TRUE(write_asset(folder_.path() / "desk.ply", room_.asset));
    folder_.write("desk.scene.json", R"({ "environment": { "asset": "desk.ply", "collide": true } })");
    serve();
  }
  void serve() {
    server_ = std::make_unique<Program>(std::vector<std::string>{
        LIVEGS_SERVER, folder_ / "desk.scene.json", "--listen", "127.0.0.1:0", "--print-port", "--offline"});
    const std::string port = server_->first_line();
    ASSERT_NE(port, "") << server_->err();
    address_ = "127.0.0.1:" + port;
    author_ = std::make_unique<SceneControl>(address_);
    for (int i = 0; i < 1200; ++i) {
      const auto parts = author_->room_parts();
      ASSERT_TRUE(parts) << parts.error().message;
      if (parts->state() == v1::RoomParts::READY) return;
      ASSERT_EQ(parts->state(), v1::RoomParts::PREPARING) << parts->reason();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    FAIL() << "the room is not prepared within a minute";
  }
  v1::Scene scene() {
    const auto document = author_->scene();
    EXPECT_TRUE(document);
    return document ? document->scene() : v1::Scene();
  }
  // From above and in front of the middle of a thing; the world is y-up, the asset y-down.
  v1::TakePartRequest towards(size_t thing) const {
    const Eigen::Vector3d middle = room_.bounds_m[thing].center();
    const Eigen::Vector3d target(middle.x(), -middle.y(), -middle.z()),
        from = target + Eigen::Vector3d(0.1, 0.6, 0.5);
    v1::TakePartRequest request;
    v1::PickRay& ray = *request.add_rays();
    for (int k = 0; k < 3; ++k) {
      ray.add_from_m(from[k]);
      ray.add_towards(target[k] - from[k]);
    }
    return request;
  }
  // px, py, pz of each row of bodies.csv.
  static std::vector<Eigen::Vector3d> positions(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    std::vector<Eigen::Vector3d> all;
    while (std::getline(file, line)) {
      std::istringstream row(line);
      std::string cell;
      for (int column = 0; column < 4; ++column) std::getline(row, cell, ',');
      Eigen::Vector3d at;
      for (double& number : at) {
        std::getline(row, cell, ',');
        number = std::stod(cell);
      }
      all.push_back(at);
    }
    return all;
  }
  MadeRoom room_;
  std::string address_;
  std::unique_ptr<Program> server_;
  std::unique_ptr<SceneControl> author_;
};

TEST_F(RoomTaking, AThingIsTakenPutBackAndKept) {
  const v1::Scene before = scene();
  v1::TakePartRequest request = towards(0);
  request.set_preview(true);
  const auto preview = author_->take_part(request);
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_GT(preview->kernels(), 100u);
  const Eigen::Vector3d truth = room_.bounds_m[0].center();
  for (int k = 0; k < 3; ++k) {
    const double sign = k == 0 ? 1 : -1;
    EXPECT_LT(preview->min_m(k), sign * truth[k]);
    EXPECT_GT(preview->max_m(k), sign * truth[k]);
  }
  EXPECT_TRUE(MessageDifferencer::Equals(scene(), before)) << "a preview takes nothing";

  request.set_preview(false);
  request.set_name("mug");
  const auto taken = author_->take_part(request);
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_EQ(taken->object(), "mug");
  const v1::Scene with = scene();
  ASSERT_EQ(with.objects_size(), 1);
  EXPECT_GT(with.objects(0).part(), 0u);
  ASSERT_EQ(with.environment().taken_size(), 1);
  EXPECT_EQ(with.environment().taken(0), with.objects(0).part());
  EXPECT_EQ(with.environment().asset(), "desk.ply") << "the room itself stays";
  // The same ray now meets another thing or none.
  const auto again = author_->take_part(towards(0));
  if (again) {
    EXPECT_NE(again->kernels(), taken->kernels());
    ASSERT_TRUE(author_->undo_edit(false));
  }

  // It stands where it was: awake, in the room without it, it moves less than 5 mm and comes to rest.
  ASSERT_TRUE(author_->save_scene({}));
  Program simulated({LIVEGS_TOOL, "simulate", folder_ / "desk.scene.json", "--seconds", "2", "--no-sleep",
                     "-o", folder_ / "out"});
  ASSERT_EQ(simulated.wait(), 0) << simulated.err();
  const std::vector<Eigen::Vector3d> path = positions(folder_ / "out/bodies.csv");
  ASSERT_GT(path.size(), 100u);
  double farthest_m = 0;
  for (const Eigen::Vector3d& at : path) farthest_m = std::max(farthest_m, (at - path.front()).norm());
  EXPECT_LT(farthest_m, 5e-3);
  EXPECT_LT((path.back() - path[path.size() - 10]).norm(), 2e-4);

  ASSERT_TRUE(author_->undo_edit(false));
  EXPECT_TRUE(MessageDifferencer::Equals(scene(), before)) << "undo gives the room of before";
  ASSERT_TRUE(author_->undo_edit(true));
  EXPECT_TRUE(MessageDifferencer::Equals(scene(), with));
  server_->send(SIGKILL);
  server_->wait();
  serve();
  EXPECT_TRUE(MessageDifferencer::Equals(scene(), with)) << "a killed server forgets nothing";

  ASSERT_FALSE(author_->put_back("jug"));
  const auto back = author_->put_back("mug");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(scene().objects_size(), 0);
  EXPECT_EQ(scene().environment().taken_size(), 0);
  EXPECT_TRUE(author_->take_part(towards(0))) << "it can be taken again";
}

// Fetches the assets of a stream and counts the frames that arrive while no room is announced.
class RoomSink final : public CountingSink {
 public:
  explicit RoomSink(AssetLibrary& assets) : assets_(assets) {}
  void on_frame(ReceivedFrame) override {
    std::lock_guard lock(mutex_);
    frames_without_room += began_ && rooms_.empty();
  }
  void on_object_added(StreamedObject object) override {
    assets_.request(object);
    std::lock_guard lock(mutex_);
    if (object.environment) {
      began_ = true;
      rooms_.insert(object.id);
      room_hash_ = object.asset_hash;
    }
    things_[object.name] = object.asset_bytes;
    changed_.notify_all();
  }
  void on_object_removed(uint32_t id) override {
    std::lock_guard lock(mutex_);
    rooms_.erase(id);
  }
  // Waits for a room other than this one, and returns its hash; empty after 20 s.
  std::string room_after(const std::string& hash) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(20),
                      [&] { return !room_hash_.empty() && room_hash_ != hash; });
    return room_hash_ == hash ? "" : room_hash_;
  }
  // Bytes of the asset of an added object; 0 after 20 s.
  uint64_t bytes_of(const std::string& name) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(20), [&] { return things_.contains(name); });
    return things_[name];
  }
  void has_room(uint32_t id) {
    std::lock_guard lock(mutex_);
    began_ = true;
    rooms_.insert(id);
  }
  std::atomic<uint64_t> frames_without_room{0};

 private:
  AssetLibrary& assets_;
  std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  bool began_ = false;
  std::set<uint32_t> rooms_;
  std::string room_hash_;
  std::map<std::string, uint64_t> things_;
};

// A client that has the room fetches the difference when a thing is taken out of it, and nothing when it is
// put back. There is a room in every frame.
TEST_F(RoomTaking, ClientsFetchTheDifferenceOfTheRoom) {
  const AssetCache cache(folder_ / "cache");
  ConnectOptions options;
  auto client = SessionClient::join(address_, options);
  ASSERT_TRUE(client) << client.error().message;
  AssetLibrary assets(**client, cache);
  RoomSink sink(assets);
  std::string first;
  for (const StreamedObject& object : (*client)->scene().objects) {
    assets.request(object);
    ASSERT_TRUE(assets.get(object.asset_hash));
    if (!object.environment) continue;
    sink.has_room(object.id);
    first = object.asset_hash;
  }
  ASSERT_NE(first, "");
  const uint64_t whole_bytes = assets.totals().fetched_bytes;
  (*client)->start(sink);

  v1::TakePartRequest request = towards(0);
  request.set_name("mug");
  ASSERT_TRUE(author_->take_part(request));
  const std::string second = sink.room_after(first);
  ASSERT_NE(second, "");
  const auto room = assets.get(second);
  ASSERT_TRUE(room) << room.error().message;
  EXPECT_LT((*room)->size(), room_.asset.size());
  const uint64_t mug_bytes = sink.bytes_of("mug");
  ASSERT_GT(mug_bytes, 0u);
  // The kernels that fill the hole, and the list of those that are gone.
  EXPECT_LT(assets.totals().fetched_bytes, whole_bytes + whole_bytes / 10 + mug_bytes);

  ASSERT_TRUE(author_->put_back("mug"));
  EXPECT_EQ(sink.room_after(second), first);
  const uint64_t bytes = assets.totals().fetched_bytes;
  EXPECT_LE(bytes, whole_bytes + whole_bytes / 10 + mug_bytes);
  EXPECT_EQ(sink.frames_without_room, 0u);
}

TEST_F(RoomTaking, TwoThingsAreTakenAsOneAndStayTwoAfterUndo) {
  const auto alone = [&](size_t thing) {
    v1::TakePartRequest request = towards(thing);
    request.set_preview(true);
    const auto preview = author_->take_part(request);
    EXPECT_TRUE(preview) << preview.error().message;
    return preview ? preview->kernels() : 0;
  };
  const uint32_t first = alone(0), second = alone(1);
  v1::TakePartRequest both = towards(0);
  *both.add_rays() = towards(1).rays(0);
  const auto taken = author_->take_part(both);
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_EQ(taken->kernels(), first + second);
  // The planes of the desk's room and a box around each of the three things that are left.
  int boxes = 0;
  const v1::Scene now = scene();
  for (const v1::Collider& collider : now.environment().colliders()) boxes += collider.has_box();
  EXPECT_GE(boxes, 3);
  ASSERT_TRUE(author_->undo_edit(false));
  EXPECT_EQ(alone(0), first);
  EXPECT_EQ(alone(1), second);
  v1::TakePartRequest one = both;  // the second ray takes away
  one.mutable_rays(1)->set_away(true);
  const auto only = author_->take_part(one);
  ASSERT_TRUE(only) << only.error().message;
  EXPECT_EQ(only->kernels(), first);
}

TEST_F(RoomTaking, BadRaysTakeNothing) {
  const auto refusal = [&](const v1::TakePartRequest& request) {
    const auto taken = author_->take_part(request);
    return taken ? "taken" : taken.error().message;
  };
  EXPECT_NE(refusal({}).find("rays"), std::string::npos);
  v1::TakePartRequest away = towards(0);
  away.mutable_rays(0)->set_towards(1, 1.0);  // at the ceiling
  EXPECT_NE(refusal(away).find("no thing"), std::string::npos);
  v1::TakePartRequest nowhere = towards(0);
  for (double& number : *nowhere.mutable_rays(0)->mutable_towards()) number = 0;
  EXPECT_NE(refusal(nowhere).find("towards"), std::string::npos);
  nowhere.mutable_rays(0)->set_from_m(0, NAN);
  EXPECT_NE(refusal(nowhere).find("from_m"), std::string::npos);
  EXPECT_EQ(scene().objects_size(), 0);
}

}  // namespace
}  // namespace livegs
