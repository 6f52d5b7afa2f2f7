// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <memory>

#include "analysis/division/part_places.h"
#include "cli/commands.h"
#include "cli/input_kind.h"
#include "core/log.h"
#include "core/text/path_ending.h"
#include "export/gltf_scene.h"
#include "export/usda_scene.h"
#include "gaussian/asset_file.h"
#include "gaussian/asset_summary.h"
#include "scene/build/elastic_report.h"
#include "scene/check/joint_parts.h"
#include "scene/scene.h"

namespace livegs {
namespace {

int print_scene(const std::filesystem::path& path) {
  const auto text = read_scene(path);
  if (!text) return report(text.error());
  const v1::Scene* const scene = &text->file;
  std::printf("scene        %s\n", text->name.c_str());
  std::printf("rate         %g Hz, %d substeps\n", scene->has_rate_hz() ? scene->rate_hz() : 90.0,
              scene->has_substeps() ? scene->substeps() : 4);
  std::printf("environment  %s, %d colliders\n",
              scene->environment().asset().empty() ? "no asset" : scene->environment().asset().c_str(),
              scene->environment().colliders_size());
  for (const v1::Object& object : scene->objects()) {
    const char* form = object.form_case() == v1::Object::kShape    ? "shape"
                       : object.form_case() == v1::Object::kPoints ? object.points().c_str()
                                                                   : object.asset().c_str();
    std::printf("object       %s: %s, %s\n", object.name().empty() ? "(unnamed)" : object.name().c_str(),
                form, v1::Physics::Behavior_Name(object.physics().behavior()).c_str());
  }
  for (const v1::Joint& joint : scene->joints()) std::printf("joint        %s\n", joint_line(joint).c_str());
  std::printf("events       %d\n", scene->events_size());
  // Other errors are found only by loading assets and building bodies. Warnings are printed below, so the log
  // is limited to errors.
  set_log_level(LogLevel::Error);
  auto built = Scene::load(path, {});
  if (!built) return report(built.error());
  for (const SceneObject& object : built->objects()) {
    if (object.environment) continue;
    const char* name = object.name.c_str();
    std::printf("body         %s: %s, %.4g kg%s%s\n", name,
                v1::Physics::Behavior_Name(object.physics.behavior()).c_str(), object.mass_kg,
                object.elastic ? "; " : "", object.elastic ? accuracy_line(*object.elastic).c_str() : "");
    if (object.fragility && object.fragility->pieces == 0) {
      std::printf("fragile      %s: does not break\n", name);
    } else if (object.fragility) {
      std::printf("fragile      %s: %u pieces, breaks at %.3g N s, a drop of %.2f m\n", name,
                  object.fragility->pieces, object.fragility->break_impulse_n_s,
                  object.fragility->drop_height_m);
    }
    for (const v1::MaterialPart& part : object.physics.parts())
      std::printf("part         %s: %s\n", name, part_line(part).c_str());
    if (object.physics.parts_size() > 0)
      std::printf("parts        %s: %s\n", name, object.physics.parts_reason().c_str());
    for (const std::string& warning : object.all_warnings())
      std::printf("warning      %s: %s\n", name, warning.c_str());
  }
  std::printf("builds       yes\n");
  return 0;
}

// The axes, unit and place that the file states.
void print_frame(const AssetFile& file) {
  const AssetFrame& frame = file.frame;
  if (file.y_up_in_file) {
    std::printf("axes         y up in the file, converted to -y up\n");
  } else if (frame.up_axis.empty()) {
    std::printf("axes         -y up, assumed; the file names none\n");
  } else {
    std::printf("axes         %s up, named by the file\n", frame.up_axis.c_str());
  }
  if (frame.metres_per_unit == 0) {
    std::printf("unit         unknown; a scene gives or guesses it\n");
  } else if (frame.unit_of_format) {
    std::printf("unit         metre, by convention of the format\n");
  } else {
    std::printf("unit         %g m, named by the file\n", frame.metres_per_unit);
  }
  if (!frame.origin.isZero(0))
    std::printf("origin       %.10g %.10g %.10g, subtracted from all positions\n", frame.origin.x(),
                frame.origin.y(), frame.origin.z());
}

// The physics of a scene as glTF or USD; nothing if it has none.
int print_physics(const std::filesystem::path& path) {
  const bool usd = has_ending(path.string(), ".usda");
  const auto scene = usd ? read_usda_scene(path) : read_gltf_scene(path, {.kernels = false});
  if (!scene) return report(scene.error());
  if (scene->bodies.empty() && scene->fixed.empty() && !usd) return 0;
  std::printf("gravity      %.5g %.5g %.5g m/s2\n", scene->gravity_m_s2.x(), scene->gravity_m_s2.y(),
              scene->gravity_m_s2.z());
  for (const PortableBody& body : scene->bodies) std::printf("body         %s\n", body_line(body).c_str());
  for (const PortableShape& shape : scene->fixed)
    std::printf("collider     %s, friction %.3g, restitution %.3g\n", name_of(shape.kind), shape.friction,
                shape.restitution);
  for (const PortableJoint& joint : scene->joints)
    std::printf("joint        %s\n", joint_text(*scene, joint).c_str());
  if (scene->animation && !scene->animation->times_s.empty())
    std::printf("animation    %.4g s, %zu keys, %zu bodies\n", scene->animation->times_s.back(),
                scene->animation->times_s.size(), scene->animation->tracks.size());
  for (const std::string& note : scene->notes) std::printf("note         %s\n", note.c_str());
  return 0;
}

int print_asset(const std::filesystem::path& path, const ReadOptions& options) {
  if (has_ending(path.string(), ".usda")) return print_physics(path);
  auto file = read_asset(path, options);
  if (!file) return report(file.error());
  const AssetSummary summary = summarise(file->asset);
  std::printf("format       %s", format_name(file->format));
  if (file->format_version > 0) std::printf(" v%d", file->format_version);
  std::printf("\n");
  print_frame(*file);
  std::printf("kernels      %zu\n", summary.count);
  std::printf("SH degree    %d%s\n", summary.sh_degree,
              file->asset.antialiased ? ", trained antialiased" : "");
  const auto vector = [](const char* name, const Eigen::Vector3f& v) {
    std::printf("%-12s %.5g %.5g %.5g\n", name, v.x(), v.y(), v.z());
  };
  vector("bounds min", summary.bounds_min);
  vector("bounds max", summary.bounds_max);
  vector("size", summary.bounds_max - summary.bounds_min);
  std::printf("opacity      mean %.4f; 1 %% %.4f, 50 %% %.4f, 99 %% %.4f\n", summary.mean_opacity,
              summary.opacity.p1, summary.opacity.p50, summary.opacity.p99);
  std::printf("scale        1 %% %.4g, 50 %% %.4g, 99 %% %.4g\n", summary.scale.p1, summary.scale.p50,
              summary.scale.p99);
  for (const std::string& note : file->notes) std::printf("note         %s\n", note.c_str());
  return file->format == AssetFormat::Gltf ? print_physics(path) : 0;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
  auto path = std::make_shared<std::filesystem::path>();
  auto activated = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("info", "Show the contents of a splat asset or a scene file, and check it");
  command
      ->add_option(
          "PATH", *path,
          "Splat file, unpacked or streamed .sog folder, *.scene.json, folder of assets, or a scene as "
          ".glb, .gltf or .usda")
      ->required();
  add_activated_flag(*command, *activated);
  command->callback([path, activated, &exit_code] {
    const bool scene =
        is_scene_input(*path) || (has_ending(path->string(), ".json") && !is_asset_index(*path));
    exit_code = scene ? print_scene(*path) : print_asset(*path, read_options(*activated));
  });
}

}  // namespace livegs
