// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace livegs {

// Memory of the process that is set aside for ticks: a step that finds none half-way would leave a scene that is neither as it was nor as
// it would be. While it is lent, an allocation by operator new that fails, on any thread, frees a piece of it and is tried again
// (std::set_new_handler), so the tick comes to its end as any other. What Eigen and C libraries take by malloc is not helped.
class MemoryReserve {
 public:
  // Ticks of scenes within the limits take a few megabytes at most, but for one in which much breaks.
  static constexpr size_t kPieceBytes = 4u << 20, kPieces = 16;

  // Takes what is missing of it; false while memory is short. Any thread.
  static bool fill();

  // While one lives it is lent.
  class Lent {
   public:
    Lent();
    ~Lent();
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;
    bool used() const;  // any of it was needed
  };
};

}  // namespace livegs
