// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdio>

#include "cli/commands.h"
#include "cli/shown_paths.h"

namespace livegs {

int report(const Error& error) {
  std::fprintf(stderr, "livegs: %s\n", with_shown_paths(error.message).c_str());
  switch (error.code) {
    case ErrorCode::InvalidArgument:
    case ErrorCode::InvalidData:
    case ErrorCode::NotFound:
    case ErrorCode::Unsupported:
    case ErrorCode::TooLarge:
      return 2;
    default:
      return 1;
  }
}

}  // namespace livegs
