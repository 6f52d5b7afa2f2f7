// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "analysis/estimate.h"
#include "gaussian/asset_file.h"
#include "geometry/reconstruct_surface.h"

namespace livegs {
namespace {

// The YCB objects whose masses are known, from their file names and splats alone. Their plastic fruit looks
// real and their mug and plate are tin, so a good guess is off by several times for those; the bars are what
// this first estimator reaches, with the aim of the analysis issue beside them.
TEST(KnownMass, OfEverydayObjectsIsWithinAFewTimes) {
  const std::filesystem::path folder = std::filesystem::path(LIVEGS_SHARED_DATA_DIR) / "ycb";
  std::ifstream file(folder / "objects.json");
  if (!file) GTEST_SKIP() << "shared data is not here";
  const auto objects = nlohmann::json::parse(file)["objects"];
  std::vector<double> ratios;
  int within_range = 0;
  for (const auto& object : objects) {
    const std::string id = object["id"];
    auto asset = read_asset(folder / id / "splat.ply");
    ASSERT_TRUE(asset) << asset.error().message;
    // +Z up there; mass does not care.
    const auto points = body_points(asset->asset, Similarity{});
    auto surface = reconstruct_surface(points, elastic_surface_options());
    ASSERT_TRUE(surface) << surface.error().message;
    ObjectFacts facts;
    facts.name = id;
    facts.mesh = mesh_facts(surface->mesh);
    facts.appearance = appearance_facts(asset->asset);
    facts.scale_known = true;
    const auto p = estimate_offline(facts);
    const double truth = object["mass_kg"], ratio = p.mass_kg().best() / truth;
    ratios.push_back(std::abs(std::log(ratio)));
    within_range += p.mass_kg().low() <= truth && truth <= p.mass_kg().high();
    std::printf("%-26s %8.4f kg, estimated %8.4f [%.4f .. %.4f] %s of %s\n", id.c_str(), truth,
                p.mass_kg().best(), p.mass_kg().low(), p.mass_kg().high(), p.label().c_str(),
                p.material().c_str());
  }
  std::sort(ratios.begin(), ratios.end());
  const double median = std::exp(ratios[ratios.size() / 2]);
  const auto within_two =
      std::count_if(ratios.begin(), ratios.end(), [](double r) { return r <= std::log(2.0); });
  std::printf("median factor %.2f, within 2x %td of %zu, truth in the stated range %d of %zu\n", median,
              within_two, ratios.size(), within_range, ratios.size());
  EXPECT_LT(median, 2.0);                         // goal 1.25
  EXPECT_GE(within_two, std::ssize(ratios) / 2);  // goal: all
  EXPECT_LT(std::exp(ratios.back()), 12.0);       // goal 2; the worst are scans thicker than the thing
}

}  // namespace
}  // namespace livegs
