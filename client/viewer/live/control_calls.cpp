// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/control_calls.h"

#include <pthread.h>

#include <utility>

namespace livegs {
namespace {

ControlCalls::Answer answer_of(ControlCalls::Answer::Kind kind, std::string object = {}) {
  ControlCalls::Answer answer;
  answer.kind = kind;
  answer.object = std::move(object);
  return answer;
}

}  // namespace

ControlCalls::Lane::~Lane() {
  thread_.request_stop();
  thread_.join();
}

void ControlCalls::Lane::post(std::function<void()> call) {
  {
    std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
  }
  changed_.notify_one();
}

void ControlCalls::Lane::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "control calls");
  for (;;) {
    std::function<void()> call;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [&] { return !calls_.empty(); }) || stop.stop_requested()) return;
      call = std::move(calls_.front());
      calls_.pop_front();
    }
    call();
  }
}

ControlCalls::ControlCalls(SceneControl& control, std::function<void()> wake)
    : control_(control), wake_(std::move(wake)) {}

ControlCalls::~ControlCalls() { control_.cancel(); }

void ControlCalls::answer(Answer answer) {
  {
    std::lock_guard lock(mutex_);
    answers_.push_back(std::move(answer));
  }
  wake_();
}

std::vector<ControlCalls::Answer> ControlCalls::take() {
  std::lock_guard lock(mutex_);
  return std::exchange(answers_, {});
}

void ControlCalls::set_physics(std::string object, v1::Physics physics) {
  quick_.post([this, object = std::move(object), physics = std::move(physics)] {
    auto reply = control_.set_physics(object, physics);
    Answer result = answer_of(Answer::Kind::Physics, object);
    reply ? void(result.physics = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::restore_estimate(std::string object, std::vector<std::string> fields) {
  edits_.post([this, object = std::move(object), fields = std::move(fields)] {
    v1::EditSceneRequest request;
    v1::ObjectEdit& edit = *request.add_objects();
    edit.set_object(object);
    for (const std::string& field : fields) edit.add_fields("physics." + field);
    auto reply = control_.edit_scene(request);
    Answer result = answer_of(Answer::Kind::Physics, object);
    if (reply) {
      result.physics.emplace().set_object(object);
      *result.physics->mutable_warnings() = reply->warnings();
    } else {
      result.refused = reply.error();
    }
    answer(std::move(result));
  });
}

void ControlCalls::accept_proposal(std::string object, bool decline) {
  quick_.post([this, object = std::move(object), decline] {
    auto reply = control_.accept_proposal(object, decline);
    Answer result = answer_of(Answer::Kind::Physics, object);
    reply ? void(result.physics = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::undo_physics(std::string object, bool redo) {
  quick_.post([this, object = std::move(object), redo] {
    auto reply = control_.undo_physics(object, redo);
    Answer result = answer_of(Answer::Kind::Physics, object);
    reply ? void(result.physics = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::analyze(std::vector<std::string> objects) {
  analyses_.post([this, objects = std::move(objects)] {
    const auto done = control_.analyze(objects, [this](const v1::AnalysisProgress& progress) {
      Answer result = answer_of(Answer::Kind::Analysis, progress.object());
      result.progress = progress;
      result.last = false;
      answer(std::move(result));
    });
    Answer result = answer_of(Answer::Kind::Analysis);
    if (!done) result.refused = done.error();
    answer(std::move(result));
  });
}

void ControlCalls::control_run(v1::ControlRunRequest request) {
  quick_.post([this, request = std::move(request)] {
    Answer result = answer_of(Answer::Kind::Run);
    if (auto state = control_.control_run(request); !state) result.refused = state.error();
    answer(std::move(result));
  });
}

void ControlCalls::edit_scene(v1::EditSceneRequest request) {
  edits_.post([this, request = std::move(request)] {
    Answer result = answer_of(Answer::Kind::Edit);
    auto reply = control_.edit_scene(request);
    reply ? void(result.edited = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::undo_edit(bool redo) {
  edits_.post([this, redo] {
    Answer result = answer_of(Answer::Kind::Edit);
    auto reply = control_.undo_edit(redo);
    reply ? void(result.edited = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::carry_object(v1::CarryObjectRequest request) {
  if (carries_waiting_ > 0 && request.has_pose()) return;
  ++carries_waiting_;
  edits_.post([this, request = std::move(request)] {
    --carries_waiting_;
    Answer result = answer_of(Answer::Kind::Edit);
    auto reply = control_.carry_object(request);
    if (reply) return;
    result.refused = reply.error();
    answer(std::move(result));
  });
}

void ControlCalls::take_part(v1::TakePartRequest request) {
  edits_.post([this, request = std::move(request)] {
    Answer result = answer_of(request.preview() ? Answer::Kind::Preview : Answer::Kind::Edit);
    auto reply = control_.take_part(request);
    if (!reply) {
      result.refused = reply.error();
    } else if (request.preview()) {
      result.preview = *std::move(reply);
    } else {
      result.edited.emplace();
      result.edited->add_objects(reply->object());
      *result.edited->mutable_warnings() = reply->warnings();
      result.edited->set_revision(reply->revision());
    }
    answer(std::move(result));
  });
}

void ControlCalls::put_back(std::string object) {
  edits_.post([this, object = std::move(object)] {
    Answer result = answer_of(Answer::Kind::Edit);
    auto reply = control_.put_back(object);
    reply ? void(result.edited = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::get_scene() {
  quick_.post([this] {
    Answer result = answer_of(Answer::Kind::Scene);
    auto reply = control_.scene();
    reply ? void(result.scene = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::save_scene(v1::SaveSceneRequest request) {
  edits_.post([this, request = std::move(request)] {
    Answer result = answer_of(Answer::Kind::Save);
    auto reply = control_.save_scene(request);
    reply ? void(result.saved = reply->file()) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::list_assets() {
  quick_.post([this] {
    Answer result = answer_of(Answer::Kind::Assets);
    auto reply = control_.assets();
    reply ? void(result.assets = *std::move(reply)) : void(result.refused = reply.error());
    answer(std::move(result));
  });
}

void ControlCalls::upload_asset(std::filesystem::path file, v1::ObjectEdit edit) {
  edits_.post([this, file = std::move(file), edit = std::move(edit)]() mutable {
    Answer result = answer_of(Answer::Kind::Edit);
    auto path = control_.upload_asset(file);
    if (path) {
      edit.mutable_value()->set_asset(*path);
      v1::EditSceneRequest request;
      *request.add_objects() = std::move(edit);
      auto reply = control_.edit_scene(request);
      reply ? void(result.edited = *std::move(reply)) : void(result.refused = reply.error());
    } else {
      result.refused = path.error();
    }
    answer(std::move(result));
  });
}

void ControlCalls::apply_force(v1::Event::Force force) {
  quick_.post([this, force = std::move(force)] {
    Answer result = answer_of(Answer::Kind::Force, force.object());
    auto taken = control_.apply_force(force);
    taken ? void(result.tick = *taken) : void(result.refused = taken.error());
    answer(std::move(result));
  });
}

}  // namespace livegs
