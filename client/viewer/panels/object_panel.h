// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

#include "stream/received/received.h"
#include "viewer/panels/parameter_slider.h"
#include "xr/window/window_panels.h"

namespace livegs {

// An object in the words of a panel.
ObjectsPanel::Entry list_entry(const StreamedObject& object);
// What it was taken for, how sure that is, what it is now and how far its stiffness holds; a line each.
std::vector<std::string> object_facts(const StreamedObject& object);
// What a model's answer would make of it: "5.0 kg (4.5 to 5.5 kg) of softwood, rigid".
std::string proposal_text(const v1::PhysicalParameters& proposal);
ValueRow value_row(SliderParameter field, const v1::PhysicalParameters& physics);

// What is asked of the server.
struct SetPhysicsCall {
  std::string object;
  v1::Physics physics;
};
struct AcceptProposalCall {
  std::string object;
  bool decline = false;
};
struct UndoPhysicsCall {
  std::string object;
  bool redo = false;
};
struct AnalyzeCall {
  std::vector<std::string> objects;  // empty: all that are left to the analysis
};
using ObjectCall = std::variant<SetPhysicsCall, AcceptProposalCall, UndoPhysicsCall, AnalyzeCall>;

// The objects panel over time: which object is selected, what the server said of it. It makes no calls
// itself. On the drawer's thread.
class ObjectPanel {
 public:
  using Objects = std::map<uint32_t, StreamedObject>;  // by id

  ObjectsPanel shown(const Objects& objects) const;
  // The calls that follow what a person did; what cannot be a value is refused here.
  std::vector<ObjectCall> act(const PanelActions& actions, const Objects& objects);

  void select(const std::string& name) { selected_ = name; }
  const std::string& selected() const { return selected_; }

  // What became of them.
  void take_reply(const std::string& object, const v1::PhysicsReply& reply);
  void take_refusal(const std::string& object, const std::string& why);
  void take_progress(const v1::AnalysisProgress& progress);
  void take_analysis_end(const std::string& why);  // empty: all are finished

 private:
  void refuse(const std::string& object, const std::string& why);
  std::string open_proposal(
      const StreamedObject& object) const;  // in words; empty when there is none to answer

  std::string selected_;  // by name, which a reset does not change
  std::map<std::string, std::vector<ObjectsPanel::Message>> messages_;
  // Proposals that were accepted or declined here, by object, until the server says that they wait no longer.
  std::map<std::string, std::string> answered_;
  std::string waiting_;  // for the answer to a change of this object
  std::string progress_;
  int answers_missing_ = 0;
};

}  // namespace livegs
