// SPDX-License-Identifier: Apache-2.0
// Cost of the tick in which an object breaks, compared with an ordinary tick. Prints CSV: `break_bench >
// results/<machine>/break.csv`. A cup of 300 000 kernels, cut into 64 pieces at load, falls onto a floor fast
// enough to break into all of them. Times are processor times of all threads: median, minimum and maximum
// over the runs. Bound: 11 ms for `step` and `encode` of `breaking` together.
//   step    Scene::step: the world, and the new body of each kernel
//   encode  the server's messages: the drivers as a frame, and the object's new description
//   rebind  the client's work after that: the driver of each kernel
// `before` is the tick before the impact, `breaking` the tick of the break, `after_N` the Nth tick after it.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <map>
#include <string>

#include "core/log.h"
#include "core/parallel_for.h"
#include "gaussian/asset_file.h"
#include "scene/build/fragile_object.h"
#include "scene/build/shape_asset.h"
#include "scene/scene.h"
#include "scratch_folder.h"
#include "server/geometry/fracture/fracture_shapes.h"
#include "session/assets/describe_object.h"
#include "skin/skin_kernels.h"
#include "wire/frame_codec.h"

using namespace livegs;

namespace {

constexpr size_t kKernels = 300000;
constexpr int kRuns = 5;
constexpr int kTicksAfter = 10;

double processor_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double cost_of(const std::function<void()>& work) {
  const double start = processor_ms();
  work();
  return processor_ms() - start;
}

v1::Scene falling_cup() {
  v1::Scene file;
  file.mutable_environment()->add_colliders()->mutable_plane();
  v1::Object& cup = *file.add_objects();
  cup.set_name("cup");
  cup.set_asset("cup.ply");
  cup.set_scale(1.0);
  cup.set_up("+y");
  for (const double value : {0.0, 0.2, 0.0}) cup.mutable_pose()->add_position_m(value);
  for (const double value : {0.0, -6.0, 0.0}) cup.add_velocity_m_s(value);
  v1::Physics& physics = *cup.mutable_physics();
  physics.set_behavior(v1::Physics::RIGID);
  physics.set_fill(v1::Physics::SOLID);
  physics.set_mass_kg(0.3);
  physics.set_fragile(true);
  physics.set_break_impulse_n_s(0.1);
  physics.set_fracture_pieces(64);
  return file;
}

using Costs = std::map<std::string, std::vector<double>>;

void run(const std::filesystem::path& folder, Costs& costs, size_t& kernels, size_t& bodies) {
  auto scene = Scene::build(falling_cup(), folder, "falling cup", {});
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message.c_str());
    std::exit(1);
  }
  const SceneObject& cup = *scene->find("cup");
  AssetStore assets;
  assets.add(cup.broken->asset);
  double last_step_ms = 0;
  int after = -1;
  while (after < kTicksAfter) {
    const double step_ms = cost_of([&] { scene->step(); });
    const double encode_ms = cost_of([&] {
      (void)encode_frame(scene->world().drivers());
      const Scene::Changes changes = scene->take_changes();
      for (const uint32_t id : changes.changed) {
        (void)describe_object(*scene->find(id), assets).SerializeAsString();
      }
    });
    const bool broken = cup.rest.revision > 0;
    if (broken) ++after;
    if (after == 0) {
      costs["before,step"].push_back(last_step_ms);
      costs["breaking,step"].push_back(step_ms);
      costs["breaking,encode"].push_back(encode_ms);
      costs["breaking,rebind"].push_back(cost_of([&] { (void)bind_kernels(*cup.asset, cup.rest); }));
    } else if (after > 0) {
      costs["after_" + std::string(after < 10 ? "0" : "") + std::to_string(after) + ",step"].push_back(
          step_ms);
    }
    last_step_ms = step_ms;
  }
  kernels = cup.asset->size();
  bodies = cup.fragility->bodies;
}

}  // namespace

int main() {
  set_log_level(LogLevel::Warn);
  const ScratchFolder folder;
  const auto written =
      write_asset(folder / "cup.ply", mesh_asset(testing::cup_mesh(128, 39), {0.8f, 0.8f, 0.75f}, kKernels));
  if (!written) return 1;
  std::printf("threads,kernels,bodies,tick,part,median_ms,least_ms,most_ms\n");
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    Costs costs;
    size_t kernels = 0, bodies = 0;
    for (int i = 0; i < kRuns; ++i) run(folder.path(), costs, kernels, bodies);
    for (auto& [name, ms] : costs) {
      std::sort(ms.begin(), ms.end());
      std::printf("%d,%zu,%zu,%s,%.3f,%.3f,%.3f\n", threads, kernels, bodies, name.c_str(), ms[ms.size() / 2],
                  ms.front(), ms.back());
    }
    std::fflush(stdout);
  }
}
