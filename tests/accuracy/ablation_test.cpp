// SPDX-License-Identifier: Apache-2.0
// The ablation chart: scenes meet their bars with all mechanisms of the solvers and miss them without one.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/parallel_for.h"
#include "study/chart/ablation_chart.h"
#include "study/stability/stability_scenes.h"

namespace livegs::study {
namespace {

const StabilityScene& scene_of(const std::string& name) {
  for (const StabilityScene& scene : stability_scenes()) {
    if (scene.name == name) return scene;
  }
  throw std::logic_error(name);
}

AblationRun run_without(Mechanism mechanism, const std::string& scene) {
  set_thread_count(1);
  disabled_mechanism = mechanism;
  StabilityRun clock(90.0);
  AblationRun run{scene_of(scene).run(clock), clock.cost().cpu_s};
  disabled_mechanism = Mechanism::None;
  set_thread_count(0);
  return run;
}

TEST(Ablation, ScenesMissTheirBarsWithoutTheirMechanism) {
  const std::pair<const char*, Mechanism> cases[] = {{"snapping_chain", Mechanism::JointEnergyLimit},
                                                     {"heavy_on_light_box", Mechanism::StepsByLoad},
                                                     {"coincident_bodies", Mechanism::CoincidentShapes},
                                                     {"couple", Mechanism::MaterialInertia},
                                                     {"soft_collision", Mechanism::ContactLag}};
  for (const auto& [scene, mechanism] : cases) {
    SCOPED_TRACE(scene);
    const AblationPair pair{mechanism, scene, run_without(mechanism, scene),
                            run_without(Mechanism::None, scene)};
    for (const Measurement& figure : pair.with.measurements)
      EXPECT_LE(figure.error, figure.bar) << figure.quantity;
    const auto effects = effects_of({pair});
    ASSERT_FALSE(effects.empty());
    EXPECT_TRUE(std::any_of(effects.begin(), effects.end(),
                            [](const AblationEffect& one) { return one.error_without > one.bar; }));
  }
}

TEST(Ablation, EachMechanismHasOneText) {
  std::set<std::string> names;
  std::set<Mechanism> mechanisms;
  for (const MechanismText& text : all_mechanisms()) {
    names.insert(text.name);
    mechanisms.insert(text.mechanism);
  }
  EXPECT_EQ(names.size(), all_mechanisms().size());
  EXPECT_EQ(mechanisms.size(), static_cast<size_t>(Mechanism::StepsByLoad));  // the last one
  EXPECT_FALSE(mechanisms.contains(Mechanism::None));
}

TEST(Ablation, PageNamesTheMostAffectedFigureAndWhatIsIdle) {
  const auto run = [](double error, double cpu_s) {
    return AblationRun{{absolute("gain", error, 0.0, 0.01), absolute("apart", 1.0, 0.0, 2.0, "m")}, cpu_s};
  };
  const auto effects = effects_of({{Mechanism::EnergyLimiter, "limp_spin", run(0.5, 2.0), run(0.005, 1.0)},
                                   {Mechanism::GripFade, "limp_spin", run(0.005, 1.0), run(0.005, 1.0)}});
  ASSERT_EQ(effects.size(), 4u);
  EXPECT_DOUBLE_EQ(effects[0].worse_bars(), 49.5);
  EXPECT_DOUBLE_EQ(effects[0].cost_ratio, 2.0);
  EXPECT_EQ(effects[1].worse_bars(), 0.0);
  const std::string page = ablation_page(effects, "1");
  EXPECT_NE(page.find("gain of `limp_spin` | 0.5 % | 50 % | 1 % | 1 | 0 | 1 | 2.00 |"), std::string::npos)
      << page;
  EXPECT_NE(page.find("No figure here gets worse without `grip_fade`."), std::string::npos) << page;
  EXPECT_NE(ablation_csv(effects).find("energy_limiter,limp_spin,gain,absolute,0.01,0.005,0.5,49.5,2.00\n"),
            std::string::npos);
}

}  // namespace
}  // namespace livegs::study
