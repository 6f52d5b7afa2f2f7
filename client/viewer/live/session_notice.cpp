// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/session_notice.h"

#include "core/log.h"

namespace livegs {

void SessionNotice::take(const FrameQueue::News& news, SessionClient& client) {
  const auto say = [this](std::string text) {
    text_ = std::move(text);
    log_warn("%s", text_.c_str());
  };
  if (!news.frames.empty() && !over_ && (news.back || !said_by_server_)) {
    if (news.back) log_info("the server is back");
    text_.clear();
    said_by_server_ = false;
  }
  if (news.goodbye) {
    say("the server says goodbye: " + *news.goodbye);
    said_by_server_ = true;
  }
  if (news.lost && !said_by_server_) say("the server has gone: " + *news.lost + "; looking for it");  // what it said itself stays
  if (client.ended() && !over_) {
    over_ = true;
    const auto stopped = client.stop();
    say("the session is over" + (stopped ? std::string() : ": " + stopped.error().message));
  }
}

}  // namespace livegs
