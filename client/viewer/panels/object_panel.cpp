// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/object_panel.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/text/format_text.h"
#include "viewer/panels/part_list.h"

namespace livegs {
namespace {

constexpr size_t kMaxReasonLength = 150;  // characters

const char* behavior_text(v1::Physics::Behavior behavior) {
  switch (behavior) {
    case v1::Physics::STATIC:
      return "static";
    case v1::Physics::ELASTIC:
      return "elastic";
    case v1::Physics::RIGID:
      return "rigid";
    default:
      return "unknown";
  }
}

const char* fill_text(v1::Physics::Fill fill) {
  switch (fill) {
    case v1::Physics::SOLID:
      return ", solid";
    case v1::Physics::SHELL:
      return ", hollow";
    case v1::Physics::OPEN_SHELL:
      return ", an open shell";
    case v1::Physics::FILLED:
      return ", a filled container";
    default:
      return "";
  }
}

// Shortens a text at a word boundary.
std::string shortened(const std::string& reason) {
  if (reason.size() <= kMaxReasonLength) return reason;
  const size_t space = reason.rfind(' ', kMaxReasonLength - 3);
  return reason.substr(0, space == std::string::npos ? kMaxReasonLength - 3 : space) + " ...";
}

std::string stiffness_text(const v1::ElasticAccuracy& elastic) {
  const std::string asked = quantity_text(elastic.youngs_modulus_pa(), Unit::Pascal);
  switch (elastic.band()) {
    case v1::ElasticAccuracy::EXACT:
      return asked + ", simulated within 5 %";
    case v1::ElasticAccuracy::BAND:
      return asked + format_text(", simulated at %.2f to %.2f times that", elastic.modulus_ratio_low(),
                                 elastic.modulus_ratio_high());
    case v1::ElasticAccuracy::CLIPPED:
      return asked + " is too stiff for this rate; " +
             quantity_text(elastic.reached_youngs_modulus_pa(), Unit::Pascal) + " is simulated";
    default:
      return asked + " is simulated; its accuracy is unknown";
  }
}

std::string part_text(const v1::MaterialPart& part) {
  return part.name() + " of " + part.material() + format_text(" (%.0f %%)", 100 * part.mass_share());
}

std::optional<std::array<double, 3>> corner_of(const google::protobuf::RepeatedField<double>& numbers) {
  if (numbers.size() != 3) return std::nullopt;
  return std::array{numbers[0], numbers[1], numbers[2]};
}

v1::MaterialPart::Box box_of(const PartsPanel::Box& box) {
  v1::MaterialPart::Box written;
  if (box.min_m) written.mutable_min_m()->Add(box.min_m->begin(), box.min_m->end());
  if (box.max_m) written.mutable_max_m()->Add(box.max_m->begin(), box.max_m->end());
  return written;
}

// Whether its parts have places, which are known in the rest frame of the whole object only.
bool has_placed_parts(const StreamedObject& object) {
  return object.rest.revision == 0 && object.physics.parts_size() > 1 &&
         PartPlaces(object.physics.parts()).divided();
}

const StreamedObject* named(const ObjectPanel::Objects& objects, const std::string& name) {
  for (const auto& [id, object] : objects) {
    if (object.name == name && !object.environment) return &object;
  }
  return nullptr;
}

std::vector<const StreamedObject*> listed(const ObjectPanel::Objects& objects) {
  std::vector<const StreamedObject*> list;
  for (const auto& [id, object] : objects) {
    if (!object.environment) list.push_back(&object);
  }
  return list;
}

}  // namespace

ObjectsPanel::Entry list_entry(const StreamedObject& object) {
  std::string kind = behavior_text(object.physics.behavior());
  if (!object.physics.material().empty()) kind = object.physics.material() + ", " + kind;
  if (object.fragility && object.fragility->bodies() > 1)
    kind += format_text(", in %u", object.fragility->bodies());
  return {object.name, kind, object.mass_kg > 0 ? quantity_text(object.mass_kg, Unit::Kilogram) : ""};
}

std::vector<std::string> object_facts(const StreamedObject& object, bool with_parts) {
  const v1::PhysicalParameters& physics = object.physics;
  std::vector<std::string> facts;
  if (!physics.label().empty()) {
    facts.push_back(object.name + ": likely " + physics.label() +
                    (physics.material().empty() ? "" : " of " + physics.material()) +
                    format_text(" (%.0f %%)", 100 * physics.confidence()));
  }
  std::string is = std::string(behavior_text(physics.behavior())) + fill_text(physics.fill());
  is.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(is.front())));
  if (!physics.behavior_reason().empty()) is += ": " + shortened(physics.behavior_reason());
  facts.push_back(is);
  std::string parts;
  for (const v1::MaterialPart& part : physics.parts()) {
    parts += (parts.empty() ? "Parts: " : ", ") + part_text(part);
  }
  if (with_parts && !parts.empty()) facts.push_back(parts);
  if (object.elastic) facts.push_back(stiffness_text(*object.elastic));
  if (object.fragility && object.fragility->bodies() > 1) {
    facts.push_back(format_text("Broken into %u fragments", object.fragility->bodies()));
  } else if (object.fragility && physics.fragile()) {  // a previously fragile object keeps its pieces
    facts.push_back(format_text("Up to %u fragments after a drop of %.2f m", object.fragility->pieces(),
                                object.fragility->drop_height_m()));
  }
  return facts;
}

std::string proposal_text(const v1::PhysicalParameters& proposal) {
  const v1::EstimatedValue& mass = proposal.mass_kg();
  return quantity_text(mass.best(), Unit::Kilogram) + " (" +
         range_text(mass.low(), mass.high(), Unit::Kilogram) + ")" +
         (proposal.material().empty() ? "" : " of " + proposal.material()) + ", " +
         behavior_text(proposal.behavior());
}

ValueRow value_row(SliderParameter field, const v1::PhysicalParameters& physics) {
  const v1::EstimatedValue value = shown_value(field, physics);
  const Unit unit = parameter_unit(field);
  ValueRow row;
  row.name = parameter_name(field);
  row.value = quantity_text(value.best(), unit);
  row.origin = source_text(value.source());
  if (value.high() > value.low()) row.origin += ", " + range_text(value.low(), value.high(), unit);
  row.edited = value.source() == v1::EstimatedValue::PERSON;
  if (!row.edited) row.reason = shortened(value.reason());
  const SliderRange range = slider_range(field, value);
  row.position = slider_position(range, value.best());
  row.range_low = slider_position(range, value.low());
  row.range_high = slider_position(range, value.high());
  row.text_at = [range, unit](double position) { return quantity_text(slider_value(range, position), unit); };
  return row;
}

ObjectsPanel ObjectPanel::shown(const Objects& objects) const {
  ObjectsPanel panel;
  for (const StreamedObject* object : listed(objects)) {
    if (object->name == selected_) panel.selected = panel.entries.size();
    panel.entries.push_back(list_entry(*object));
  }
  panel.progress = !waiting_.empty() ? waiting_ : progress_;
  const StreamedObject* object = named(objects, selected_);
  if (!object) return panel;
  if (object->rest.revision == 0) panel.division = division_of(*object);
  const bool edits = edits_parts_ && panel.division;
  if (has_placed_parts(*object)) {
    for (int i = 0; i < object->physics.parts_size(); ++i) {
      const Eigen::Vector3f rgb = part_rgb(static_cast<size_t>(i));
      panel.parts.push_back({part_text(object->physics.parts(i)), {rgb.x(), rgb.y(), rgb.z()}});
    }
    panel.parts_shown = shows_parts_ || edits;
  }
  panel.facts = object_facts(*object, panel.parts.empty() && !edits);  // else they are listed with colours
  for (const SliderParameter field : slider_parameters(object->physics))
    panel.rows.push_back(value_row(field, object->physics));
  if (object->physics.behavior() == v1::Physics::RIGID) panel.fragile = object->physics.fragile();
  if (const std::string proposal = open_proposal(*object); !proposal.empty())
    panel.proposal = "Proposed: " + proposal;
  if (const auto said = messages_.find(selected_); said != messages_.end()) panel.messages = said->second;
  for (const std::string& warning : object->warnings) {
    // The analysis in this window has already reported why a proposal needs review.
    std::erase_if(panel.messages, [&](const auto& one) {
      return !one.refusal && !one.text.empty() && warning.ends_with(": " + one.text);
    });
    panel.messages.push_back({false, shortened(warning)});
  }
  return panel;
}

const StreamedObject* ObjectPanel::in_part_colours(const Objects& objects) const {
  const StreamedObject* object = shows_parts_ || edits_parts_ ? named(objects, selected_) : nullptr;
  return object && has_placed_parts(*object) ? object : nullptr;
}

void ObjectPanel::select(const std::string& name) {
  if (name != selected_) part_ = 0;
  selected_ = name;
}

MaterialParts ObjectPanel::parts_of(const StreamedObject& object) const {
  const auto sent = sent_.find(object.name);
  return sent != sent_.end() ? sent->second.parts : PartList(object.physics.parts()).parts();
}

Eigen::AlignedBox3d ObjectPanel::bounds_of(const StreamedObject& object) const {
  const auto known = bounds_m_.find(object.id);
  return known == bounds_m_.end() ? Eigen::AlignedBox3d() : known->second;
}

PartsPanel ObjectPanel::division_of(const StreamedObject& object) const {
  PartsPanel panel;
  panel.object = object.name;
  const MaterialParts parts = parts_of(object);
  for (const v1::MaterialPart& part : parts) {
    const Eigen::Vector3f rgb = part_rgb(panel.parts.size());
    PartsPanel::Part& row = panel.parts.emplace_back();
    row.name = part.name();
    row.material = part.material();
    row.share = part.mass_share();
    row.rgb = {rgb.x(), rgb.y(), rgb.z()};
    for (const v1::MaterialPart::Box& box : part.boxes())
      row.boxes.push_back({corner_of(box.min_m()), corner_of(box.max_m())});
  }
  panel.selected = part_;
  panel.edited = object.physics.parts_source() == v1::EstimatedValue::PERSON;
  panel.full = parts.size() >= kMaxMaterialParts;
  if (const Eigen::AlignedBox3d body = bounds_of(object); !body.isEmpty())
    panel.body = PartsPanel::Box{{{body.min().x(), body.min().y(), body.min().z()}},
                                 {{body.max().x(), body.max().y(), body.max().z()}}};
  return panel;
}

std::vector<Eigen::AlignedBox3d> ObjectPanel::marked_boxes(const Objects& objects) const {
  const StreamedObject* object = edits_parts_ ? named(objects, selected_) : nullptr;
  if (!object || object->rest.revision > 0) return {};
  const MaterialParts parts = parts_of(*object);
  const Eigen::AlignedBox3d body = bounds_of(*object);
  if (part_ >= static_cast<size_t>(parts.size()) || body.isEmpty()) return {};
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const v1::MaterialPart::Box& written : parts[static_cast<int>(part_)].boxes()) {
    Eigen::AlignedBox3d box = part_box(written);
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(box.min()[axis])) box.min()[axis] = std::min(body.min()[axis], box.max()[axis]);
      if (!std::isfinite(box.max()[axis])) box.max()[axis] = std::max(body.max()[axis], box.min()[axis]);
    }
    boxes.push_back(box);
  }
  return boxes;
}

std::optional<ObjectCall> ObjectPanel::edit_parts(const PartEdit& edit, const StreamedObject& object) {
  using Kind = PartEdit::Kind;
  if (edit.kind == Kind::Estimate) {
    part_ = 0;
    sent_.erase(object.name);
    return RestoreEstimateCall{object.name, {"parts"}};
  }
  PartList list(parts_of(object));
  const Eigen::AlignedBox3d body = bounds_of(object);
  switch (edit.kind) {
    case Kind::Name:
      list.rename(edit.part, edit.text);
      break;
    case Kind::Material:
      list.set_material(edit.part, edit.text);
      break;
    case Kind::Share:
      list.set_share(edit.part, edit.share);
      break;
    case Kind::Add:
      list.add(object.physics.material(), body);
      part_ = static_cast<size_t>(std::max(list.parts().size() - 1, 0));
      break;
    case Kind::Remove:
      list.remove(edit.part);
      part_ = 0;
      break;
    case Kind::AddBox:
      list.add_box(edit.part, body);
      break;
    case Kind::RemoveBox:
      list.remove_box(edit.part, edit.box);
      break;
    default:
      list.move_box(edit.part, edit.box, box_of(edit.moved));
  }
  const MaterialParts before = parts_of(object);
  if (list == PartList(before)) return std::nullopt;
  PartsSent& sent = sent_[object.name];
  if (sent.passed.empty()) sent.passed.push_back(before);
  sent.parts = list.parts();
  SetPhysicsCall call{object.name, {}};
  *call.physics.mutable_parts() = list.parts();
  return call;
}

void ObjectPanel::await_reply(const std::string& object) {
  messages_[object].clear();
  waiting_ = "Changing " + object;
  ++unanswered_[object];
}

bool ObjectPanel::take_answer(const std::string& object) {
  const auto missing = unanswered_.find(object);
  const bool last = missing == unanswered_.end() || --missing->second <= 0;
  if (last && missing != unanswered_.end()) unanswered_.erase(missing);
  if (unanswered_.empty()) waiting_.clear();
  return last;
}

void ObjectPanel::settle_parts(const std::string& object) {
  const auto sent = sent_.find(object);
  if (sent == sent_.end()) return;
  if (sent->second.accepted)
    sent->second.parts = *sent->second.accepted;
  else
    sent_.erase(sent);
}

void ObjectPanel::drop_streamed_parts(const Objects& objects) {
  std::erase_if(sent_, [&](const auto& one) {
    const auto& [name, sent] = one;
    if (unanswered_.contains(name)) return false;
    const StreamedObject* object = named(objects, name);
    if (!object) return true;
    const PartList now(object->physics.parts());
    return now == PartList(sent.parts) ||
           std::none_of(sent.passed.begin(), sent.passed.end(),
                        [&](const MaterialParts& passed) { return now == PartList(passed); });
  });
}

std::string ObjectPanel::open_proposal(const StreamedObject& object) const {
  if (!object.proposal) return "";
  const std::string text = proposal_text(*object.proposal);
  const auto answered = answered_.find(object.name);
  return answered != answered_.end() && answered->second == text ? "" : text;
}

std::vector<ObjectCall> ObjectPanel::act(const PanelActions& actions, const Objects& objects) {
  std::vector<ObjectCall> calls;
  std::erase_if(answered_, [&](const auto& one) {
    const StreamedObject* answered = named(objects, one.first);
    return !answered || !answered->proposal;
  });
  drop_streamed_parts(objects);
  shows_parts_ = actions.show_parts.value_or(shows_parts_);
  edits_parts_ = actions.parts_open.value_or(edits_parts_);
  const std::vector<const StreamedObject*> list = listed(objects);
  const StreamedObject* object = named(objects, selected_);
  if (object) {
    const std::vector<SliderParameter> fields = slider_parameters(object->physics);
    const auto set = [&](v1::Physics physics) {
      calls.push_back(SetPhysicsCall{selected_, std::move(physics)});
      await_reply(selected_);
    };
    if (actions.released && actions.released->row < fields.size()) {
      const SliderParameter field = fields[actions.released->row];
      const SliderRange range = slider_range(field, shown_value(field, object->physics));
      set(edit_of(field, slider_value(range, actions.released->position)));
    }
    if (actions.typed && actions.typed->row < fields.size()) {
      const SliderParameter field = fields[actions.typed->row];
      const auto value = parse_quantity(actions.typed->text, parameter_unit(field));
      value ? set(edit_of(field, *value))
            : refuse(selected_, std::string(parameter_name(field)) + ": " + value.error().message);
    }
    if (actions.estimated && *actions.estimated < fields.size()) {
      calls.push_back(RestoreEstimateCall{selected_, fields_of(fields[*actions.estimated])});
      await_reply(selected_);
    }
    if (actions.fragile) set(edit_of_fragile(*actions.fragile));
    if (const std::string proposal = open_proposal(*object);
        (actions.accept || actions.decline) && !proposal.empty()) {
      answered_[selected_] = proposal;
      calls.push_back(AcceptProposalCall{selected_, !actions.accept});
      await_reply(selected_);
    }
    if (edits_parts_ && rest_bounds_ && bounds_of(*object).isEmpty())
      bounds_m_[object->id] = rest_bounds_(*object);
    if (actions.part_selected) part_ = *actions.part_selected;
    if (actions.undo || actions.redo) {
      calls.push_back(UndoPhysicsCall{selected_, actions.redo});
      sent_.erase(selected_);
      messages_[selected_].clear();
      ++unanswered_[selected_];
    }
    if (actions.analyse) calls.push_back(AnalyzeCall{{selected_}});
  }
  const StreamedObject* divided = actions.part_edit ? named(objects, actions.part_edit->object) : nullptr;
  if (divided) {
    if (auto call = edit_parts(*actions.part_edit, *divided)) {
      calls.push_back(*std::move(call));
      await_reply(divided->name);
    }
  }
  if (actions.analyse_all) calls.push_back(AnalyzeCall{});
  if (actions.analyse || actions.analyse_all) progress_ = "Analysing";
  if (actions.selected && *actions.selected < list.size()) select(list[*actions.selected]->name);
  return calls;
}

void ObjectPanel::take_reply(const std::string& object, const v1::PhysicsReply& reply) {
  std::vector<ObjectsPanel::Message>& said = messages_[object];
  said.clear();
  for (const std::string& warning : reply.warnings()) said.push_back({false, warning});
  if (const auto sent = sent_.find(object); sent != sent_.end() && reply.has_parameters()) {
    sent->second.accepted =
        PartList(reply.parameters().parts()).parts();  // a scene file may overrule the edit
    sent->second.passed.push_back(*sent->second.accepted);
  }
  if (take_answer(object)) settle_parts(object);
}

void ObjectPanel::take_refusal(const std::string& object, const std::string& why) {
  // A later edit may be what the refused one should have been, so it stays until it is answered.
  if (take_answer(object)) settle_parts(object);
  answered_.erase(object);  // the proposal is still open, or the server has reported that it is not
  refuse(object, why);
}

void ObjectPanel::refuse(const std::string& object, const std::string& why) {
  messages_[object] = {{true, why}};
}

void ObjectPanel::take_progress(const v1::AnalysisProgress& progress) {
  if (progress.stage() != v1::AnalysisProgress::FINISHED) {
    progress_ = "Analysing " + progress.object() +
                (progress.stage() == v1::AnalysisProgress::ASKED ? ": waiting for the model" : "");
    return;
  }
  progress_ = format_text("Analysed %u of %u: ", progress.finished(), progress.objects()) + progress.object();
  std::vector<ObjectsPanel::Message>& said = messages_[progress.object()];
  said.clear();
  answered_.erase(progress.object());  // a new reply, even with the same text
  if (!progress.message().empty()) said.push_back({false, progress.message()});
}

void ObjectPanel::take_analysis_end(const std::string& why) {
  progress_.clear();
  if (!why.empty() && !selected_.empty()) refuse(selected_, why);
}

}  // namespace livegs
