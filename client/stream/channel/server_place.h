// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "trust/server_access.h"

namespace livegs {

// The server of a session. It changes when a server that shuts down names the next one. Any thread.
class ServerPlace {
 public:
  struct Place {
    std::string address;
    std::shared_ptr<const ServerAccess> access;  // null: no TLS
    uint64_t moves = 0;                          // so far
  };
  ServerPlace(std::string address, std::shared_ptr<const ServerAccess> access)
      : place_{std::move(address), std::move(access), 0} {}

  Place now() const {
    std::lock_guard lock(mutex_);
    return place_;
  }
  void move_to(std::string address, std::shared_ptr<const ServerAccess> access) {
    std::lock_guard lock(mutex_);
    place_ = {std::move(address), std::move(access), place_.moves + 1};
  }

 private:
  mutable std::mutex mutex_;  // guards place_
  Place place_;
};

}  // namespace livegs
