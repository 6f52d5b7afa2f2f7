// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/session_notice.h"

#include "core/log.h"

namespace livegs {

void SessionNotice::take(const FrameQueue::StreamUpdate& update, SessionClient& client) {
  const auto say = [this](std::string text) {
    text_ = std::move(text);
    log_warn("%s", text_.c_str());
  };
  if (!update.frames.empty() && !over_ && (update.back || !said_by_server_)) {
    if (update.back) log_info("server reconnected");
    text_.clear();
    said_by_server_ = false;
  }
  if (update.goodbye) {
    say("server is shutting down: " + *update.goodbye);
    said_by_server_ = true;
  }
  if (update.lost && !said_by_server_)
    say("server disconnected: " + *update.lost + "; reconnecting");  // a message of the server is kept
  if (client.ended() && !over_) {
    over_ = true;
    const auto stopped = client.stop();
    say("session ended" + (stopped ? std::string() : ": " + stopped.error().message));
  }
}

}  // namespace livegs
