// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <string>

#include "core/result.h"
#include "wire/little_endian.h"

namespace livegs {

// The start of a message: a magic number, then a version. The format defines their widths.
template <std::unsigned_integral Magic, std::unsigned_integral Version>
struct MessageHeader {
  const char* name;    // of the message; prefix of its errors
  const char* begins;  // readable form of the magic number: " with LVGF"
  Magic magic;
  Version version;

  void write(ByteWriter& out) const {
    out.write(magic);
    out.write(version);
  }
  Error invalid(const std::string& what) const { return invalid_data(std::string(name) + ": " + what); }
  // Checks both fields after reading. `cut_short`: the message is shorter than the header.
  Result<void> check(Magic read_magic, Version read_version, bool cut_short) const {
    if (cut_short || read_magic != magic) return invalid(std::string("must begin") + begins);
    if (read_version == version) return {};
    return unsupported(std::string(name) + ": has version " + std::to_string(read_version) + ", expected " +
                       std::to_string(version) + "; update the older of server and client");
  }
};

}  // namespace livegs
