// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "stream/session/session_client.h"
#include "viewer/live/frame_queue.h"

namespace livegs {

// Problems of a session as text for the user, the same for all displays. One thread.
class SessionNotice {
 public:
  // Call after each take() of the stream. Logs new problems.
  void take(const FrameQueue::StreamUpdate& update, SessionClient& client);

  // The notice, or `otherwise` if the session has no problem.
  std::string text(const std::string& otherwise) const { return text_.empty() ? otherwise : text_; }

 private:
  std::string text_ = "waiting for the first frame";
  bool shutdown_announced_ = false;  // the notice is the shutdown reason of the server; a loss keeps it
  bool ended_ = false;               // the session has ended; the notice is final
};

}  // namespace livegs
