// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/simulation/memory_reserve.h"

#include <sys/mman.h>

#include <mutex>
#include <new>

namespace livegs {
namespace {

// One for the process, as operator new's handler is. Nothing in here allocates by operator new.
std::mutex mutex;  // guards the rest
char* base = nullptr;
size_t left = 0;  // pieces, from the base on
int lent = 0;
bool handled = false;

// Returns when there is more than before; operator new tries again.
void free_a_piece() {
  std::lock_guard lock(mutex);
  if (lent == 0 || left == 0) throw std::bad_alloc();
  ::munmap(base + --left * MemoryReserve::kPieceBytes, MemoryReserve::kPieceBytes);
}

}  // namespace

bool MemoryReserve::fill() {
  std::lock_guard lock(mutex);
  if (!handled) std::set_new_handler(free_a_piece);
  handled = true;
  if (left == kPieces) return true;
  void* const whole = ::mmap(nullptr, kPieces * kPieceBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (whole == MAP_FAILED) return false;
  if (left > 0) ::munmap(base, left * kPieceBytes);
  base = static_cast<char*>(whole);
  left = kPieces;
  return true;
}

MemoryReserve::Lent::Lent() {
  std::lock_guard lock(mutex);
  ++lent;
}

MemoryReserve::Lent::~Lent() {
  std::lock_guard lock(mutex);
  --lent;
}

bool MemoryReserve::Lent::used() const {
  std::lock_guard lock(mutex);
  return left < kPieces;
}

}  // namespace livegs
