// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "session/frames/send_budget.h"

namespace livegs {

// Bandwidth limits of asset fetches outside a session. All fetches from one machine share one limit. Any
// thread.
class PeerBudgets {
 public:
  // Returns the budget of the peer's machine, which is stored while a caller holds it. `peer`:
  // "ipv4:ADDRESS:PORT", the form of gRPC. `bytes_s`: cap of a new budget, bytes per second; infinity: none.
  std::shared_ptr<SendBudget> of(std::string_view peer, double bytes_s) {
    const std::string machine(peer.substr(0, peer.rfind(':')));
    std::lock_guard lock(mutex_);
    std::erase_if(budgets_, [](const auto& one) { return one.second.expired(); });
    std::weak_ptr<SendBudget>& known = budgets_[machine];
    std::shared_ptr<SendBudget> budget = known.lock();
    if (!budget) known = budget = std::make_shared<SendBudget>(bytes_s);
    return budget;
  }

 private:
  std::mutex mutex_;  // guards the map
  std::map<std::string, std::weak_ptr<SendBudget>> budgets_;
};

}  // namespace livegs
