// SPDX-License-Identifier: Apache-2.0
#include "stream/session/scripted_hands.h"

#include <algorithm>
#include <cmath>

#include "core/clock.h"
#include "core/file.h"
#include "core/log.h"
#include "core/math/rotation_between.h"
#include "core/text/format_text.h"
#include "json/json_message.h"

namespace livegs {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

constexpr double kPull_s = 0.6, kHold_s = 0.4;
constexpr double kPullPerSize = 0.8;
constexpr double kGravity_m_s2 = 9.81;

Result<void> check_vector(const Numbers& numbers, const std::string& field, bool needed) {
  if (numbers.empty() && !needed) return {};
  if (numbers.size() != 3)
    return invalid_data(field + ": has " + std::to_string(numbers.size()) +
                        " numbers; give [x, y, z] in metres");
  for (double number : numbers) {
    if (!(std::abs(number) <= 1000.0))
      return invalid_data(field + format_text(": %g m is out of range; give -1000 to 1000 m", number));
  }
  return {};
}

Result<void> check_seconds(double seconds, const std::string& field) {
  if (seconds >= 0 && seconds <= 1e6) return {};
  return invalid_data(field + format_text(": %g s is out of range; give 0 to 1e6 s", seconds));
}

Result<void> check_script(const v1::InputScript& script) {
  for (int i = 0; i < script.actions_size(); ++i) {
    const v1::InputScript::Action& action = script.actions(i);
    const std::string field = "actions[" + std::to_string(i) + "]";
    std::vector<Result<void>> checks;
    if (action.has_poke()) {
      const auto& poke = action.poke();
      if (poke.object().empty())
        return invalid_data(field + ".poke.object: is missing; name the object to pull");
      checks = {check_seconds(poke.start_s(), field + ".poke.start_s"),
                check_seconds(poke.pull_s(), field + ".poke.pull_s"),
                check_seconds(poke.hold_s(), field + ".poke.hold_s"),
                check_vector(poke.from_m(), field + ".poke.from_m", false),
                check_vector(poke.pull_m(), field + ".poke.pull_m", false)};
    } else if (action.has_grab()) {
      const auto& grab = action.grab();
      if (grab.object().empty())
        return invalid_data(field + ".grab.object: is missing; name the object to grab");
      checks = {check_seconds(grab.start_s(), field + ".grab.start_s"),
                check_seconds(grab.move_s(), field + ".grab.move_s"),
                check_seconds(grab.hold_s(), field + ".grab.hold_s"),
                check_vector(grab.move_m(), field + ".grab.move_m", false)};
    } else if (action.has_ball()) {
      const auto& ball = action.ball();
      checks = {check_seconds(ball.time_s(), field + ".ball.time_s"),
                check_vector(ball.from_m(), field + ".ball.from_m", false)};
      if (ball.aim_case() == v1::InputScript::Ball::kPoint) {
        checks.push_back(check_vector(ball.point().position_m(), field + ".ball.point.position_m", true));
      } else if (ball.object().empty()) {
        return invalid_data(field + ".ball: has no target; give object or point");
      }
    } else {
      return invalid_data(field + ": does nothing; give poke, grab or ball");
    }
    for (const auto& check : checks) {
      if (!check) return check;
    }
  }
  return {};
}

Eigen::Vector3d vector_or(const Numbers& numbers, const Eigen::Vector3d& otherwise) {
  return numbers.size() == 3 ? Eigen::Vector3d(numbers[0], numbers[1], numbers[2]) : otherwise;
}

Pose aimed(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
  return {from_m, rotation_between(-Eigen::Vector3d::UnitZ(), direction)};
}

// The flatter of the two launch directions that hit the target at `speed`; straight at the target if it is
// out of reach or overhead. With height h and distance d: tan = (v² - sqrt(v⁴ - g (g d² + 2 h v²))) / (g d).
Eigen::Vector3d throw_direction(const Eigen::Vector3d& to_mark, double speed) {
  const double across = std::hypot(to_mark.x(), to_mark.z());
  const double squared = speed * speed;
  const double root =
      squared * squared - kGravity_m_s2 * (kGravity_m_s2 * across * across + 2 * to_mark.y() * squared);
  if (across < 1e-3 || root < 0) return to_mark.normalized();
  const double slope = (squared - std::sqrt(root)) / (kGravity_m_s2 * across);
  return Eigen::Vector3d(to_mark.x() / across, slope, to_mark.z() / across).normalized();
}

}  // namespace

Result<v1::InputScript> read_script_file(const std::filesystem::path& path) {
  auto text = read_text_file(path, 1 << 20);
  if (!text) return text.error();
  const std::string name = path.filename().string();
  v1::InputScript script;
  if (auto parsed = parse_json_message(*text, script); !parsed)
    return invalid_data(name + ": " + parsed.error().message);
  if (auto checked = check_script(script); !checked)
    return invalid_data(name + ": " + checked.error().message);
  return script;
}

v1::InputScript poke_script(const std::string& object) {
  v1::InputScript script;
  v1::InputScript::Poke& poke = *script.add_actions()->mutable_poke();
  poke.set_object(object);
  poke.set_start_s(1.0);
  for (double time_s : {3.5, 4.5}) {
    v1::InputScript::Ball& ball = *script.add_actions()->mutable_ball();
    ball.set_time_s(time_s);
    ball.set_object(object);
  }
  return script;
}

ScriptedHands::ScriptedHands(v1::InputScript script, const Settings& settings) : settings_(settings) {
  for (const v1::InputScript::Action& action : script.actions()) {
    if (action.has_ball()) balls_.push_back({action.ball(), false});
    if (action.has_grab()) {
      Grab grab;
      grab.script = action.grab();
      grab.move_s = grab.script.has_move_s() ? grab.script.move_s() : kPull_s;
      grab.hold_s = grab.script.has_hold_s() ? grab.script.hold_s() : kHold_s;
      grabs_.push_back(grab);
    }
    if (!action.has_poke()) continue;
    Poke poke;
    poke.script = action.poke();
    poke.start_s = poke.script.start_s();
    poke.pull_s = poke.script.has_pull_s() ? poke.script.pull_s() : kPull_s;
    poke.hold_s = poke.script.has_hold_s() ? poke.script.hold_s() : kHold_s;
    pokes_.push_back(poke);
  }
  for (HandSample& hand : sample_.hands) {
    hand.active = true;
    hand.aim.position_m = hand.grip.position_m = settings.eye_m;
  }
}

InputSample ScriptedHands::at(double time_s, const Locate& locate) {
  ++sample_.sequence;
  sample_.sampled_ns = now_ns();
  sample_.hands[0].shoot = false;
  sample_.hands[1].trigger = 0.0f;
  for (Poke& poke : pokes_) apply(poke, time_s, locate, sample_.hands[1]);
  sample_.hands[0].squeeze = 0.0f;
  for (Grab& grab : grabs_) apply(grab, time_s, locate, sample_.hands[0]);
  for (Ball& ball : balls_) apply(ball, time_s, locate, sample_.hands[0]);
  return sample_;
}

void ScriptedHands::apply(Poke& poke, double time_s, const Locate& locate, HandSample& hand) {
  if (poke.missed || time_s < poke.start_s || time_s >= poke.end_s()) return;
  if (!poke.begun) {
    poke.begun = true;
    const auto extent = locate(poke.script.object());
    if (!extent) {
      poke.missed = true;
      log_warn("script: no object is named \"%s\", so the action is skipped; name an object of the scene",
               poke.script.object().c_str());
      return;
    }
    const Eigen::Vector3d from_m = vector_or(poke.script.from_m(), settings_.eye_m);
    poke.aim = aimed(from_m, extent->middle_m - from_m);
    poke.pull_m = vector_or(poke.script.pull_m(), {0, kPullPerSize * extent->size_m, 0});
  }
  const double share = poke.pull_s > 0 ? std::min(1.0, (time_s - poke.start_s) / poke.pull_s) : 1.0;
  hand.aim = hand.grip = poke.aim;
  // Smoothstep: zero velocity at both ends.
  hand.aim.position_m += share * share * (3 - 2 * share) * poke.pull_m;
  hand.grip.position_m = hand.aim.position_m;
  hand.trigger = 1.0f;
}

// The grip closes at the centre of the object.
void ScriptedHands::apply(Grab& grab, double time_s, const Locate& locate, HandSample& hand) {
  if (grab.missed || time_s < grab.script.start_s() || time_s >= grab.end_s()) return;
  if (!grab.begun) {
    grab.begun = true;
    const auto extent = locate(grab.script.object());
    if (!extent) {
      grab.missed = true;
      log_warn("script: no object is named \"%s\", so the action is skipped; name an object of the scene",
               grab.script.object().c_str());
      return;
    }
    grab.from_m = extent->middle_m;
    grab.move_m = vector_or(grab.script.move_m(), {0, kPullPerSize * extent->size_m, 0});
  }
  const double passed_s = time_s - grab.script.start_s();
  const double share = grab.move_s > 0 ? std::min(1.0, passed_s / grab.move_s) : 1.0;
  hand.grip.orientation.setIdentity();
  hand.grip.position_m = grab.from_m + share * share * (3 - 2 * share) * grab.move_m;
  hand.squeeze = 1.0f;
}

void ScriptedHands::apply(Ball& ball, double time_s, const Locate& locate, HandSample& hand) {
  if (ball.shot || time_s < ball.script.time_s()) return;
  if (hand.shoot) return;  // another ball uses this sample; shoot in the sample after the button's release
  if (last_shot_sequence_ != 0 && sample_.sequence == last_shot_sequence_ + 1) return;
  ball.shot = true;
  Eigen::Vector3d mark = vector_or(ball.script.point().position_m(), Eigen::Vector3d::Zero());
  if (ball.script.aim_case() == v1::InputScript::Ball::kObject) {
    const auto extent = locate(ball.script.object());
    if (!extent) {
      log_warn("script: no object is named \"%s\", so the action is skipped; name an object of the scene",
               ball.script.object().c_str());
      return;
    }
    mark = extent->middle_m;
  }
  const Eigen::Vector3d from_m = vector_or(ball.script.from_m(), settings_.eye_m);
  hand.aim = aimed(from_m, throw_direction(mark - from_m, settings_.ball_speed_m_s));
  if (hand.squeeze == 0.0f) hand.grip = hand.aim;
  hand.shoot = true;
  last_shot_sequence_ = sample_.sequence;
}

bool ScriptedHands::done(double time_s) const {
  return std::all_of(pokes_.begin(), pokes_.end(), [&](const Poke& poke) { return time_s > poke.end_s(); }) &&
         std::all_of(grabs_.begin(), grabs_.end(), [&](const Grab& grab) { return time_s > grab.end_s(); }) &&
         std::all_of(balls_.begin(), balls_.end(), [](const Ball& ball) { return ball.shot; });
}

}  // namespace livegs
