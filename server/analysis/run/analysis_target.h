// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "analysis/division/picture_votes.h"
#include "analysis/estimate.h"
#include "analysis/gate/gate.h"
#include "analysis/model/answer_cache.h"
#include "analysis/model/conversation.h"

// Input and output of the analysis of a scene (analyze_scene.h), per object.

namespace livegs {

struct AnalysisTarget {
  uint32_t object_id = 0;
  std::shared_ptr<const ObjectFacts> facts;
  // Values without a model's answer: the estimate, a user's edits, the scene author's values (sources PERSON
  // and SCENE). Answers are requested with them and compared with them.
  v1::PhysicalParameters offline;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

// An object of the scene that is not queried: given by its author, or analysed before.
struct AnalysisNeighbour {
  std::shared_ptr<const ObjectFacts> facts;
  v1::PhysicalParameters known;  // its current values
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

// One view of an object.
struct TargetView {
  std::vector<AnalysisImage> images;              // pictures for the model
  std::string camera;                             // camera position in words, for users
  AnalysisImage mask = {};                        // visible part of the object, for users; may be empty
  std::map<std::string, std::string> slots = {};  // camera and object in numbers, for the model: camera_slots
  std::vector<PictureSights> sights = {};  // of `images`, in order; empty: parts cannot be placed by them
};
// Renders the views, best first. Called on analysis threads, for several objects concurrently, while the
// model processes earlier ones.
using TargetViews =
    std::function<Result<std::vector<TargetView>>(uint32_t object_id, int count, std::stop_token stop)>;

enum class AnalysisStage {
  Offline,   // the estimate; before any query
  Asked,     // the question was sent
  Repaired,  // the answer was faulty; a repair was requested
  Finished,
};

// One turn between the model and the gate.
struct AnalysisTurn {
  AnalysisQuestion question;  // empty for a repair
  std::string repair;         // the complaint sent to the model; empty for a question
  RawAnswer answer;
  std::string error;  // fault of the answer; empty if accepted
};

struct AnalysisUpdate {
  size_t index = 0;  // of the target
  uint32_t object_id = 0;
  AnalysisStage stage = AnalysisStage::Offline;
  v1::PhysicalParameters parameters;  // the best current values
  // Set at Finished. Also Refused, with a message, if the model could not be queried.
  Judgement judgement;
  v1::AnalysisRecord record;  // model, prompt, gate, tokens; empty without an answer
  std::vector<AnalysisTurn> turns;
  bool cached = false;
  bool cancelled = false;
  double views_s = 0;  // wall time of rendering its views
};

// Distance of neighbours whose final answers an object sees: object i gets those of objects up to i -
// kContextLag and offline estimates of the rest. A question therefore does not depend on the timing of
// answers. Also the maximum number of objects in flight. A change invalidates recordings.
inline constexpr size_t kContextLag = 4;
inline constexpr size_t kMaxNeighbours = 12;

struct AnalysisOptions {
  int views = 1;                                   // 1 or 3; more than one is combined by vote
  AnswerCache* cache = nullptr;                    // must outlive the call
  std::vector<AnalysisNeighbour> neighbours = {};  // described to the model in addition to the targets
  bool behind = true;                              // views are rendered at low priority, with idle cores only
  std::string prompt_version;                      // part of the cache key
};

}  // namespace livegs
