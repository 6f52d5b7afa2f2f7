// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

namespace livegs {

// True and estimated mass of one object. Kilograms.
struct MassAnswer {
  std::string id;
  double true_kg = 0;
  double low_kg = 0, best_kg = 0, high_kg = 0;
};

// A measure over a set of objects, with its 95 % bootstrap interval.
struct Figure {
  double value = 0, low = 0, high = 0;
};

// Common measures of mass estimates; ADE, ALDE and MnRE as in Zhai et al. 2024 (NeRF2Physics), section 4.1.
struct MassScores {
  size_t count = 0;
  Figure mape;  // mean of |p - t| / t
  Figure median_ape;
  Figure max_ape;
  Figure ade_kg;     // mean of |p - t|
  Figure alde;       // mean of |ln p - ln t|
  Figure mnre;       // mean of min(p / t, t / p)
  Figure within_25;  // share with |p - t| <= t / 4
  Figure within_2x;  // share with t / 2 <= p <= 2 t
  Figure coverage;   // share with low <= t <= high
  Figure width;      // median of high / low
  // `width` after scaling all ranges around their best value, in the logarithm, so that exactly 95 % of them
  // contain the truth.
  Figure width_needed;
};

// 2000 resamplings with a fixed seed.
// Precondition: not empty, all masses positive.
MassScores mass_scores(std::span<const MassAnswer> answers);

}  // namespace livegs
