// SPDX-License-Identifier: Apache-2.0
// Time of drawing the views of each object of a scene.
//   views_bench SCENE OUTPUT_FOLDER
// writes views.csv, one row per object, with times of one view and of three at 768 px, and the pictures of
// the first view.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "analysis/model/fact_slots.h"
#include "analysis/views/object_views.h"
#include "bench/support/time_of.h"
#include "scene/scene.h"
#include "scene/views/scene_drawing.h"

using namespace livegs;

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: views_bench SCENE OUTPUT_FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[2];
  std::filesystem::create_directories(folder);
  SceneOptions options;
  options.wait_for_pieces = false;
  auto scene = Scene::load(argv[1], options);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message.c_str());
    return 1;
  }
  SceneDrawing drawing;
  const auto drawn = drawing.pose(*scene);
  if (!drawn) return 1;
  constexpr double kBar_ms = 2000;  // one view of an object, on an idle machine
  bool within = true;
  size_t kernels = 0;
  for (const DrawnObject& object : *drawn) kernels += object.asset->size();
  std::ofstream csv(folder / "views.csv");
  csv << "object,kernels,scene_kernels,long_side_px,one_ms,one_cpu_ms,three_ms,three_cpu_ms,bar_one_ms\n";
  std::printf("%zu objects, %zu kernels\n", drawn->size(), kernels);
  for (const SceneObject& object : scene->objects()) {
    if (object.environment) continue;
    Result<std::vector<ObjectView>> views = object_views(*drawn, object.id);
    if (!views) {
      std::fprintf(stderr, "%s: %s\n", object.name.c_str(), views.error().message.c_str());
      continue;
    }
    ViewOptions three;
    three.view_count = 3;
    const auto one_ms = bench::time_of(0, 3, [&] { views = object_views(*drawn, object.id); });
    const auto three_ms = bench::time_of(0, 1, [&] { views = object_views(*drawn, object.id, three); });
    const ObjectView& view = views->front();
    char line[200];
    std::snprintf(line, sizeof line, "%s,%zu,%zu,%d,%.0f,%.0f,%.0f,%.0f,%.0f", object.name.c_str(),
                  object.asset->size(), kernels, three.long_side_px, one_ms.median_ms, one_ms.cpu_ms,
                  three_ms.median_ms, three_ms.cpu_ms, kBar_ms);
    csv << line << std::endl;
    within = within && one_ms.median_ms <= kBar_ms;
    std::printf("%s; %s\n", line, describe_camera(view).c_str());
    const std::string name = object.name;
    for (const auto& [what, image] : {std::pair("outlined", &view.outlined), std::pair("mask", &view.mask),
                                      std::pair("cutout", &view.cutout)}) {
      if (!write_png(folder / (name + "_" + what + ".png"), *image)) return 1;
    }
    if (!object.facts) continue;
    for (const auto& [slot, value] : fact_slots(*object.facts, object.physics, {})) {
      std::printf("  %s: %s\n", slot.c_str(), value.c_str());
    }
  }
  if (!within) std::fprintf(stderr, "views_bench: a view took longer than its bound of %.0f ms\n", kBar_ms);
  return within ? 0 : 1;
}
