// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"

namespace livegs {

// Folder of keys, tokens and known servers: `given`, or $XDG_STATE_HOME/livegs, or $HOME/.local/state/livegs.
// The folder may not exist.
Result<std::filesystem::path> state_folder(const std::filesystem::path& given);
// Creates the folder with mode 0700 if it does not exist.
Result<void> make_state_folder(const std::filesystem::path& folder);

// Writes a file with mode 0600 atomically: a temporary file next to it is synced and renamed over it. Creates
// the folder.
Result<void> write_secret_file(const std::filesystem::path& path, std::string_view text);
// Reads a secret. PermissionDenied if other users may read the file. A file of root may be readable by its
// group, as root gives it to a service, for example a Secret in a pod with fsGroup.
Result<std::string> read_secret_file(const std::filesystem::path& path);

}  // namespace livegs
