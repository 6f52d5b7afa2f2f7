// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/rpc/analysis_call.h"

#include "session/rpc/grpc_status.h"

namespace livegs {

AnalysisCall::AnalysisCall(AnalysisControl* control, const v1::AnalyzeSceneRequest& request) {
  if (!control) {
    Finish({grpc::StatusCode::UNAVAILABLE,
            "analysis: is not available: the scene is still loading or this server has no analysis; try "
            "again later"});
    return;
  }
  line_->call = this;
  auto begun = control->analyze(
      {request.objects().begin(), request.objects().end()},
      [line = line_](const v1::AnalysisProgress& progress) {
        std::lock_guard lock(line->mutex);
        if (!line->call) return false;
        line->waiting.push_back(progress);
        if (!line->writing) line->call->write_next();
        return true;
      },
      [line = line_] {
        std::lock_guard lock(line->mutex);
        line->ended = true;
        if (line->call && !line->writing) line->call->write_next();
      },
      gone_.get_token());
  if (!begun) {
    std::lock_guard lock(line_->mutex);
    line_->call = nullptr;
    Finish(to_status(begun.error()));
  }
}

void AnalysisCall::write_next() {
  if (!line_->waiting.empty()) {
    line_->writing = true;
    StartWrite(&line_->waiting.front());
  } else if (line_->ended) {
    line_->call = nullptr;
    Finish(grpc::Status::OK);
  }
}

void AnalysisCall::OnWriteDone(bool ok) {
  if (!ok) gone_.request_stop();
  std::lock_guard lock(line_->mutex);
  line_->writing = false;
  line_->waiting.pop_front();
  if (ok) return write_next();
  line_->call = nullptr;
  Finish({grpc::StatusCode::CANCELLED, "the client disconnected"});
}

// With a write in progress, OnWriteDone follows and finishes the call.
void AnalysisCall::OnCancel() {
  gone_.request_stop();
  std::lock_guard lock(line_->mutex);
  if (!line_->call || line_->writing) return;
  line_->call = nullptr;
  Finish({grpc::StatusCode::CANCELLED, "the client disconnected"});
}

void AnalysisCall::OnDone() {
  {
    std::lock_guard lock(line_->mutex);
    line_->call = nullptr;
  }
  delete this;
}

}  // namespace livegs
