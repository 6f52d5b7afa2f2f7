// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <string>
#include <vector>

#include "core/parallel_for.h"
#include "rates.h"
#include "scene/scene.h"

// Runs a scene with all kinds of objects, with a captured asset if available, and hashes its drivers after
// each tick. The hashes must not depend on the number of threads.

namespace livegs::testing {

// FNV-1a, 64 bits, over the bits of each number.
class BitHash {
 public:
  void add(uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) {
      hash_ = (hash_ ^ (word & 0xff)) * 0x100000001b3;
      word >>= 8;
    }
  }
  void add(double value) { add(std::bit_cast<uint64_t>(value)); }
  void add(float value) { add(uint64_t{std::bit_cast<uint32_t>(value)}); }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 0xcbf29ce484222325;
};

inline uint64_t hash_of(const DriverFrame& frame) {
  BitHash hash;
  hash.add(frame.tick);
  for (const ObjectDrivers& object : frame.objects) {
    hash.add(uint64_t{object.object_id});
    hash.add(uint64_t{object.revision});
    hash.add(uint64_t{object.asleep});
    for (const Pose& pose : object.poses) {
      for (const double value : pose.position_m) hash.add(value);
      for (const double value : pose.orientation.coeffs()) hash.add(value);
    }
    for (const Eigen::Vector3f& position : object.positions_m) {
      for (const float value : position) hash.add(value);
    }
    for (const Eigen::Quaternionf& rotation : object.rotations) {
      for (const float value : rotation.coeffs()) hash.add(value);
    }
  }
  return hash.value();
}

struct HashedRun {
  std::vector<uint64_t> ticks;
  size_t fragments = 0;                    // of the cup at the end
  std::map<std::string, int> first_touch;  // by object: the tick of its first impact
};

inline HashedRun run_everything(int threads, int ticks, double rate_hz) {
  namespace fs = std::filesystem;
  set_thread_count(threads);
  HashedRun run;
  const fs::path folder = fs::path(LIVEGS_TESTS_DIR) / "scenes";
  auto file = read_scene_file(folder / "everything.scene.json");
  EXPECT_TRUE(file) << file.error().message;
  file->set_rate_hz(rate_hz);
  const fs::path captured = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats/ponytail_palm/ponytail_palm.ply";
  if (fs::exists(captured)) {
    v1::Object& palm = *file->add_objects();
    palm.set_name("palm");
    palm.set_asset(fs::absolute(captured).string());
    palm.set_scale(0.2);
    palm.set_spacing_m(0.03);
    for (const double value : {0.3, 0.3, 0.5}) palm.mutable_pose()->add_position_m(value);
  }
  auto scene = Scene::build(*file, folder, "everything", {});
  EXPECT_TRUE(scene) << scene.error().message;
  if (!scene) return run;
  for (int tick = 0; tick < ticks; ++tick) {
    scene->step();
    run.ticks.push_back(hash_of(scene->world().drivers()));
    for (const WorldEvent& event : scene->world().take_events()) {
      if (event.kind == WorldEventKind::Contact)
        run.first_touch.try_emplace(scene->find(event.object_id)->name, tick + 1);
    }
  }
  for (const BodyState& body : scene->world().bodies())
    run.fragments += body.object_id == scene->find("cup")->id;
  set_thread_count(0);
  return run;
}

// Compares 1, 2 and 8 threads in all ticks. The message names the first tick that differs.
inline void expect_same_bits(int ticks, double rate_hz) {
  SCOPED_TRACE(rate_hz);
  const HashedRun one = run_everything(1, ticks, rate_hz);
  EXPECT_GT(one.fragments, 1u) << "the cup must break";
  EXPECT_GE(one.first_touch.size(), 13u);
  for (const char* name : {"pad", "marble", "plank", "block", "load"})
    EXPECT_TRUE(one.first_touch.contains(name)) << name;
  // It lands on the block after a tenth of a second. A fall to the floor would take twice as long.
  EXPECT_LT(one.first_touch.at("pad"), rate_hz / 6);
  for (const int threads : {2, 8}) {
    const HashedRun more = run_everything(threads, ticks, rate_hz);
    ASSERT_EQ(one.ticks.size(), more.ticks.size());
    const auto differs = std::mismatch(one.ticks.begin(), one.ticks.end(), more.ticks.begin()).first;
    EXPECT_EQ(differs, one.ticks.end())
        << threads << " threads, from tick " << differs - one.ticks.begin() + 1 << " on";
  }
}

}  // namespace livegs::testing
