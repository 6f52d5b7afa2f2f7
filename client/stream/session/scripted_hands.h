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

// Reads an InputScript from a JSON file. Errors name the file and the field.
Result<v1::InputScript> read_script_file(const std::filesystem::path& path);

// The script of `--poke NAME`: at 1 s the ray grabs the object, pulls the hit point up and releases; balls
// follow at 3.5 s and 4.5 s.
v1::InputScript poke_script(const std::string& object);

// Centre of a named object and the length of its longest side.
struct ObjectExtent {
  Eigen::Vector3d middle_m;
  double size_m = 0;
};

// Plays a script: the right hand pokes, the left hand shoots and grabs. Not thread-safe.
class ScriptedHands {
 public:
  struct Settings {
    Eigen::Vector3d eye_m;        // default origin of a ray or ball
    double ball_speed_m_s = 6.0;  // as reported by the server, for aiming
  };
  ScriptedHands(v1::InputScript script, const Settings& settings);

  // The hands at `time_s`, which must not decrease. `locate` is called once per action, at its start; an
  // action whose object is missing is skipped.
  using Locate = std::function<std::optional<ObjectExtent>(const std::string& object)>;
  InputSample at(double time_s, const Locate& locate);

  bool done(double time_s) const;  // no action remains

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
  InputSample sample_;  // hands keep their last pose
  uint64_t last_shot_sequence_ = 0;
};

}  // namespace livegs
