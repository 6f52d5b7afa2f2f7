// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace livegs {

// A key. It lives in a page of its own that is zeroed when it goes; it cannot be copied or printed. libcurl
// copies it for the length of a request, and the environment it came from keeps it, so a process that has
// held a key writes no core file from then on, and no other process of the same user may read its memory or
// /proc/PID/environ (PR_SET_DUMPABLE; a debugger has to start it, or run as root).
class Secret {
 public:
  Secret() = default;
  explicit Secret(std::string_view text);
  ~Secret();
  Secret(Secret&& other) noexcept;
  Secret& operator=(Secret&& other) noexcept;
  Secret(const Secret&) = delete;
  Secret& operator=(const Secret&) = delete;

  bool empty() const { return size_ == 0; }
  std::string_view reveal() const { return {page_, size_}; }

  // `text` with every stretch of eight or more characters of the secret replaced by "[key]". Words shorter
  // than that, such as the "none" that local servers are given, are no secret.
  std::string redact(std::string_view text) const;

 private:
  void clear();
  char* page_ = nullptr;
  std::size_t size_ = 0, page_size_ = 0;
};

// Overwrites what a string holds, in a way the compiler keeps, and empties it.
void wipe(std::string& text);

}  // namespace livegs
