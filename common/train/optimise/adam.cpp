// SPDX-License-Identifier: Apache-2.0
#include "train/optimise/adam.h"

#include <cmath>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr size_t kAdamBlock = 2048;  // kernels

struct AdamFactors {
  float rate;     // with the bias corrections
  float epsilon;  // likewise
};

void adam_numbers(const float* __restrict gradient, size_t count, const AdamFactors& factors,
                  float* __restrict first, float* __restrict second, float* __restrict number) {
  constexpr auto beta1 = static_cast<float>(kAdamBeta1), beta2 = static_cast<float>(kAdamBeta2);
  for (size_t i = 0; i < count; ++i) {
    const float g = gradient[i];
    const float m = beta1 * first[i] + (1 - beta1) * g;
    const float v = beta2 * second[i] + (1 - beta2) * g * g;
    first[i] = m;
    second[i] = v;
    number[i] -= factors.rate * m / (__builtin_sqrtf(v) + factors.epsilon);
  }
}

}  // namespace

void AdamState::clear_row(size_t kernel) {
  for (KernelParameters* moments : {&first, &second}) {
    for (size_t f = 0; f < kFamilies; ++f)
      std::fill_n(moments->families[f].begin() + static_cast<std::ptrdiff_t>(kernel * kFamilyWidth[f]),
                  kFamilyWidth[f], 0.0f);
  }
}

void adam_step(const KernelParameters& gradient, const Rates& rates, std::span<const uint8_t> visible,
               AdamState& state, KernelParameters& parameters) {
  ++state.steps;
  const auto t = static_cast<double>(state.steps);
  const double correction1 = 1 - std::pow(kAdamBeta1, t),
               correction2 = std::sqrt(1 - std::pow(kAdamBeta2, t));
  std::array<AdamFactors, kFamilies> factors;
  for (size_t f = 0; f < kFamilies; ++f) {
    factors[f] = {static_cast<float>(rates[f] * correction2 / correction1),
                  static_cast<float>(kAdamEpsilon * correction2)};
  }
  parallel_for(parameters.size(), kAdamBlock, [&](size_t begin, size_t end) {
    const auto step = [&](size_t f, size_t from, size_t to) {
      const size_t at = from * kFamilyWidth[f], count = (to - from) * kFamilyWidth[f];
      adam_numbers(gradient.families[f].data() + at, count, factors[f], state.first.families[f].data() + at,
                   state.second.families[f].data() + at, parameters.families[f].data() + at);
    };
    constexpr auto harmonics = static_cast<size_t>(Family::Harmonics);
    for (size_t f = 0; f < harmonics; ++f) step(f, begin, end);
    for (size_t k = begin; k < end; ++k) {
      if (visible[k] != 0) step(harmonics, k, k + 1);
    }
  });
}

}  // namespace livegs
