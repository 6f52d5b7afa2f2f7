// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace livegs {

// The server at which clients continue when this one shuts down. Without an address they do not.
struct Successor {
  std::string address;  // HOST:PORT
  std::string name;     // in its fleet, for new tokens; empty: unknown
};

}  // namespace livegs
