// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check/object_references.h"

#include <functional>
#include <vector>

namespace livegs {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// Calls `visit` for every string field that names an object, in a message and those in it.
void visit_references(Message& message, const std::function<void(std::string&)>& visit) {
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field->is_repeated()) {
      visit_references(*reflection->MutableMessage(&message, field), visit);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING && !field->is_repeated() &&
               (field->name() == "object" || field->name() == "other")) {
      std::string value = reflection->GetString(message, field);
      const std::string before = value;
      visit(value);
      if (value != before) reflection->SetString(&message, field, value);
    }
  }
}

}  // namespace

void rename_references(v1::Scene& scene, const std::string& from, const std::string& to) {
  const auto rename = [&](std::string& name) {
    if (name == from) name = to;
  };
  for (v1::Event& event : *scene.mutable_events()) visit_references(event, rename);
  for (v1::Joint& joint : *scene.mutable_joints()) visit_references(joint, rename);
}

std::string reference_to(const v1::Scene& scene, const std::string& name) {
  std::string found;
  const auto look = [&](auto one, const char* list, int index) {
    visit_references(one, [&](std::string& named) {
      if (named == name && found.empty()) found = std::string(list) + "[" + std::to_string(index) + "]";
    });
  };
  for (int i = 0; i < scene.events_size(); ++i) look(scene.events(i), "events", i);
  for (int i = 0; i < scene.joints_size(); ++i) look(scene.joints(i), "joints", i);
  return found;
}

}  // namespace livegs
