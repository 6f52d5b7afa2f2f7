// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/text/message_templates.h"

// The functions a language model may call while it looks at one object. Every one is total: any arguments,
// however wrong, give a JSON object back, {"error": ...} where they make no sense. They read the tables and
// what is known of the object and its scene; none touches a file, a shell or the network. Pure; any thread.

namespace livegs {

// Another object of the scene, as the model is told of it.
struct SceneObjectFacts {
  std::string name;      // as a person or a file calls it; quoted before a model sees it
  std::string material;  // empty while nothing is known
  std::string behavior;  // "rigid", "elastic", "static"
  double mass_kg = 0;    // 0: not known
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double distance_m = 0;  // from the object asked about
  bool analysed = false;  // by a model or a person, rather than offline
};

// Name and parameters of one tool; what it is for is told in prompts/tools.json.
struct ToolDescriptor {
  std::string name;
  std::string parameters;  // a JSON schema of the portable strict subset
};

class ToolBox {
 public:
  ToolBox() = default;
  // `words` outlives it.
  explicit ToolBox(ObjectFacts object, std::vector<SceneObjectFacts> scene = {},
                   const MessageTemplates& words = MessageTemplates::built_in());

  static const std::vector<ToolDescriptor>& descriptors();

  // `arguments` as they came from the model. The answer is at most 4 KiB.
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
