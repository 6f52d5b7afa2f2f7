// SPDX-License-Identifier: Apache-2.0
// Compares every asset of shared/data with inventory.json, whose numbers come from an independent decoder.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/shared_data.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "gaussian/asset_summary.h"

namespace livegs {
namespace {

using Json = nlohmann::json;

// Four decimals of the inventory, plus float summation error.
constexpr double kRounding = 0.5e-4 + 1e-6;

double logarithmic(double x) { return std::copysign(std::log1p(std::abs(x)), x); }

// SOG stores positions in 65535 steps of their logarithm, and its writers round the last one down, so bounds
// may differ by one step.
double sog_step(const Json& listed, size_t axis, double value) {
  const double low = listed["bounds_min"][axis], high = listed["bounds_max"][axis];
  return (1 + std::abs(value)) * (logarithmic(high) - logarithmic(low)) / 65535;
}

void expect_bounds(const Json& listed, const char* key, const Eigen::Vector3f& found, AssetFormat format) {
  for (size_t axis = 0; axis < 3; ++axis) {
    const double value = listed[key][axis];
    const double step = format == AssetFormat::Sog ? sog_step(listed, axis, value) : 0;
    EXPECT_NEAR(found[static_cast<int>(axis)], value, kRounding + 1e-6 * std::abs(value) + step)
        << listed["file"] << " " << key << " axis " << axis;
  }
}

void expect_as_listed(const Json& listed) {
  const std::string name = listed["file"];
  const Result<AssetFile> file = read_asset(shared_data() / name);
  ASSERT_TRUE(file) << file.error().message;
  expect_invariants(file->asset, name);
  const AssetSummary summary = summarise(file->asset);
  EXPECT_EQ(summary.count, listed["splats"].get<size_t>()) << name;
  EXPECT_EQ(summary.sh_degree, listed["sh_degree"].get<int>()) << name;
  std::string format = format_name(file->format);
  if (file->format_version) format += " v" + std::to_string(file->format_version);
  EXPECT_TRUE(listed["format"].get<std::string>().starts_with(format)) << name << " was read as " << format;
  if (listed.contains("bounds_min")) {
    // The inventory uses the frame of the file; a half turn about x swaps and negates the bounds of y and z.
    Eigen::Vector3f low = summary.bounds_min, high = summary.bounds_max;
    if (file->y_up_in_file) {
      low.tail<2>() = -summary.bounds_max.tail<2>();
      high.tail<2>() = -summary.bounds_min.tail<2>();
    }
    expect_bounds(listed, "bounds_min", low, file->format);
    expect_bounds(listed, "bounds_max", high, file->format);
  }
  if (listed.contains("mean_opacity")) {
    EXPECT_NEAR(summary.mean_opacity, listed["mean_opacity"].get<double>(), kRounding) << name;
  }
}

TEST(Inventory, EveryAssetMatchesTheInventory) {
  LIVEGS_NEEDS_SHARED_DATA();
  const Result<std::string> text = read_text_file(shared_data() / "inventory.json");
  ASSERT_TRUE(text) << text.error().message;
  const Json assets = Json::parse(*text)["assets"];
  ASSERT_GT(assets.size(), 40u);
  for (const Json& listed : assets) expect_as_listed(listed);
}

TEST(Inventory, CapturedAssetsNeedNoRepair) {
  LIVEGS_NEEDS_SHARED_DATA();
  const Json assets = Json::parse(*read_text_file(shared_data() / "inventory.json"))["assets"];
  for (const Json& listed : assets) {
    const Result<AssetFile> file = read_asset(shared_data() / listed["file"].get<std::string>());
    ASSERT_TRUE(file) << file.error().message;
    for (const std::string& note : file->notes) ADD_FAILURE() << listed["file"] << ": " << note;
  }
}

}  // namespace
}  // namespace livegs
