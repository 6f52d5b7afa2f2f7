// SPDX-License-Identifier: Apache-2.0
// Accuracy of mass estimates for objects of known mass: one row for each combination of known facts.
//   mass_harness OUTPUT_FOLDER
// writes mass.csv (figures with 95 % bootstrap intervals) and mass_objects.csv (each object, metric, from its
// kernels), and prints a summary of both. The rows "answer" are of a model's answers, replayed
// (replayed_answers.h), 16 about each object.
//   mass_harness --list LIST.csv
// prints the figures for a list of weighed objects with name, size and volume, columns
// name,mass_kg,box_m3,filled_share, to check the ranges beyond the 26 objects. Names without information are
// counted.
//   mass_harness --judge BEFORE AFTER ...
// compares two folders of prompts (judge_prompts.h).
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "analysis/estimate/object_classes.h"
#include "bench/support/judge_prompts.h"
#include "bench/support/time_of.h"
#include "server/analysis/estimate/known_objects.h"
#include "server/analysis/gate/replayed_answers.h"

using namespace livegs;

namespace {

struct Row {
  const char* name;
  Figure MassScores::*figure;
  double factor;
};
constexpr Row kRows[] = {{"mape_percent", &MassScores::mape, 100},
                         {"median_ape_percent", &MassScores::median_ape, 100},
                         {"max_ape_percent", &MassScores::max_ape, 100},
                         {"ade_kg", &MassScores::ade_kg, 1},
                         {"alde", &MassScores::alde, 1},
                         {"mnre", &MassScores::mnre, 1},
                         {"within_25_percent_percent", &MassScores::within_25, 100},
                         {"within_2x_percent", &MassScores::within_2x, 100},
                         {"coverage_percent", &MassScores::coverage, 100},
                         {"median_high_over_low", &MassScores::width, 1},
                         {"high_over_low_needed_for_95_percent", &MassScores::width_needed, 1}};

// One line of mass.csv, and of the summary.
void write_scores(std::ofstream& out, const char* form, const char* name, const char* scale, size_t objects,
                  const MassScores& scores) {
  out << form << ',' << name << ',' << scale << ',' << objects;
  std::printf("%-6s %-17s %-7s", form, name, scale);
  for (const Row& row : kRows) {
    const Figure& f = scores.*row.figure;
    char cells[80];
    std::snprintf(cells, sizeof cells, ",%.4g,%.4g,%.4g", row.factor * f.value, row.factor * f.low,
                  row.factor * f.high);
    out << cells;
    std::printf(" %6.3g", row.factor * f.value);
  }
  out << '\n';
  std::printf("\n");
}

void write_header(std::ofstream& out) {
  out << "form,name_given,scale,objects";
  for (const Row& row : kRows) out << ',' << row.name << ',' << row.name << "_low," << row.name << "_high";
  out << '\n';
}

// A mesh with the usual proportions of its kind, the given bounding box, and the given filled share of it.
MeshFacts listed_mesh(const ObjectRow& row, double box_m3, double filled_share) {
  MeshFacts mesh;
  const Eigen::Vector3d usual_m(row.size_m.best, row.middle_m, row.short_m);
  const Eigen::Vector3d box_m = std::cbrt(box_m3 / usual_m.prod()) * usual_m;
  mesh.size_m = mesh.box_m = mesh.principal_size_m = box_m;
  mesh.volume_m3 = filled_share * box_m3;
  mesh.area_m2 = 2 * (box_m.x() * box_m.y() + box_m.y() * box_m.z() + box_m.z() * box_m.x());
  mesh.mean_wall_m = 2 * mesh.volume_m3 / mesh.area_m2;
  mesh.hull_volume_m3 = box_m3 * std::max(filled_share, 0.6);
  mesh.solidity = mesh.volume_m3 / mesh.hull_volume_m3;
  mesh.piece_count = 1;
  return mesh;
}

int score_list(const char* path) {
  std::ifstream file(path);
  std::vector<MassAnswer> answers;
  size_t unknown = 0;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    MassAnswer answer;
    double box_m3 = 0, filled_share = 0;
    char comma;
    std::getline(cells, answer.id, ',');
    if (!(cells >> answer.true_kg >> comma >> box_m3 >> comma >> filled_share)) continue;
    ObjectFacts facts;
    facts.name = answer.id;
    facts.scale_known = true;
    const NameMatch match = match_name(facts.name);
    if (!match.row) {
      ++unknown;
      continue;
    }
    facts.mesh = listed_mesh(*match.row, box_m3, filled_share);
    const v1::EstimatedValue mass = estimate_offline(facts).mass_kg();
    answer.low_kg = mass.low();
    answer.best_kg = mass.best();
    answer.high_kg = mass.high();
    answers.push_back(answer);
  }
  if (answers.empty()) {
    std::fprintf(stderr, "%s: no row name,mass_kg,box_m3,filled_share with a known name\n", path);
    return 1;
  }
  const MassScores scores = mass_scores(answers);
  std::printf("%zu objects; %zu skipped, because their names give no information\n", answers.size(), unknown);
  for (const Row& row : kRows) {
    const Figure& f = scores.*row.figure;
    std::printf("%-26s %7.3g (%.3g to %.3g)\n", row.name, row.factor * f.value, row.factor * f.low,
                row.factor * f.high);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--list") return score_list(argv[2]);
  if (argc >= 2 && std::string(argv[1]) == "--judge") return judge_prompts({argv + 2, argv + argc});
  if (argc != 2) {
    std::fprintf(stderr, "usage: mass_harness OUTPUT_FOLDER | --list LIST.csv | %s\n", kJudgeUsage);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  if (known_objects(KnownForm::Splats).empty()) {
    std::fprintf(stderr, "shared/data/ycb: not found; it must be next to this checkout\n");
    return 1;
  }
  std::ofstream figures(folder / "mass.csv"), each(folder / "mass_objects.csv");
  write_header(figures);
  each << "id,name_given,name,mass_kg,low_kg,best_kg,high_kg,label,material,reason\n";
  std::printf("%-6s %-17s %-7s %6s %6s %6s %6s %6s %6s %6s %6s %6s %6s %6s\n", "form", "name", "scale",
              "MAPE", "median", "max", "ADE", "ALDE", "MnRE", "<25%", "<2x", "cover", "width", "need");
  for (const KnownForm form : {KnownForm::Splats, KnownForm::Mesh}) {
    const auto& objects = known_objects(form);
    for (const bool metric : {true, false}) {
      for (int name = 0; name < 4; ++name) {
        const auto answers = estimate_known(objects, static_cast<NameGiven>(name), metric);
        const MassScores scores = mass_scores(answers);
        const char* form_name = form == KnownForm::Splats ? "splats" : "mesh";
        const char* scale_name = metric ? "metric" : "guessed";
        write_scores(figures, form_name, kNameGiven[name], scale_name, scores.count, scores);
        if (form != KnownForm::Splats || !metric) continue;
        for (size_t i = 0; i < answers.size(); ++i) {
          ObjectFacts facts = objects[i].facts;
          const std::string given[] = {objects[i].label, objects[i].noun, objects[i].id, ""};
          facts.name = given[name];
          const auto p = estimate_offline(facts);
          char cells[160];
          std::snprintf(cells, sizeof cells, "%.4g,%.4g,%.4g,%.4g", answers[i].true_kg, answers[i].low_kg,
                        answers[i].best_kg, answers[i].high_kg);
          std::string reason = p.mass_kg().reason();
          std::replace(reason.begin(), reason.end(), ',', ';');
          each << objects[i].id << ',' << kNameGiven[name] << ',' << facts.name << ',' << cells << ','
               << p.label() << ',' << p.material() << ',' << reason << '\n';
        }
      }
    }
  }
  // Answers of a model, replayed.
  constexpr int kRepeats = 16;
  for (const KnownForm form : {KnownForm::Splats, KnownForm::Mesh}) {
    for (const NameGiven name : {NameGiven::Label, NameGiven::None}) {
      const std::vector<MassAnswer> answers = replay_answers(known_objects(form), name, kRepeats);
      write_scores(figures, form == KnownForm::Splats ? "splats" : "mesh",
                   name == NameGiven::Label ? "label and answer" : "answer", "metric",
                   known_objects(form).size(), mass_scores(answers));
    }
  }
  // Time of an estimate after the facts have been computed.
  const auto& objects = known_objects(KnownForm::Splats);
  const auto times = bench::time_of(1, 20, [&] {
    for (const KnownObject& object : objects) {
      ObjectFacts facts = object.facts;
      estimate_offline(facts);
    }
  });
  const auto count = static_cast<double>(objects.size());
  std::printf("time of an estimate without a name: %.3f ms\n", times.median_ms / count);
  std::ofstream(folder / "estimate_time.csv")
      << "name_given,objects,median_ms_an_object,p99_ms_an_object,cpu_ms_an_object,bar_ms\n"
      << "none," << objects.size() << ',' << times.median_ms / count << ',' << times.p99_ms / count << ','
      << times.cpu_ms / count << ",300\n";
  return 0;
}
