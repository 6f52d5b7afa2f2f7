// SPDX-License-Identifier: Apache-2.0
// Disables the mechanism of the solvers with the number LIVEGS_WITHOUT in a test program
// (tests/bench/ablation).
#include <gtest/gtest.h>

#include <cstdlib>

#include "physics/ablation/ablation.h"

namespace livegs {
namespace {

class DisableMechanism : public testing::Environment {
  void SetUp() override {
    const char* name = std::getenv("LIVEGS_WITHOUT");
    if (!name) return;
    disabled_mechanism = static_cast<Mechanism>(std::atoi(name));
  }
};
[[maybe_unused]] const auto* const environment = testing::AddGlobalTestEnvironment(new DisableMechanism);

}  // namespace
}  // namespace livegs
