// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/estimate/known_objects.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/knowledge/name_match.h"
#include "gaussian/asset_file.h"
#include "geometry/mesh/mesh_io.h"
#include "geometry/mesh/weld_vertices.h"
#include "geometry/reconstruct_surface.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultSize_m = 0.4;  // default size of place_asset() for an unknown name

struct Words {
  std::string label, noun;
};

std::map<std::string, Words> words_by_id() {
  std::map<std::string, Words> words;
  std::ifstream file(fs::path(LIVEGS_TESTS_DIR) / "server/analysis/estimate/known_objects.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string id, label, noun;
    std::getline(cells, id, ',');
    std::getline(cells, label, ',');
    std::getline(cells, noun, ',');
    words[id] = {label, noun};
  }
  return words;
}

// Returns empty facts for an unreadable file; the tests then fail on a mass of 0.
ObjectFacts facts_of(const fs::path& folder, KnownForm form) {
  ObjectFacts facts;
  facts.scale_known = true;
  if (form == KnownForm::Mesh) {
    if (const auto mesh = read_obj(folder / "textured.obj")) facts.mesh = mesh_facts(weld_vertices(*mesh));
    return facts;
  }
  const auto file = read_asset(folder / "splat.ply");
  if (!file) return facts;
  // +Z is up in these files, which does not affect mass.
  const auto surface = reconstruct_surface(body_points(file->asset, Similarity{}), elastic_surface_options());
  if (!surface) return facts;
  facts.mesh = mesh_facts(surface->mesh);
  facts.appearance = appearance_facts(file->asset);
  return facts;
}

std::vector<KnownObject> measure(KnownForm form) {
  std::vector<KnownObject> objects;
  const fs::path folder = fs::path(LIVEGS_SHARED_DATA_DIR) / "ycb";
  std::ifstream file(folder / "objects.json");
  if (!file) return objects;
  const auto words = words_by_id();
  const auto table = nlohmann::json::parse(file);
  for (const auto& entry : table["objects"]) {
    KnownObject object;
    object.id = entry["id"];
    object.label = words.at(object.id).label;
    object.noun = words.at(object.id).noun;
    object.mass_kg = entry["mass_kg"];
    object.elastic = entry["sim_category_guess"] == "elastic";
    object.asset = folder / object.id / "splat.ply";
    object.facts = facts_of(folder / object.id, form);
    objects.push_back(std::move(object));
  }
  return objects;
}

void scale(MeshFacts& mesh, double factor) {
  mesh.size_m *= factor;
  mesh.principal_size_m *= factor;
  mesh.mean_wall_m *= factor;
  mesh.area_m2 *= factor * factor;
  mesh.volume_m3 *= factor * factor * factor;
  mesh.hull_volume_m3 *= factor * factor * factor;
}

}  // namespace

const std::vector<KnownObject>& known_objects(KnownForm form) {
  static const std::vector<KnownObject> splats = measure(KnownForm::Splats);
  if (form == KnownForm::Splats) return splats;
  static const std::vector<KnownObject> meshes = measure(KnownForm::Mesh);
  return meshes;
}

std::vector<MassAnswer> estimate_known(const std::vector<KnownObject>& objects, NameGiven name, bool metric) {
  std::vector<MassAnswer> answers;
  for (const KnownObject& object : objects) {
    ObjectFacts facts = object.facts;
    if (name == NameGiven::Label) facts.name = object.label;
    if (name == NameGiven::Noun) facts.name = object.noun;
    if (name == NameGiven::FileName) facts.name = object.id;
    if (!metric) {
      const SizePrior prior = size_prior(facts.name);
      const double longest_m = prior.best_m > 0 ? prior.best_m : kDefaultSize_m;
      scale(facts.mesh, longest_m / facts.mesh.size_m.maxCoeff());
      facts.scale_known = false;
    }
    const auto p = estimate_offline(facts);
    answers.push_back({object.id, object.mass_kg, p.mass_kg().low(), p.mass_kg().best(), p.mass_kg().high()});
  }
  return answers;
}

}  // namespace livegs
