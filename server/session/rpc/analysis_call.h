// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/server_callback.h>

#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>

#include "livegs/v1/session.pb.h"
#include "session/tick/analysis_control.h"

namespace livegs {

// One AnalyzeScene rpc: streams progress in order. Deletes itself. If the client cancels or disconnects, the
// analysis stops.
class AnalysisCall final : public grpc::ServerWriteReactor<v1::AnalysisProgress> {
 public:
  // `control` may be null: UNAVAILABLE.
  AnalysisCall(AnalysisControl* control, const v1::AnalyzeSceneRequest& request);

 private:
  // State shared by the analysis thread and gRPC's threads; outlives the call.
  struct Line {
    std::mutex mutex;  // guards the members below
    AnalysisCall* call = nullptr;
    std::deque<v1::AnalysisProgress> waiting;
    bool writing = false, ended = false;
  };
  void write_next();  // line_->mutex must be held
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  std::stop_source gone_;
  std::shared_ptr<Line> line_ = std::make_shared<Line>();
};

}  // namespace livegs
