// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace livegs {

// A store from which clients fetch assets instead of from the server (JoinReply.asset_store).
struct ClientStore {
  std::string url;  // for clients, http or https, without a slash at the end; empty: none
  struct Asset {
    std::string hash, web_sha256;  // StoredAsset
  };
  std::vector<Asset> assets;
};

}  // namespace livegs
