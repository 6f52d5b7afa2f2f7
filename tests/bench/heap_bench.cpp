// SPDX-License-Identifier: Apache-2.0
// Time of a tick while soft boxes of 20 x 15 x 20 cm and 30 kPa fall into a bin and come to rest, by number
// of boxes and number of threads. Prints CSV: `heap_bench > results/<machine>/heap.csv`. `landing` is the
// first 3 s, `resting` the rest of 8 s. `asleep_s`: when the last box sleeps; 8 if some are awake at the
// end. `--boxes` times single heaps. `apart` puts the boxes next to each other on the floor. Bounds for 40
// boxes: p99 11 ms, asleep within 5 s; cost in proportion to the number up to 160.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/clock.h"
#include "core/parallel_for.h"
#include "scenes/soft_fixtures.h"
#include "support/arguments.h"

using namespace livegs;
using namespace livegs::soft_fixtures;

namespace {

constexpr double kRate_hz = 90.0, kSeconds = 8.0, kLanding_s = 3.0;

World heap(int count, bool apart) {
  World world = world_with(make_elastic_body, kRate_hz);
  world.add_collider(floor_plane(0.6));
  const int columns = apart ? static_cast<int>(std::ceil(std::sqrt(count))) : 3;
  const double pitch_m = apart ? 0.3 : 0.24, half_m = 0.5 * columns * pitch_m + 0.02;
  for (int side = 0; side < 4; ++side) {
    Collider wall;
    const Vector3d out = Eigen::AngleAxisd(0.5 * M_PI * side, Vector3d::UnitY()) * Vector3d::UnitX();
    wall.shape = PlaneShape{};
    wall.world_from_collider = {half_m * out, Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitY(), -out)};
    wall.friction = 0.5;
    world.add_collider(wall);
  }
  std::mt19937 random(11);
  const auto jitter_m = [&] { return 0.02 * (static_cast<double>(random() % 1001) / 1000.0 - 0.5); };
  for (int i = 0; i < count; ++i) {
    const int layer = apart ? 0 : i / (columns * columns), place = i % (columns * columns);
    ElasticBodyDescription box = soft_block(static_cast<uint32_t>(i + 1), {0.2, 0.15, 0.2}, 1.8, 3e4, 0.025);
    box.world_from_object.position_m = {(place % columns - 0.5 * (columns - 1)) * pitch_m + jitter_m(),
                                        0.1 + 0.2 * layer,
                                        (place / columns - 0.5 * (columns - 1)) * pitch_m + jitter_m()};
    if (!world.add_elastic(box)) std::exit(1);
  }
  return world;
}

double at_share(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

void report(int count, bool apart, int threads) {
  set_thread_count(threads);
  World world = heap(count, apart);
  std::vector<double> landing_ms, resting_ms;
  double asleep_s = kSeconds;
  for (int i = 0; i < static_cast<int>(kSeconds * kRate_hz); ++i) {
    const int64_t start_ns = now_ns();
    world.step();
    (i < kLanding_s * kRate_hz ? landing_ms : resting_ms)
        .push_back(milliseconds_from_ns(now_ns() - start_ns));
    bool asleep = true;
    for (int id = 1; id <= count; ++id)
      asleep = asleep && world.elastic_body(static_cast<uint32_t>(id))->asleep();
    if (asleep && asleep_s == kSeconds) asleep_s = (i + 1) / kRate_hz;
    if (!asleep) asleep_s = kSeconds;
  }
  std::printf("%s,%d,%d,%.3f,%.3f,%.3f,%.3f,%.2f\n", apart ? "apart" : "heap", count, threads,
              at_share(landing_ms, 0.5), at_share(landing_ms, 0.99), at_share(resting_ms, 0.5),
              at_share(resting_ms, 0.99), asleep_s);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Times soft boxes that fall into a bin and come to rest. Prints CSV.", "heap_bench"};
  std::vector<int> boxes;
  int threads = 2;
  CLI::Option* counts = app.add_option("--boxes", boxes, "Numbers of boxes in a heap, instead of all scenes")
                            ->check(bench::between(1, 1000));
  app.add_option("--threads", threads, "Threads of these heaps")
      ->check(bench::between(1, 256))
      ->needs(counts)
      ->capture_default_str();
  bench::read_arguments(app, argc, argv);
  std::printf("scene,boxes,threads,landing_ms,landing_p99_ms,resting_ms,resting_p99_ms,asleep_s\n");
  for (const int count : boxes) report(count, false, threads);
  if (!boxes.empty()) return 0;
  report(80, true, 2);
  report(40, false, 1);
  for (const int count : {5, 10, 20, 40, 80, 160}) report(count, false, 2);
}
