// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/live/run_controller.h"

#include <pthread.h>

#include <exception>

#include "core/log.h"
#include "session/support/redact_paths.h"

namespace livegs {
namespace {

constexpr uint32_t kMaxSteps = 1000;
// Ids reserved for each loaded scene: more than its objects and balls.
constexpr uint32_t kIdsPerLoad = 1u << 20;
constexpr uint32_t kMaxResets = 4000;

}  // namespace

RunController::RunController(SimulationLoop& loop, Load load, Loaded loaded)
    : loop_(loop), load_(std::move(load)), loaded_(std::move(loaded)) {}

RunController::~RunController() = default;

Result<RunStatus> RunController::control(const v1::ControlRunRequest& request) {
  switch (request.action_case()) {
    case v1::ControlRunRequest::kPause:
      loop_.pause(request.pause());
      break;
    case v1::ControlRunRequest::kStepTicks:
      if (request.step_ticks() == 0 || request.step_ticks() > kMaxSteps) {
        return invalid_argument("step_ticks: must be 1 to 1000");
      }
      loop_.step_paused(request.step_ticks());
      break;
    case v1::ControlRunRequest::kReset:
      if (auto begun = reset(); !begun) return begun.error();
      break;
    case v1::ControlRunRequest::ACTION_NOT_SET:
      return invalid_argument("action: is not set; use pause, step_ticks or reset");
  }
  return loop_.run_status();
}

Result<void> RunController::reset() {
  std::lock_guard lock(mutex_);
  const RunStatus now = loop_.run_status();
  if (now.loading)
    return Error{ErrorCode::Unavailable, "reset: a reset is already in progress; try again later"};
  if (now.resets >= kMaxResets)
    return Error{ErrorCode::TooLarge, "reset: too many resets; restart the server"};
  loop_.set_loading(true, "");
  const auto failed = [this](const std::string& why) {
    log_warn("reset: %s", why.c_str());
    loop_.set_loading(false, "reset: " + redact_paths(why));
  };
  try {
    loading_ = std::jthread([this, failed, first_id = (now.resets + 1) * kIdsPerLoad + 1] {
      pthread_setname_np(pthread_self(), "loading");
      try {
        auto scene = load_(first_id);
        if (!scene) return failed(scene.error().message);
        loaded_ ? loaded_(*std::move(scene)) : loop_.replace(*std::move(scene));
      } catch (const std::exception& error) {  // out of memory: the running scene is not affected
        failed(error.what());
      }
    });
  } catch (const std::exception& error) {  // the thread could not be created
    failed(error.what());
    return Error{ErrorCode::Unavailable, std::string("reset: ") + error.what()};
  }
  return {};
}

Result<void> RunController::apply_force(const v1::Event::Force& force) {
  if (auto checked = check_force(force); !checked) return checked;
  v1::SceneChange change;
  *change.mutable_force() = force;
  loop_.post(std::move(change));
  return {};
}

}  // namespace livegs
