// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/prompt_set.h"

#include <algorithm>

#include "analysis/knowledge/tables.h"
#include "analysis/model/tool_box.h"
#include "analysis/text/prompt_slots.h"
#include "analysis/text/prompt_text.h"
#include "answer.schema.json.h"
#include "answer_in_text.md.h"
#include "answer_turn.md.h"
#include "captions.json.h"
#include "complaints.json.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "examples.json.h"
#include "facts.json.h"
#include "repair.md.h"
#include "search.md.h"
#include "system.md.h"
#include "tool_words.json.h"
#include "tools.json.h"
#include "tools_turn.md.h"
#include "user.md.h"
#include "version.txt.h"

namespace livegs {
namespace {

constexpr std::uint64_t kMaxPromptBytes = 1 << 20;
constexpr std::size_t kMaxProblemLength = 600;  // length of a validator's message, in characters
constexpr std::size_t kVersionDigits = 12;

struct BuiltIn {
  const char* name;
  const char* text;
  const char* slot;  // required slot; null: none
};
constexpr BuiltIn kBuiltIn[] = {{"system.md", kSystemPrompt, nullptr},
                                {"user.md", kUserPrompt, "{{name}}"},
                                {"examples.json", kExamplesPrompt, nullptr},
                                {"tools_turn.md", kToolsTurnPrompt, nullptr},
                                {"tools.json", kToolsPrompt, nullptr},
                                {"answer_turn.md", kAnswerTurnPrompt, nullptr},
                                {"answer_in_text.md", kAnswerInTextPrompt, "{{schema}}"},
                                {"captions.json", kCaptionsPrompt, nullptr},
                                {"repair.md", kRepairPrompt, "{{problem}}"},
                                {"search.md", kSearchPrompt, "{{name}}"},
                                {"facts.json", kFactsPrompt, nullptr},
                                {"complaints.json", kComplaintsPrompt, nullptr},
                                {"tool_words.json", kToolWordsPrompt, nullptr},
                                {"answer.schema.json", kAnswerSchemaPrompt, "{{material_ids}}"},
                                {"version.txt", kVersionPrompt, nullptr}};

Result<OrderedJson> parse_prompt_file(const std::string& text) {
  if (json_extent(text, 0, kMaxJsonDepth).depth > kMaxJsonDepth) return invalid_data("nested too deep");
  OrderedJson value = OrderedJson::parse(text, nullptr, false);
  if (value.is_discarded()) return invalid_data("not JSON");
  return value;
}

// Allowed slots of the lines of a file. The search uses the slots of the question.
SlotNames known_slots(std::string_view file) {
  SlotNames known, question;
  for (const BuiltIn& one : kBuiltIn) {
    if (one.name == file) known = slots_of(one.text);
    if (one.name == std::string_view("user.md")) question = slots_of(one.text);
  }
  question.erase("others");
  if (file == "search.md") known.merge(question);
  return known;
}

bool holds_lines(std::string_view file) {  // validated line by line
  return std::find(std::begin(MessageTemplates::kFiles), std::end(MessageTemplates::kFiles), file) !=
         std::end(MessageTemplates::kFiles);
}

// Reads a user's replacement of a file.
Result<std::string> read_own(const std::filesystem::path& path, const BuiltIn& file) {
  auto text = read_text_file(path, kMaxPromptBytes);
  if (!text) return text;
  if (file.slot && text->find(file.slot) == std::string::npos) {
    return invalid_data(path.string() + ": has no " + file.slot +
                        "; write it where the text belongs, or delete the file to use the built-in one");
  }
  if (holds_lines(file.name)) return text;
  if (auto checked = check_slots(*text, known_slots(file.name)); !checked) {
    return invalid_data(path.string() + ": " + checked.error().message);
  }
  return text;
}

// Reports files with unknown names: a mistyped name would leave the built-in text in effect.
void report_unknown_files(const std::filesystem::path& folder) {
  SlotNames names;
  for (const BuiltIn& file : kBuiltIn) names.emplace(file.name);
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
    const std::string name = entry.path().filename().string();
    if (names.contains(name) || name == "README.md" || name == "judged.json" || name.starts_with('.'))
      continue;
    const std::string meant = meant_word(name, names);
    log_warn("%s: ignored, no prompt has this name%s", line_text(entry.path().string(), 300).c_str(),
             meant.empty() ? "" : ("; if " + meant + " is meant, rename the file").c_str());
  }
}

// Fills the enumeration that represents the names of the material table.
void put_materials(OrderedJson& schema) {
  if (schema.is_array() && schema.size() == 1 && schema[0] == "{{material_ids}}") {
    schema.clear();
    for (const MaterialRow& row : material_table()) schema.push_back(row.name);
    return;
  }
  if (schema.is_structured()) {
    for (OrderedJson& inner : schema) put_materials(inner);
  }
}

std::string material_list() {
  std::string list;
  for (const MaterialRow& row : material_table()) list += (list.empty() ? "" : ", ") + row.name;
  return list;
}

// Whether a property of the schema may be null.
bool is_nullable(const OrderedJson& property) {
  if (property == "null") return true;
  for (const char* key : {"type", "anyOf"}) {
    const auto found = property.is_object() ? property.find(key) : property.end();
    if (!property.is_object() || found == property.end()) continue;
    if (*found == "null") return true;
    if (found->is_array() && std::any_of(found->begin(), found->end(), is_nullable)) return true;
  }
  return false;
}

}  // namespace

Result<PromptSet> PromptSet::load(const std::filesystem::path& folder) {
  PromptSet set;
  std::string everything;
  std::error_code failed;
  if (!folder.empty() && !std::filesystem::is_directory(folder, failed)) {
    return not_found(folder.string() + ": prompt folder not found; check --prompts");
  }
  const auto wrong = [&](const char* file, const std::string& what) {
    return invalid_data((folder / file).string() + ": " + what +
                        "; correct it, or delete the file to use the built-in one");
  };
  for (const BuiltIn& file : kBuiltIn) {
    std::string text = file.text;
    if (!folder.empty() && std::filesystem::exists(folder / file.name, failed)) {
      auto own = read_own(folder / file.name, file);
      if (!own) return own.error();
      text = std::move(*own);
    }
    everything += std::string(file.name) + "\n" + std::to_string(text.size()) + "\n" + text;
    set.texts_[file.name] = std::move(text);
  }
  if (!folder.empty()) report_unknown_files(folder);
  auto schema = parse_prompt_file(set.text("answer.schema.json"));
  if (!schema) return wrong("answer.schema.json", schema.error().message);
  put_materials(*schema);
  set.schema_ = std::move(*schema);
  const auto required = set.schema_.find("required");
  if (required == set.schema_.end() || !required->is_array()) {
    return wrong("answer.schema.json", "has no required properties");
  }
  for (const OrderedJson& field : *required) {
    if (!field.is_string()) continue;
    set.fields_.push_back(field.get<std::string>());
    const auto properties = set.schema_.find("properties");
    if (properties == set.schema_.end() || !properties->is_object() ||
        !is_nullable(properties->value(set.fields_.back(), OrderedJson())))
      set.needed_.push_back(set.fields_.back());
  }
  auto examples = parse_prompt_file(set.text("examples.json"));
  if (!examples) return wrong("examples.json", examples.error().message);
  if (!examples->is_array()) return wrong("examples.json", "must be a list of examples");
  for (const OrderedJson& example : *examples) {
    if (!example.is_object() || !example.contains("facts") || !example["facts"].is_string() ||
        !example.contains("answer")) {
      return wrong("examples.json", "an example needs \"facts\" (a string) and \"answer\"");
    }
  }
  set.examples_ = std::move(*examples);
  std::map<std::string, std::string> words;
  for (const char* file : MessageTemplates::kFiles) words[file] = set.text(file);
  auto read_words = MessageTemplates::read(words, folder);
  if (!read_words) return read_words.error();
  set.words_ = std::move(*read_words);
  auto captions = parse_json(set.text("captions.json"));
  if (!captions) return wrong("captions.json", captions.error().message);
  set.captions_ = std::move(*captions);
  auto descriptions = parse_json(set.text("tools.json"));
  if (!descriptions) return wrong("tools.json", descriptions.error().message);
  set.tools_ = OrderedJson::array();
  for (const ToolDescriptor& tool : ToolBox::descriptors()) {
    const std::string purpose = text_member(*descriptions, tool.name.c_str());
    if (purpose.empty()) return wrong("tools.json", "tool " + tool.name + " has no purpose");
    set.tools_.push_back({{"type", "function"},
                          {"function",
                           {{"name", tool.name},
                            {"description", purpose},
                            {"parameters", OrderedJson::parse(tool.parameters)}}}});
    everything += tool.name + tool.parameters;
  }
  for (const MaterialRow& row : material_table()) everything += row.name + "\n";
  std::string number = plain_text(set.text("version.txt"), 20);
  while (!number.empty() && number.back() == '\n') number.pop_back();
  set.version_ = number + "-" + content_hash(std::as_bytes(std::span(everything))).substr(0, kVersionDigits);
  return set;
}

std::string PromptSet::system(int example_count) const {
  std::string system = fill_slots(text("system.md"), {{"material_ids", material_list()}});
  for (int i = 0; i < std::min(example_count, this->example_count()); ++i) {
    const OrderedJson& example = examples_[static_cast<std::size_t>(i)];
    system += "\n" + example["facts"].get<std::string>() + "\n" + dump_json(example["answer"]) + "\n";
  }
  return system;
}

std::string PromptSet::user(std::map<std::string, std::string> slots) const {
  const std::string& form = text("user.md");
  std::string others;
  for (auto& [slot, value] : slots) {
    value = slot == "name" && !value.empty() ? quoted_text(value) : plain_text(value);
    if (form.find("{{" + slot + "}}") == std::string::npos && !value.empty()) {
      others += quoted_text(slot) + ": " + value + "\n";
    }
  }
  slots["others"] = others;
  return fill_slots(form, slots);
}

std::string PromptSet::tools_turn() const { return text("tools_turn.md"); }

std::string PromptSet::answer_turn(bool schema_in_words) const {
  if (!schema_in_words) return text("answer_turn.md");
  return fill_slots(text("answer_in_text.md"), {{"schema", dump_json(schema_)}});
}

std::string PromptSet::repair(std::string_view problem) const {
  return fill_slots(text("repair.md"), {{"problem", quoted_line(problem, kMaxProblemLength)}});
}

std::string PromptSet::caption(const std::string& name) const {
  const std::string words = text_member(captions_, name.c_str());
  return words.empty() ? name : words;
}

std::string PromptSet::search(const std::map<std::string, std::string>& slots) const {
  std::map<std::string, std::string> clean;
  for (const auto& [slot, value] : slots) {
    if (!value.empty()) clean[slot] = slot == "name" ? quoted_text(value) : plain_text(value, 200);
  }
  return fill_slots(text("search.md"), clean);
}

}  // namespace livegs
