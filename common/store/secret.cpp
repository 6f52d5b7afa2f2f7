// SPDX-License-Identifier: Apache-2.0
#include "store/secret.h"

#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <set>
#include <utility>

#include "core/assert.h"

namespace livegs {
namespace {

constexpr std::size_t kMaxChanceMatch = 8;  // key characters that may match by chance

}  // namespace

Secret::Secret(std::string_view text) {
  if (text.empty()) return;
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  page_size_ = (text.size() + page - 1) / page * page;
  void* memory = ::mmap(nullptr, page_size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  LIVEGS_ASSERT(memory != MAP_FAILED);
  // All are best effort: if the kernel refuses, the page is an ordinary one.
  (void)::prctl(PR_SET_DUMPABLE, 0);
  ::madvise(memory, page_size_, MADV_DONTDUMP);
  (void)::mlock(memory, page_size_);
  page_ = static_cast<char*>(memory);
  size_ = text.size();
  text.copy(page_, size_);
}

Secret::~Secret() { clear(); }

Secret::Secret(Secret&& other) noexcept
    : page_(std::exchange(other.page_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      page_size_(std::exchange(other.page_size_, 0)) {}

Secret& Secret::operator=(Secret&& other) noexcept {
  if (this != &other) {
    clear();
    page_ = std::exchange(other.page_, nullptr);
    size_ = std::exchange(other.size_, 0);
    page_size_ = std::exchange(other.page_size_, 0);
  }
  return *this;
}

void Secret::clear() {
  if (page_) {
    ::explicit_bzero(page_, page_size_);
    ::munmap(page_, page_size_);
  }
  page_ = nullptr;
  size_ = page_size_ = 0;
}

std::string Secret::redact(std::string_view text) const {
  if (size_ < kMaxChanceMatch) return std::string(text);
  const std::string_view key = reveal();
  std::set<std::string_view> stretches;
  for (std::size_t i = 0; i + kMaxChanceMatch <= key.size(); ++i)
    stretches.insert(key.substr(i, kMaxChanceMatch));
  std::string clean;
  clean.reserve(text.size());
  std::size_t hidden_to = 0;  // end of the last match of the key
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i + kMaxChanceMatch <= text.size() && stretches.contains(text.substr(i, kMaxChanceMatch))) {
      if (hidden_to <= i) clean += "[key]";
      hidden_to = i + kMaxChanceMatch;
    }
    if (i >= hidden_to) clean += text[i];
  }
  return clean;
}

void wipe(std::string& text) {
  ::explicit_bzero(text.data(), text.size());
  text.clear();
}

}  // namespace livegs
