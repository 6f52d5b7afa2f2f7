// SPDX-License-Identifier: GPL-3.0-or-later
#include <google/protobuf/util/json_util.h>

#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "scene/build_object.h"

namespace livegs {
namespace {

struct AnalyzeCommand {
  std::filesystem::path asset;
  std::string name, up;
  double scale = 0;
  bool json = false;
};

const char* source_text(v1::EstimatedValue::Source source) {
  switch (source) {
    case v1::EstimatedValue::OFFLINE:
      return "offline";
    case v1::EstimatedValue::MODEL:
      return "model";
    case v1::EstimatedValue::SCENE:
      return "scene";
    case v1::EstimatedValue::PERSON:
      return "person";
    case v1::EstimatedValue::DEFAULT:
      return "default";
    default:
      return "unknown";
  }
}

void print_value(const char* name, const v1::EstimatedValue& value, double factor, const char* unit) {
  std::printf("%-22s %10.4g %-4s %9.4g to %-9.4g %-8s %s\n", name, value.best() * factor, unit,
              value.low() * factor, value.high() * factor, source_text(value.source()),
              value.reason().c_str());
}

void print_parameters(const v1::PhysicalParameters& p) {
  std::printf("taken for              %s, of %s (confidence %.2f)\n", p.label().c_str(), p.material().c_str(),
              p.confidence());
  std::printf("behaves                %s: %s\n", v1::Physics::Behavior_Name(p.behavior()).c_str(),
              p.behavior_reason().c_str());
  std::printf("filled                 %s: %s\n", v1::Physics::Fill_Name(p.fill()).c_str(),
              p.fill_reason().c_str());
  std::printf("fragile                %s\n", p.fragile() ? "yes" : "no");
  print_value("longest side", p.longest_side_m(), 1, "m");
  print_value("mass", p.mass_kg(), 1, "kg");
  print_value("wall thickness", p.wall_thickness_m(), 1e3, "mm");
  print_value("Young's modulus", p.youngs_modulus_pa(), 1e-6, "MPa");
  print_value("Poisson ratio", p.poisson_ratio(), 1, "");
  print_value("structure coefficient", p.structure_coefficient(), 1, "");
  print_value("deformation resistance", p.deformation_resistance(), 1, "");
  print_value("plasticity", p.plasticity(), 1, "");
  print_value("damping", p.damping(), 1, "");
  print_value("friction", p.friction(), 1, "");
  print_value("restitution", p.restitution(), 1, "");
  if (p.fragile()) print_value("break impulse", p.break_impulse_n_s(), 1, "N s");
}

int run(const AnalyzeCommand& options) {
  v1::Object object;
  object.set_asset(std::filesystem::absolute(options.asset).string());
  object.set_name(options.name);
  object.set_up(options.up);
  if (options.scale > 0) object.set_scale(options.scale);
  auto built = build_object(object, "", 0, options.asset.filename().string(), WorldSettings{});
  if (!built) return report(built.error());
  if (options.json) {
    google::protobuf::util::JsonPrintOptions print;
    print.add_whitespace = true;
    print.preserve_proto_field_names = true;
    std::string text;
    if (!google::protobuf::util::MessageToJsonString(built->drawn.physics, &text, print).ok()) {
      return report({ErrorCode::Internal, "the answer could not be written as JSON"});
    }
    std::fputs(text.c_str(), stdout);
  } else {
    print_parameters(built->drawn.physics);
  }
  return 0;
}

}  // namespace

void add_analyze(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<AnalyzeCommand>();
  CLI::App* command =
      app.add_subcommand("analyze", "Work out what an object is made of, with ranges and reasons");
  command->add_option("ASSET", options->asset, "A splat asset")->required();
  command->add_option("--name", options->name, "What it shows; the file's name when left out");
  command->add_option("--scale", options->scale, "Metres per unit of the asset; guessed when left out");
  command->add_option("--up", options->up, "The asset's up axis: x -x y -y z -z")->default_str("-y");
  command->add_flag("--json", options->json, "Print livegs.v1.PhysicalParameters as JSON");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace livegs
