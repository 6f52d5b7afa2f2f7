// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/estimate/mass_scores.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/percentile.h"

namespace livegs {
namespace {

constexpr int kResamplings = 2000;

using Sample = std::vector<const MassAnswer*>;

double ape(const MassAnswer& a) { return std::abs(a.best_kg - a.true_kg) / a.true_kg; }

double mean(const Sample& sample, const std::function<double(const MassAnswer&)>& of) {
  double sum = 0;
  for (const MassAnswer* answer : sample) sum += of(*answer);
  return sum / static_cast<double>(sample.size());
}

double median_ape(const Sample& sample) {
  std::vector<double> values;
  for (const MassAnswer* answer : sample) values.push_back(ape(*answer));
  return median(std::move(values));
}

double max_ape(const Sample& sample) {
  double most = 0;
  for (const MassAnswer* answer : sample) most = std::max(most, ape(*answer));
  return most;
}

double median_width(const Sample& sample) {
  std::vector<double> values;
  for (const MassAnswer* answer : sample) values.push_back(answer->high_kg / answer->low_kg);
  return median(std::move(values));
}

double width_needed(const Sample& sample) {
  std::vector<double> used;  // position of the truth within its range, as a fraction
  for (const MassAnswer* a : sample) {
    const double end_kg = a->true_kg < a->best_kg ? a->low_kg : a->high_kg;
    used.push_back(std::abs(std::log(a->true_kg / a->best_kg)) /
                   std::max(1e-9, std::abs(std::log(end_kg / a->best_kg))));
  }
  std::sort(used.begin(), used.end());
  const auto at = static_cast<size_t>(std::ceil(0.95 * static_cast<double>(used.size()))) - 1;
  return std::pow(median_width(sample), used[at]);
}

Figure figure(std::span<const MassAnswer> answers, const std::function<double(const Sample&)>& measure) {
  Sample sample;
  for (const MassAnswer& answer : answers) sample.push_back(&answer);
  Figure result;
  result.value = measure(sample);
  std::mt19937_64 random(1);
  std::vector<double> values;
  for (int i = 0; i < kResamplings; ++i) {
    for (const MassAnswer*& pick : sample) pick = &answers[random() % answers.size()];
    values.push_back(measure(sample));
  }
  std::sort(values.begin(), values.end());
  result.low = values[kResamplings / 40];
  result.high = values[kResamplings - 1 - kResamplings / 40];
  return result;
}

}  // namespace

MassScores mass_scores(std::span<const MassAnswer> answers) {
  const auto mean_of = [&](const std::function<double(const MassAnswer&)>& of) {
    return figure(answers, [&of](const Sample& sample) { return mean(sample, of); });
  };
  MassScores scores;
  scores.count = answers.size();
  scores.mape = mean_of(ape);
  scores.median_ape = figure(answers, median_ape);
  scores.max_ape = figure(answers, max_ape);
  scores.ade_kg = mean_of([](const MassAnswer& a) { return std::abs(a.best_kg - a.true_kg); });
  scores.alde = mean_of([](const MassAnswer& a) { return std::abs(std::log(a.best_kg / a.true_kg)); });
  scores.mnre =
      mean_of([](const MassAnswer& a) { return std::min(a.best_kg / a.true_kg, a.true_kg / a.best_kg); });
  scores.within_25 = mean_of([](const MassAnswer& a) { return ape(a) <= 0.25 ? 1.0 : 0.0; });
  scores.within_2x = mean_of([](const MassAnswer& a) {
    return a.best_kg <= 2 * a.true_kg && a.true_kg <= 2 * a.best_kg ? 1.0 : 0.0;
  });
  scores.coverage = mean_of(
      [](const MassAnswer& a) { return a.low_kg <= a.true_kg && a.true_kg <= a.high_kg ? 1.0 : 0.0; });
  scores.width = figure(answers, median_width);
  scores.width_needed = figure(answers, width_needed);
  return scores;
}

}  // namespace livegs
