// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/haptics.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr float kMinImpulse_n_s = 0.02f;           // imperceptible below
constexpr float kFullAmplitudeImpulse_n_s = 1.0f;  // maximum vibration
constexpr float kRepeatRatio = 3.0f;               // relative to the last pulse
constexpr double kContact_s = 0.02, kTake_s = 0.015;
constexpr float kTakeAmplitude = 0.3f;
constexpr double kFullAmplitudeSpeed_m_s = 1.5;  // hand speed of the maximum vibration
// A reported contact within this time of a predicted one is the same contact.
constexpr int64_t kContactMatchWindow_ns = 300'000'000;
constexpr int64_t kContactTimeout_ns = 100'000'000;

}  // namespace

std::optional<Haptics::Pulse> Haptics::holds(size_t hand, uint32_t object_id) {
  Hand& h = hands_[hand];
  if (h.held == object_id) return std::nullopt;
  h = {};
  h.held = object_id;
  if (object_id == 0) return std::nullopt;
  return Pulse{kTakeAmplitude, kTake_s};
}

std::optional<Haptics::Pulse> Haptics::foreseen(size_t hand, bool touches, double speed_m_s, int64_t now_ns) {
  Hand& h = hands_[hand];
  const bool begins = touches && h.touches == false;
  h.touches = touches;
  if (!begins || (h.impulse_ns && now_ns - *h.impulse_ns < kContactMatchWindow_ns)) return std::nullopt;
  h.predicted_ns = now_ns;
  return Pulse{static_cast<float>(std::clamp(std::sqrt(speed_m_s / kFullAmplitudeSpeed_m_s), 0.1, 1.0)),
               kContact_s};
}

std::optional<Haptics::Pulse> Haptics::reported(size_t hand, float impulse_n_s, int64_t now_ns) {
  Hand& h = hands_[hand];
  if (!(impulse_n_s > kMinImpulse_n_s)) return std::nullopt;
  const bool goes_on = h.impulse_ns && now_ns - *h.impulse_ns < kContactTimeout_ns;
  const bool knocks = goes_on && impulse_n_s > kRepeatRatio * h.contact_impulse_n_s;
  const bool same = !goes_on && h.predicted_ns && now_ns - *h.predicted_ns < kContactMatchWindow_ns;
  h.contact_impulse_n_s =
      goes_on ? std::max(impulse_n_s, 0.8f * h.contact_impulse_n_s + 0.2f * impulse_n_s) : impulse_n_s;
  h.impulse_ns = now_ns;
  if (same || (goes_on && !knocks)) return std::nullopt;
  return Pulse{std::min(1.0f, std::sqrt(impulse_n_s / kFullAmplitudeImpulse_n_s)), kContact_s};
}

}  // namespace livegs
