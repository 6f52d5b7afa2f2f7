// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/session_notice.h"

#include "core/log.h"

namespace livegs {

void SessionNotice::take(const FrameQueue::StreamUpdate& update, SessionClient& client) {
  const auto warn = [this](std::string text) {
    text_ = std::move(text);
    log_warn("%s", text_.c_str());
  };
  if (!update.frames.empty() && !ended_ && (update.back || !shutdown_announced_)) {
    if (update.back) log_info("server: connected again");
    text_.clear();
    shutdown_announced_ = false;
  }
  if (update.shutdown_reason) {
    warn("server is shutting down: " + *update.shutdown_reason);
    shutdown_announced_ = true;
  }
  if (update.lost && !shutdown_announced_)
    warn("server disconnected: " + *update.lost + "; reconnecting");  // a message of the server is kept
  if (client.ended() && !ended_) {
    ended_ = true;
    const auto stopped = client.stop();
    warn("session ended" + (stopped ? std::string() : ": " + stopped.error().message));
  }
}

}  // namespace livegs
