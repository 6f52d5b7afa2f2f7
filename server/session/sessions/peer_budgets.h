// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "session/frames/send_budget.h"

namespace livegs {

// Bandwidth limits of fetches without a session: one for all of a machine. Any thread.
class PeerBudgets {
 public:
  // The budget of the machine of this peer ("ipv4:ADDRESS:PORT", as gRPC names it), kept while it is in use.
  // `bytes_s`: its cap if it is new.
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
