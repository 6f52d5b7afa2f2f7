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

// One AnalyzeScene rpc: progress in order, as it comes. Deletes itself. When the client cancels or goes,
// nothing more is asked.
class AnalysisCall final : public grpc::ServerWriteReactor<v1::AnalysisProgress> {
 public:
  // `control` may be nullptr: UNAVAILABLE.
  AnalysisCall(AnalysisControl* control, const v1::AnalyzeSceneRequest& request);

 private:
  // What the analysis's thread and gRPC's share, and which outlives the call.
  struct Line {
    std::mutex mutex;  // guards what follows
    AnalysisCall* call = nullptr;
    std::deque<v1::AnalysisProgress> waiting;
    bool writing = false, ended = false;
  };
  void write_next();  // the line is locked
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  std::stop_source gone_;
  std::shared_ptr<Line> line_ = std::make_shared<Line>();
};

}  // namespace livegs
