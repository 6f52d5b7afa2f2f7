// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/text/message_templates.h"

// Tools for a language model's questions about one object. Every function is total: any arguments give a JSON
// object, {"error": ...} if they are invalid. Tools read the tables and the facts of the object and its
// scene. They do not access files, a shell or the network. Pure; any thread.

namespace livegs {

// Another object of the scene, as described to the model.
struct SceneObjectFacts {
  std::string name;      // from a user or a file; quoted before it is sent to a model
  std::string material;  // empty if unknown
  std::string behavior;  // "rigid", "elastic", "static"
  double mass_kg = 0;    // 0 if unknown
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double distance_m = 0;  // from the object in question
  bool analysed = false;  // by a model or a user, not offline
};

// Name and parameters of one tool; its purpose is in prompts/tools.json.
struct ToolDescriptor {
  std::string name;
  std::string parameters;  // a JSON schema of the portable strict subset
};

class ToolBox {
 public:
  ToolBox() = default;
  // `words` must outlive the tool box.
  explicit ToolBox(ObjectFacts object, std::vector<SceneObjectFacts> scene = {},
                   const MessageTemplates& words = MessageTemplates::built_in());

  static const std::vector<ToolDescriptor>& descriptors();

  // Calls a tool with arguments as received from the model. The result has at most 4 KiB.
  std::string call(std::string_view tool, std::string_view arguments) const;

  const ObjectFacts& object() const { return object_; }
  const std::vector<SceneObjectFacts>& scene() const { return scene_; }
  const MessageTemplates& words() const { return *words_; }

 private:
  ObjectFacts object_;
  std::vector<SceneObjectFacts> scene_;
  const MessageTemplates* words_ = &MessageTemplates::built_in();
};

}  // namespace livegs
