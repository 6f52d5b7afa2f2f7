// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace livegs {

// A secret key in a page of its own that is zeroed on destruction. It can be neither copied nor printed.
//
// libcurl copies the key during a request, and the environment keeps it. Therefore a process that holds a key
// disables core files and the access of other processes of the same user to its memory and /proc/PID/environ
// (PR_SET_DUMPABLE). A debugger must start the process or run as root.
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

  // Returns `text` with every run of eight or more characters of the secret replaced by "[key]". Shorter
  // secrets, such as the "none" of local servers, are not redacted.
  std::string redact(std::string_view text) const;

 private:
  void clear();
  char* page_ = nullptr;
  std::size_t size_ = 0, page_size_ = 0;
};

// Overwrites and empties a string; the compiler does not remove the write.
void wipe(std::string& text);

}  // namespace livegs
