// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/gate/gate.h"
#include "analysis/model/answer_cache.h"
#include "analysis/model/conversation.h"

// What the analysis of a scene (analyze_scene.h) is given of each object, and what it says of it.

namespace livegs {

struct AnalysisTarget {
  uint32_t object_id = 0;
  std::shared_ptr<const ObjectFacts> facts;
  // What it has without any model's answer: the estimate, a person's edits, the scene author's words (sources
  // PERSON and SCENE). Answers are asked for with it and weighed against it.
  v1::PhysicalParameters offline;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

// An object of the scene that is not asked about: told, or analysed before.
struct AnalysisNeighbour {
  std::shared_ptr<const ObjectFacts> facts;
  v1::PhysicalParameters known;  // what it has
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

// One look at an object.
struct TargetView {
  std::vector<AnalysisImage> images;              // what a model is shown
  std::string camera;                             // where it was taken from, in words, for a person
  AnalysisImage mask = {};                        // where the object is seen, for a person; may be empty
  std::map<std::string, std::string> slots = {};  // camera and object in figures, for the model: camera_slots
};
// Makes the looks, best first; called on threads of the analysis, for several objects at a time, while the
// model is still busy with those before.
using TargetViews =
    std::function<Result<std::vector<TargetView>>(uint32_t object_id, int count, std::stop_token stop)>;

enum class AnalysisStage {
  Offline,   // the estimate; nothing was asked yet
  Asked,     // the model has the question
  Repaired,  // its answer would not do; it was told why
  Finished,
};

// What passed between the model and the gate in one turn.
struct AnalysisTurn {
  AnalysisQuestion question;  // of a repair: empty
  std::string repair;         // what the model was told; empty for a question
  RawAnswer answer;
  std::string error;  // why the answer would not do; empty when it did
};

struct AnalysisUpdate {
  size_t index = 0;  // into the targets
  uint32_t object_id = 0;
  AnalysisStage stage = AnalysisStage::Offline;
  v1::PhysicalParameters parameters;  // the best that is known now
  // Of Finished. Refused, with a message, also when the model could not be asked at all.
  Judgement judgement;
  v1::AnalysisRecord record;  // model, prompt, gate, tokens; empty when no answer came
  std::vector<AnalysisTurn> turns;
  bool cached = false;
  bool cancelled = false;
  double views_s = 0;  // wall time of making its views
};

// How far back an object may see its neighbours' final answers: object i is told those of objects up to i -
// kContextLag, and offline estimates of the rest, so that what is asked does not depend on how fast answers
// come. It is also the most objects that are in flight at once.
inline constexpr size_t kContextLag = 4;
inline constexpr size_t kMaxNeighbours = 12;

struct AnalysisOptions {
  int views = 1;                                   // 1 or 3; more than one is a vote
  AnswerCache* cache = nullptr;                    // outlives the call
  std::vector<AnalysisNeighbour> neighbours = {};  // told to the model besides the targets themselves
  bool behind = true;          // pictures are drawn only with what others leave of the cores
  std::string prompt_version;  // part of what a cached answer belongs to
};

}  // namespace livegs
