// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "known_gaps.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "rates.h"
#include "scene/scene.h"
#include "skin/skin_kernels.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

// Captured assets, by their path below the data folder. The gate runs those of up to 1.2 MB; the nightly run
// takes all. SOG v1 is not supported.
std::vector<std::string> captured_assets() {
  const fs::path folder = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats";
  std::vector<std::string> assets;
  std::error_code error;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const std::string path = at->path().string();
    const bool asset = path.ends_with(".ply") || path.ends_with(".spz") || path.ends_with(".splat") ||
                       path.ends_with(".sog");
    const bool unpacked = at->path().filename() == "meta.json" && path.find("fur_block") == std::string::npos;
    const bool small = at->is_regular_file(error) && at->file_size() < 1'200'000;
    if ((asset || unpacked) && (small || full_sets()))
      assets.push_back(fs::relative(at->path(), folder).string());
  }
  std::sort(assets.begin(), assets.end());
  if (assets.empty()) assets.push_back("");
  return assets;
}

class CapturedAsset : public testing::TestWithParam<std::string> {};

// Runs an asset through the whole pipeline without manual settings: file, body, two seconds of simulation,
// skinned kernels.
TEST_P(CapturedAsset, FallsAndStaysFinite) {
  if (GetParam().empty()) GTEST_SKIP() << "the shared data is missing";
  v1::Scene file;
  v1::Object& object = *file.add_objects();
  object.set_name(fs::path(GetParam()).stem().string());
  object.set_asset(GetParam());
  file.mutable_environment()->add_colliders()->mutable_plane()->add_point_m(0);
  file.mutable_environment()->mutable_colliders(0)->mutable_plane()->add_point_m(-2.0);
  file.mutable_environment()->mutable_colliders(0)->mutable_plane()->add_point_m(0);
  auto scene = Scene::build(file, fs::path(LIVEGS_SHARED_DATA_DIR) / "splats", GetParam(), {});
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneObject& drawn = scene->objects().back();
  EXPECT_GT(drawn.mass_kg, 0);
  RecordProperty("body", v1::Physics::Behavior_Name(drawn.physics.behavior()) + " " + drawn.surface_note);
  const double start_y = scene->bounds_m().center().y();
  for (int tick = 0; tick < 180; ++tick) scene->step();
  const DriverFrame frame = scene->world().drivers();
  for (const ObjectDrivers& drivers : frame.objects) {
    const SceneObject& of = *scene->find(drivers.object_id);
    ASSERT_TRUE(check_drivers(of.rest, drivers)) << of.name;
    auto bindings = bind_kernels(*of.asset, of.rest);
    ASSERT_TRUE(bindings) << bindings.error().message;
    PosedKernels kernels;
    skin_kernels(*of.asset, of.rest, *bindings, drivers, kernels);
    for (size_t i = 0; i < kernels.positions_m.size(); ++i) {
      ASSERT_TRUE(kernels.positions_m[i].allFinite());
      for (float entry : kernels.covariances_m2[i]) ASSERT_TRUE(std::isfinite(entry));
    }
  }
  for (const BodyState& body : scene->world().bodies()) {
    if (body.object_id != drawn.id) continue;
    EXPECT_LT(body.world_from_body.position_m.y(), start_y - 0.5);  // it fell
    EXPECT_GT(body.world_from_body.position_m.y(), -2.01);          // the floor supported it
  }
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param.empty() ? "absent" : info.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}
// A thin-walled capture with the estimated material, 0.3 m above a floor. Its nearly empty cells need shorter
// steps than full ones (kMaxThinCourant).
TEST(CapturedShell, GainsNoEnergyWhenItLands) {
  const fs::path folder = fs::path(LIVEGS_SHARED_DATA_DIR) / "splats/camera_leica";
  if (!fs::exists(folder)) GTEST_SKIP() << "the shared data is missing";
  for (const double rate_hz : {60.0, 72.0, 85.0, 90.0, 100.0, 120.0}) {
    v1::Scene file;
    file.set_rate_hz(rate_hz);
    v1::Object& object = *file.add_objects();
    object.set_name("leica");  // by the estimate a thin shell of ABS, elastic
    object.set_asset("leica-sofort-top8192.ply");
    for (const double entry : {0.0, 0.3, 0.0}) object.mutable_pose()->add_position_m(entry);
    file.mutable_environment()->add_colliders()->mutable_plane();
    auto scene = Scene::build(file, folder, "leica", {});
    ASSERT_TRUE(scene) << scene.error().message;
    const ElasticBody* body = scene->world().elastic_body(scene->find("leica")->id);
    ASSERT_TRUE(body);
    EXPECT_GT(body->accuracy().thin_part, kMaxThinPart);
    EXPECT_LT(body->accuracy().courant, 1.001 * kMaxThinCourant);
    const auto energy_j = [&] {
      const BodyEnergy energy = scene->world().energy();
      return energy.kinetic_j + energy.elastic_j + energy.gravity_j;
    };
    const double start_j = energy_j();
    double most = 1.0;
    for (int tick = 0; tick < 2 * rate_hz; ++tick) {
      scene->step();
      most = std::max(most, energy_j() / start_j);
    }
    report_gap("captured.landing_energy", most);
    EXPECT_LT(most, 1.1) << rate_hz << " Hz";
  }
}

INSTANTIATE_TEST_SUITE_P(Captured, CapturedAsset, testing::ValuesIn(captured_assets()), test_name);

}  // namespace
}  // namespace livegs
