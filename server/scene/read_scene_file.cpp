// SPDX-License-Identifier: GPL-3.0-or-later
#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "scene/check_scene.h"
#include "scene/scene.h"

namespace livegs {

Result<v1::Scene> read_scene_file(const std::filesystem::path& path) {
  auto text = read_text_file(path, 16 << 20);
  if (!text) return text.error();
  const std::string name = path.filename().string();

  // nlohmann-json knows comments and says where a mistake stands; protobuf knows the schema.
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(*text, nullptr, true, true);
  } catch (const nlohmann::json::parse_error& error) {
    std::string what = error.what();
    if (const size_t colon = what.find("] "); colon != std::string::npos) what = what.substr(colon + 2);
    return invalid_data(name + ": is not JSON: " + what);
  }
  if (!json.is_object()) return invalid_data(name + ": must hold one JSON object, a scene");

  v1::Scene scene;
  const auto status = google::protobuf::util::JsonStringToMessage(json.dump(), &scene);
  if (!status.ok()) {
    std::string what(status.message());
    for (char& letter : what) {
      if (letter == '\n') letter = ' ';
    }
    return invalid_data(name + ": " + what + " (field names are those of proto/livegs/v1/scene.proto)");
  }
  if (auto checked = check_scene(scene); !checked)
    return Error{checked.error().code, name + ": " + checked.error().message};
  return scene;
}

}  // namespace livegs
