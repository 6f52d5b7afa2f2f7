// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "material/part_places.h"
#include "stream/received/received.h"
#include "viewer/panels/parameter_slider.h"
#include "xr/window/window_panels.h"

namespace livegs {

// Panel texts of an object.
ObjectsPanel::Entry list_entry(const StreamedObject& object);
// Classification and confidence, current state, and accuracy of the stiffness; one line each. `with_parts`:
// and its parts.
std::vector<std::string> object_facts(const StreamedObject& object, bool with_parts = true);
// Effect of accepting a model's reply: "5.0 kg (4.5 to 5.5 kg) of softwood, rigid".
std::string proposal_text(const v1::PhysicalParameters& proposal);
ValueRow value_row(SliderParameter field, const v1::PhysicalParameters& physics);

// Requests to the server.
struct SetPhysicsCall {
  std::string object;
  v1::Physics physics;
};
// Removes values that were set by hand.
struct RestoreEstimateCall {
  std::string object;
  std::vector<std::string> fields;  // of Physics
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
  std::vector<std::string> objects;  // empty: all objects marked for analysis
};
using ObjectCall =
    std::variant<SetPhysicsCall, RestoreEstimateCall, AcceptProposalCall, UndoPhysicsCall, AnalyzeCall>;

// State of the objects panel: the selection and the server's replies. Makes no calls. Renderer thread.
class ObjectPanel {
 public:
  using Objects = std::map<uint32_t, StreamedObject>;  // by id
  // Bounds of an object in its own frame at rest, metres; empty while they are unknown.
  using RestBounds = std::function<Eigen::AlignedBox3d(const StreamedObject&)>;

  // `rest_bounds` is called once an object whose parts are edited, and again after forget_bounds(); null:
  // parts cannot be added.
  explicit ObjectPanel(RestBounds rest_bounds = nullptr) : rest_bounds_(std::move(rest_bounds)) {}

  ObjectsPanel shown(const Objects& objects) const;
  // Returns the calls for the user's actions; invalid values are rejected here.
  std::vector<ObjectCall> act(const PanelActions& actions, const Objects& objects);

  // The selected object, if it is to be drawn in the colours of its parts; null: none.
  const StreamedObject* in_part_colours(const Objects& objects) const;
  // Boxes of the part that is edited, in the rest frame of the selected object and within its bounds; empty:
  // none are to be drawn.
  std::vector<Eigen::AlignedBox3d> marked_boxes(const Objects& objects) const;

  void forget_bounds(uint32_t object) { bounds_m_.erase(object); }  // its kernels have changed

  void select(const std::string& name);
  const std::string& selected() const { return selected_; }

  // Results of the calls.
  void take_reply(const std::string& object, const v1::PhysicsReply& reply);
  void take_refusal(const std::string& object, const std::string& why);
  void take_progress(const v1::AnalysisProgress& progress);
  void take_analysis_end(const std::string& why);  // empty: all are finished

 private:
  // The parts with all edits, of which the server may not have answered some, or the stream not shown.
  MaterialParts parts_of(const StreamedObject& object) const;
  PartsPanel division_of(const StreamedObject& object) const;
  Eigen::AlignedBox3d bounds_of(const StreamedObject& object) const;
  std::optional<ObjectCall> edit_parts(const PartEdit& edit, const StreamedObject& object);
  void await_reply(const std::string& object);
  // Counts an answer about the object. Returns whether it was the last one that was missing.
  bool take_answer(const std::string& object);
  // Edits of parts whose calls are all answered are those that the server accepted.
  void settle_parts(const std::string& object);
  void drop_streamed_parts(const Objects& objects);  // that the stream shows, or that another client changed
  void refuse(const std::string& object, const std::string& why);
  std::string open_proposal(
      const StreamedObject& object) const;  // in words; empty when there is none to answer

  std::string selected_;  // by name, which is stable across a reset
  std::map<std::string, std::vector<ObjectsPanel::Message>> messages_;
  // Proposals accepted or declined here, by object, until the server confirms.
  std::map<std::string, std::string> answered_;
  std::string waiting_;  // object of a change that awaits its reply
  std::string progress_;
  bool shows_parts_ = false;
  bool edits_parts_ = false;  // the section is open
  size_t part_ = 0;           // that is edited
  struct PartsSent {
    MaterialParts parts;                    // with all edits
    std::vector<MaterialParts> passed;      // that the stream may show before: without edits, and by replies
    std::optional<MaterialParts> accepted;  // by the last reply
  };
  std::map<std::string, PartsSent> sent_;  // by object, until the stream shows the last edit
  RestBounds rest_bounds_;
  std::map<uint32_t, Eigen::AlignedBox3d> bounds_m_;  // by object
  std::map<std::string, int> unanswered_;             // calls, by object; none: no entry
};

}  // namespace livegs
