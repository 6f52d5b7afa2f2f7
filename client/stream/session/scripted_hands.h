// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/input_sample.h"
#include "core/result.h"
#include "livegs/v1/session.pb.h"

namespace livegs {

// An InputScript from a JSON file. Errors name the file and the field.
Result<v1::InputScript> read_script_file(const std::filesystem::path& path);

// What `--poke NAME` does: the ray takes the object at 1 s, draws the point it met up and lets go; balls
// follow at 3.5 s and 4.5 s.
v1::InputScript poke_script(const std::string& object);

// Where a named object is now and how long its longest side is.
struct ObjectExtent {
  Eigen::Vector3d middle_m;
  double size_m = 0;
};

// Plays a script as two hands would: the right one pokes, the left one shoots and grabs. Not locked.
class ScriptedHands {
 public:
  struct Settings {
    Eigen::Vector3d eye_m;        // where a ray or a ball starts unless the script says
    double ball_speed_m_s = 6.0;  // as the server says, to aim above the mark
  };
  ScriptedHands(v1::InputScript script, const Settings& settings);

  // The hands at `time_s`, which never goes back. `locate` is asked once an action, when it starts; an object
  // that is not there then is left alone.
  using Locate = std::function<std::optional<ObjectExtent>(const std::string& object)>;
  InputSample at(double time_s, const Locate& locate);

  bool done(double time_s) const;  // nothing more will happen

 private:
  struct Poke {
    v1::InputScript::Poke script;
    bool begun = false, missed = false;
    Pose aim;
    Eigen::Vector3d pull_m = Eigen::Vector3d::Zero();
    double start_s = 0, pull_s = 0, hold_s = 0;
    double end_s() const { return start_s + pull_s + hold_s; }
  };
  struct Grab {
    v1::InputScript::Grab script;
    bool begun = false, missed = false;
    Eigen::Vector3d from_m = Eigen::Vector3d::Zero(), move_m = Eigen::Vector3d::Zero();
    double move_s = 0, hold_s = 0;
    double end_s() const { return script.start_s() + move_s + hold_s; }
  };
  struct Ball {
    v1::InputScript::Ball script;
    bool shot = false;
  };

  void apply(Poke& poke, double time_s, const Locate& locate, HandSample& hand);
  void apply(Grab& grab, double time_s, const Locate& locate, HandSample& hand);
  void apply(Ball& ball, double time_s, const Locate& locate, HandSample& hand);

  Settings settings_;
  std::vector<Poke> pokes_;
  std::vector<Grab> grabs_;
  std::vector<Ball> balls_;
  InputSample sample_;  // hands stay where they were
  uint64_t last_shot_sequence_ = 0;
};

}  // namespace livegs
