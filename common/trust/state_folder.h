// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"

namespace livegs {

// Where keys, tokens and known servers are kept: `given`, or $XDG_STATE_HOME/livegs, or
// $HOME/.local/state/livegs. It need not be there.
Result<std::filesystem::path> state_folder(const std::filesystem::path& given);
// Made, with mode 0700, if it is not there.
Result<void> make_state_folder(const std::filesystem::path& folder);

// A file that only its owner may read, mode 0600, written beside it, synced and renamed over it. Its folder
// is made.
Result<void> write_secret_file(const std::filesystem::path& path, std::string_view text);
// PermissionDenied when others may read it too: then it is no secret any more.
Result<std::string> read_secret_file(const std::filesystem::path& path);

}  // namespace livegs
