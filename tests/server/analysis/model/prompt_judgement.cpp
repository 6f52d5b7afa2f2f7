// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/model/prompt_judgement.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/content_hash.h"
#include "core/file.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kFormat = "livegs.judgement/1";
constexpr std::uint64_t kMaxBytes = 1 << 20;
// Hash of the prompts of version 6, written before a model was available. Only this version may lack
// measurements.
constexpr const char* kUnjudged = "3afaa94a8441c7f8b9942e1d55b15ab8060b1e5e4f72093f39cdc03ab1221932";
constexpr const char* kHow =
    "judge it: mass_harness --judge OLD_PROMPTS prompts --record ANSWERS --keep prompts/judged.json, with a "
    "model's "
    "endpoint set (prompts/README.md)";

std::string text_of(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

Result<PromptFiles> prompt_files(const fs::path& folder) {
  PromptFiles files;
  std::vector<fs::path> paths;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string name = entry.path().filename().string();
    if (name != "README.md" && name != "judged.json" && !name.starts_with('.')) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::string everything;
  for (const fs::path& path : paths) {
    const auto text = read_text_file(path, kMaxBytes);
    if (!text) return text.error();
    const std::string name = path.filename().string();
    if (name == "version.txt") files.version = text->substr(0, text->find_first_of(" \n\r"));
    everything += name + "\n" + std::to_string(text->size()) + "\n" + *text;
  }
  if (files.version.empty()) {
    return invalid_data(
        folder.string() +
        ": incomplete prompt folder, version.txt is missing; copy prompts/ and edit the copy");
  }
  files.sha256 = content_hash(std::as_bytes(std::span(everything)));
  return files;
}

Result<std::string> judgement_text(const fs::path& before_folder, const fs::path& after_folder,
                                   const PromptTrial& before, const PromptTrial& after,
                                   const std::string& name_given) {
  if (before.model != after.model) {
    return invalid_data("the prompts were judged by different models, " + before.model + " and " +
                        after.model + "; use one model for both");
  }
  if (after.model.starts_with(kMadeUpModel)) {
    return invalid_data(after.model + ": its answers are synthetic and not evidence; use a real model");
  }
  const auto old_files = prompt_files(before_folder), new_files = prompt_files(after_folder);
  if (!old_files) return old_files.error();
  if (!new_files) return new_files.error();
  const PromptComparison comparison = compare_prompts(before, after);
  ordered_json json = {
      {"format", kFormat},
      {"version", new_files->version},
      {"prompts_sha256", new_files->sha256},
      {"compared_with", {{"version", old_files->version}, {"prompts_sha256", old_files->sha256}}},
      {"model", after.model},
      {"objects", after.outcomes.size()},
      {"name_given", name_given},
      {"verdict", verdict_name(comparison.verdict)},
      {"figures", ordered_json::array()}};
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
  for (const PromptMeasure& row : comparison.measures) {
    json["figures"].push_back({{"name", row.name},
                               {"before", rounded(row.before)},
                               {"after", rounded(row.after)},
                               {"change", rounded(row.change.value)},
                               {"change_low", rounded(row.change.low)},
                               {"change_high", rounded(row.change.high)},
                               {"verdict", verdict_name(row.verdict)}});
  }
  return json.dump(1) + "\n";
}

Result<void> check_judgement(const fs::path& folder) {
  const auto files = prompt_files(folder);
  if (!files) return files.error();
  const auto text = read_text_file(folder / "judged.json", kMaxBytes);
  if (!text) return text.error();
  const ordered_json json = ordered_json::parse(*text, nullptr, false);
  if (!json.is_object() || text_of(json, "format") != kFormat) {
    return invalid_data("prompts/judged.json: not a judgement (" + std::string(kFormat) + "); " + kHow);
  }
  const std::string version = text_of(json, "version"), model = text_of(json, "model");
  if (text_of(json, "prompts_sha256") != files->sha256) {
    if (version == files->version) {
      return invalid_data("prompts: changed, but prompts/version.txt is still " + version +
                          "; increase it and " + kHow);
    }
    return invalid_data("prompts: have version " + files->version +
                        ", but prompts/judged.json is for version " + version + "; " + kHow);
  }
  if (version != files->version) {
    return invalid_data("prompts/judged.json: has version " + version + ", but prompts/version.txt has " +
                        files->version + "; " + kHow);
  }
  if (model.empty() && files->sha256 == kUnjudged) return {};
  const auto figures = json.find("figures");
  if (model.empty() || figures == json.end() || !figures->is_array() || figures->empty()) {
    return invalid_data("prompts/judged.json: has no measurements of a model for version " + version + "; " +
                        kHow);
  }
  if (model.starts_with(kMadeUpModel)) {
    return invalid_data("prompts/judged.json: its answers are synthetic (" + model + "); " + kHow);
  }
  if (text_of(json, "verdict") != "better" && text_of(json, "verdict") != "same") {
    return invalid_data("prompts/judged.json: version " + version +
                        " is worse than the previous one; revert the change, or correct it and " + kHow);
  }
  return {};
}

}  // namespace livegs
