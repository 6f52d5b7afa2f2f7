// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stream/session/session_client.h"
#include "viewer/live/frame_queue.h"

namespace livegs {

// What is out of order with a session, in the words that its person reads, whatever they look at. One thread.
class SessionNotice {
 public:
  // After each take() of the stream. Logs what is new.
  void take(const FrameQueue::StreamUpdate& update, SessionClient& client);

  // `otherwise`, what is of less weight, while all is well with the session.
  std::string text(const std::string& otherwise) const { return text_.empty() ? otherwise : text_; }

 private:
  std::string text_ = "waiting for the first frame";
  bool said_by_server_ = false, over_ = false;
};

}  // namespace livegs
