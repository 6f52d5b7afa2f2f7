// SPDX-License-Identifier: Apache-2.0
// Soak test: hands pull eight objects in a room. `pull_soak [MINUTES] > results/<machine>/pull_soak.csv`;
// default: one simulated hour.
// Objects: the six of the sample scene, a box and a soft block. Every half second on average, a hand grabs a
// random point of a random object and pulls it to a random position for up to one second. Hands alternate
// between ray, grip, and a spring of 20 to 200 N/m and up to 50 N, which is several times stronger. Balls are
// shot occasionally. The seed is fixed, so the motion is reproducible.
// Prints one row per simulated minute. `tick_cpu`: processor time of all threads, ms. `tick_wall`: wall time,
// ms; meaningful on an idle machine (one frame is 11.1 ms). `object_most_j`: maximum kinetic and elastic
// energy of one elastic object, sampled every tenth tick. `lowest_m`: minimum height of any body's centre
// over the floor.
// The exit code is 1 if a value is not finite, an object has more energy than hands can supply, a centre is
// more than 5 cm below the floor, or memory grows. Progress is printed to standard error.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <string>

#include "bench/support/arguments.h"
#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"
#include "gaussian/asset_file.h"
#include "sample/sample_scene.h"
#include "scene/run/scripted_grabs.h"
#include "scene/scene.h"
#include "scratch_folder.h"

using namespace livegs;
using Eigen::Vector3d;

namespace {

constexpr int kRate_hz = 90;
constexpr double kHand_m_s = 4.0;  // speed of a throwing hand
constexpr int kEarly_minutes = 5;  // after this time the room has all its balls and fragments
constexpr double kGrown_mb = 5.0;  // bound of the growth after that
constexpr double kSunk_m = 0.05;   // a centre this far below the floor has passed through it
// Maximum energy that hands can supply to one object: 200 N/m across the room's 2.8 m, and the grip's 20
// weights along the diagonal of 4.2 m.
double most_j_of(double mass_kg) { return 784.0 + 20.0 * 9.81 * 4.2 * mass_kg; }
// Pulls stay inside this box.
const Vector3d kRoomMin(-1.4, 0.1, -1.4), kRoomMax(1.4, 1.4, 1.4);

constexpr const char* kRoom = R"({
  "environment": { "colliders": [
    { "plane": { "point_m": [0, 0, 0], "normal": [0, 1, 0] }, "friction": 0.6 },
    { "plane": { "point_m": [0, 0, -1.5], "normal": [0, 0, 1] } }, { "plane": { "point_m": [0, 0, 1.5], "normal": [0, 0, -1] } },
    { "plane": { "point_m": [-1.5, 0, 0], "normal": [1, 0, 0] } }, { "plane": { "point_m": [1.5, 0, 0], "normal": [-1, 0, 0] } } ] },
  "objects": [
    { "name": "stool",  "asset": "stool.ply",  "scale": 1, "pose": { "position_m": [-0.62, 0.02, -0.45] } },
    { "name": "plant",  "asset": "plant.ply",  "scale": 1, "spacing_m": 0.03, "pose": { "position_m": [ 0.72, 0.04, -0.55] } },
    { "name": "pillow", "asset": "pillow.ply", "scale": 1, "pose": { "position_m": [-0.02, 0.40, -0.30] } },
    { "name": "hat",    "asset": "hat.ply",    "scale": 1, "spacing_m": 0.014, "pose": { "position_m": [-0.42, 0.30,  0.12] } },
    { "name": "cup",    "asset": "cup.ply",    "scale": 1, "pose": { "position_m": [ 0.42, 0.60,  0.15] } },
    { "name": "duck",   "asset": "duck.ply",   "scale": 1, "pose": { "position_m": [ 0.05, 0.05,  0.30] } },
    { "name": "box",    "shape": { "box": { "size_m": [0.2, 0.15, 0.25] } }, "pose": { "position_m": [0.5, 0.1, 0.8] },
      "physics": { "behavior": "RIGID", "mass_kg": 1.5 } },
    { "name": "block",  "shape": { "box": { "size_m": [0.25, 0.15, 0.2] } }, "spacing_m": 0.05,
      "pose": { "position_m": [-0.6, 0.1, 0.8] },
      "physics": { "behavior": "ELASTIC", "density_kg_m3": 80, "youngs_modulus_pa": 2e4 } } ]
})";

double resident_mb() {
  std::ifstream status("/proc/self/statm");
  double pages = 0, resident = 0;
  status >> pages >> resident;
  return resident * 4096 / 1e6;
}

// Median, p99, p99.9 and maximum as four columns. Sorts the values.
std::string columns(std::vector<double>& ms) {
  std::sort(ms.begin(), ms.end());
  const auto part = [&](double of) {
    return ms[std::min(ms.size() - 1, static_cast<size_t>(of * static_cast<double>(ms.size())))];
  };
  return format_text("%.2f,%.2f,%.2f,%.2f", part(0.5), part(0.99), part(0.999), ms.back());
}

class Hands {
 public:
  explicit Hands(const Scene& scene) {
    for (const SceneObject& object : scene.objects()) {
      if (!object.environment) ids_.push_back(object.id);
    }
  }

  void act(Scene& scene, int tick) {
    World& world = scene.world();
    for (Pull& pull : pulls_) {
      if (pull.until > tick) {
        if (pull.grip) world.move_grab(pull.id, pull.hand_at(tick), pull.hand_m_s(), Vector3d::Zero());
        continue;
      }
      pull.grip ? world.release_grab(pull.id) : world.clear_spring(pull.id);
      pull.until = -1;
    }
    std::erase_if(pulls_, [](const Pull& pull) { return pull.until < 0; });
    if (random() < 2.0 / kRate_hz) {
      const uint32_t id = ids_[static_cast<size_t>(random() * static_cast<double>(ids_.size()))];
      // The grabbed point is where a ray towards the middle of the object hits it.
      const Vector3d from = place(), middle = world.world_point(id, Vector3d::Zero());
      const auto hit = world.ray_cast(from, (middle - from).normalized(), 5.0);
      if (hit) {
        const double mass_kg = scene.find(hit->object_id)->mass_kg;
        const Kind kind = static_cast<Kind>(pulled % 3);
        World::Spring spring = ray_spring(mass_kg);
        if (kind == Kind::Fierce) spring = {.stiffness_n_m = 20.0 + 180.0 * random()};
        spring.rest_point_m = hit->rest_point_m;
        spring.piece = hit->piece;
        spring.target_m = place();
        Pull pull{++last_,
                  tick,
                  tick + 9 + static_cast<int>(random() * kRate_hz),
                  kind == Kind::Grip,
                  from + hit->distance_m * (middle - from).normalized(),
                  spring.target_m};
        const double way_m = (pull.to_m - pull.from_m).norm();
        if (pull.grip)
          pull.until = std::max(pull.until, tick + static_cast<int>(kRate_hz * way_m / kHand_m_s));
        if (!pull.grip) world.set_spring(pull.id, hit->object_id, spring);
        if (pull.grip && !world.grab(pull.id, hit->object_id, pull.hand_at(tick), hand_grip(mass_kg))) return;
        pulls_.push_back(pull);
        ++pulled;
      }
    }
    if (random() < 1.0 / (10 * kRate_hz)) {
      const Vector3d from = place(), to = place();
      scene.shoot_ball(from, 6.0 * (to - from).normalized());
    }
  }

  int pulled = 0;

 private:
  enum class Kind { Ray, Grip, Fierce };
  struct Pull {
    uint64_t id;
    int since, until;  // ticks
    bool grip;
    Vector3d from_m, to_m;

    Pose hand_at(int tick) const {
      return {from_m + static_cast<double>(tick - since) / (until - since) * (to_m - from_m),
              Eigen::Quaterniond::Identity()};
    }
    Vector3d hand_m_s() const { return static_cast<double>(kRate_hz) / (until - since) * (to_m - from_m); }
  };
  double random() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  Vector3d place() {
    Vector3d at;
    for (int i = 0; i < 3; ++i) at[i] = kRoomMin[i] + random() * (kRoomMax[i] - kRoomMin[i]);
    return at;
  }

  std::mt19937_64 engine_{20260204};
  std::vector<uint32_t> ids_;
  std::vector<Pull> pulls_;
  uint64_t last_ = 0;
};

// Maximum kinetic and elastic energy of an elastic object. Sets `over` if one exceeds the energy that hands
// can supply.
double object_most_j(const Scene& scene, bool& over) {
  double most_j = 0;
  for (const SceneObject& object : scene.objects()) {
    const ElasticBody* body = object.environment ? nullptr : scene.world().elastic_body(object.id);
    if (!body || body->asleep()) continue;
    const BodyEnergy energy = body->energy(Vector3d::Zero());
    const double has_j = energy.kinetic_j + energy.elastic_j;
    most_j = std::max(most_j, has_j);
    static double reported_j = 500.0;
    if (has_j > 1.2 * reported_j) {
      reported_j = has_j;
      std::fprintf(stderr, "%s: mass %.2g kg, energy %.0f J: kinetic %.0f, elastic %.0f\n",
                   object.name.c_str(), body->mass_kg(), has_j, energy.kinetic_j, energy.elastic_j);
    }
    if (has_j <= most_j_of(body->mass_kg())) continue;
    over = true;
    std::fprintf(stderr, "%s: mass %.2g kg, energy %.0f J, more than hands can supply\n", object.name.c_str(),
                 body->mass_kg(), has_j);
  }
  return most_j;
}

// Maximum distance from the middle of the room. Infinite, with a message, if a value is not finite.
double reach_m(const Scene& scene, int tick) {
  double reach = 0;
  const auto see = [&](const Vector3d& point) {
    if (std::isfinite(reach)) reach = point.allFinite() ? std::max(reach, point.norm()) : INFINITY;
  };
  for (const ObjectDrivers& object : scene.world().drivers().objects) {
    for (const Pose& pose : object.poses) {
      see(pose.position_m);
      if (!pose.orientation.coeffs().allFinite()) reach = INFINITY;
    }
    for (const Eigen::Vector3f& node : object.positions_m) see(node.cast<double>());
    if (std::isfinite(reach)) continue;
    std::fprintf(stderr, "%s: not finite after tick %d\n", scene.find(object.object_id)->name.c_str(), tick);
    break;
  }
  return reach;
}

// Minimum height of the centres of moving bodies, including all fragments.
double lowest_centre_m(const Scene& scene) {
  double lowest = INFINITY;
  for (const BodyState& body : scene.world().bodies())
    lowest = std::min(lowest, body.world_from_body.position_m.y());
  for (const SceneObject& object : scene.objects()) {
    if (const ElasticBody* body = scene.world().elastic_body(object.id))
      lowest = std::min(lowest, body->centre_m().y());
  }
  return lowest;
}

}  // namespace

int main(int argc, char** argv) {
  int minutes = 60;
  CLI::App app(
      "Random pulls on eight objects in a room; CSV on standard output, one row per simulated minute and one "
      "for all",
      "pull_soak");
  app.add_option("MINUTES", minutes, "Simulated time")->check(bench::between(1, 1000))->capture_default_str();
  bench::read_arguments(app, argc, argv);
  set_log_level(LogLevel::Warn);
  const ScratchFolder folder;
  for (const SampleAsset& sample : make_sample_assets(1)) {
    if (!write_asset(folder / (sample.name + ".ply"), sample.asset)) return 1;
  }
  auto scene = Scene::load(folder.write("room.scene.json", kRoom), {});
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message.c_str());
    return 1;
  }
  Hands hands(*scene);
  std::printf(
      "minute,pulls,tick_cpu_p50_ms,tick_cpu_p99_ms,tick_cpu_p999_ms,tick_cpu_most_ms,"
      "tick_wall_p50_ms,tick_wall_p99_ms,tick_wall_p999_ms,tick_wall_most_ms,resident_mb,asleep,objects,"
      "bodies,energy_j,object_most_j,reach_m,lowest_m,finite\n");
  int tick = 0;
  std::vector<double> all_cpu_ms, all_wall_ms;
  double early_mb = 0;
  for (std::vector<double>* all :
       {&all_cpu_ms, &all_wall_ms}) {  // touch the memory now, so that it does not appear as growth later
    all->resize(static_cast<size_t>(minutes) * 60 * kRate_hz);
    all->clear();
  }
  for (int minute = 1; minute <= minutes; ++minute) {
    std::vector<double> cpu_ms, wall_ms;
    double reach = 0, most_j = 0, lowest = INFINITY;
    bool over = false;
    for (int i = 0; i < 60 * kRate_hz; ++i, ++tick) {
      hands.act(*scene, tick);
      const int64_t start_ns = now_ns();
      const std::clock_t start = std::clock();
      scene->step();
      cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
      wall_ms.push_back(milliseconds_from_ns(now_ns() - start_ns));
      (void)scene->take_changes();
      (void)scene->world().take_events();
      reach = std::max(reach, reach_m(*scene, tick));
      if (i % 10 == 0) most_j = std::max(most_j, object_most_j(*scene, over));
      lowest = std::min(lowest, lowest_centre_m(*scene));
      if (!std::isfinite(reach) || !std::isfinite(most_j) || over || lowest < -kSunk_m) break;
      if (i % (5 * kRate_hz) == 0) {
        const BodyEnergy energy = scene->world().energy();
        std::fprintf(stderr,
                     "%d s: last tick %.1f ms, %zu bodies, kinetic %.3g J, elastic %.3g J, reach %.2f m\n",
                     tick / kRate_hz, wall_ms.back(), scene->world().bodies().size(), energy.kinetic_j,
                     energy.elastic_j, reach);
      }
    }
    all_cpu_ms.insert(all_cpu_ms.end(), cpu_ms.begin(), cpu_ms.end());
    all_wall_ms.insert(all_wall_ms.end(), wall_ms.begin(), wall_ms.end());
    size_t asleep = 0;
    const DriverFrame drivers = scene->world().drivers();
    for (const ObjectDrivers& object : drivers.objects) asleep += object.asleep;
    const BodyEnergy energy = scene->world().energy();
    const bool finite = std::isfinite(reach);
    std::printf("%d,%d,%s,%s,%.1f,%zu,%zu,%zu,%.3g,%.0f,%.2f,%.4f,%d\n", minute, hands.pulled,
                columns(cpu_ms).c_str(), columns(wall_ms).c_str(), resident_mb(), asleep,
                drivers.objects.size(), scene->world().bodies().size(),
                energy.kinetic_j + energy.elastic_j + energy.gravity_j, most_j, reach, lowest, finite);
    std::fflush(stdout);
    if (lowest < -kSunk_m) std::fprintf(stderr, "pull_soak: a centre is %.3f m below the floor\n", -lowest);
    if (!finite || !std::isfinite(most_j) || over || lowest < -kSunk_m) return 1;
    if (minute <= kEarly_minutes) early_mb = resident_mb();
    if (const double grown_mb = resident_mb() - early_mb; grown_mb > kGrown_mb) {
      std::fprintf(stderr, "pull_soak: memory has grown by %.1f MB since minute %d\n", grown_mb,
                   kEarly_minutes);
      return 1;
    }
  }
  std::printf("all,%d,%s,%s,,,,,,,,,\n", hands.pulled, columns(all_cpu_ms).c_str(),
              columns(all_wall_ms).c_str());
}
