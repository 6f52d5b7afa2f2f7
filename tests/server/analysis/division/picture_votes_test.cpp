// SPDX-License-Identifier: Apache-2.0
// Parts by a model: boxes on the pictures that it was sent, through the gate, to kernels.
#include "analysis/division/picture_votes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <random>

#include "analysis/analyze_scene.h"
#include "analysis/views/object_views.h"
#include "rates.h"
#include "server/analysis/division/composite_objects.h"
#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/model/fake_endpoint.h"

namespace livegs {
namespace {

using nlohmann::json;

PosedKernels posed_kernels(const CompositeObject& object) {
  PosedKernels kernels;
  const GaussianAsset& asset = object.asset;
  kernels.resize(asset.size());
  const Eigen::Quaternionf turn = object.object_from_asset.rotation.cast<float>();
  for (size_t i = 0; i < asset.size(); ++i) {
    kernels.positions_m[i] = (object.object_from_asset * asset.positions[i].cast<double>()).cast<float>();
    const Eigen::Matrix3f axes = (turn * asset.rotations[i]).toRotationMatrix() *
                                 asset.log_scales[i].array().exp().matrix().asDiagonal();
    const Eigen::Matrix3f spread = axes * axes.transpose();
    kernels.covariances_m2[i] = {spread(0, 0), spread(0, 1), spread(0, 2),
                                 spread(1, 1), spread(1, 2), spread(2, 2)};
    kernels.world_from_asset[i] = turn;
  }
  return kernels;
}

// Views of the objects, as target_views() makes them for a scene.
struct ViewedObjects {
  std::vector<CompositeObject> objects = composite_objects();
  std::vector<PosedKernels> kernels;
  std::vector<AnalysisTarget> targets;
  std::map<uint32_t, std::vector<PictureSights>> sights;  // of the first view

  ViewedObjects() {
    for (size_t i = 0; i < objects.size(); ++i) {
      const CompositeObject& object = objects[i];
      kernels.push_back(posed_kernels(object));
      ObjectFacts facts;
      facts.name = object.name;
      facts.scale_known = true;
      facts.kernels =
          std::make_shared<const SurfaceKernels>(surface_kernels(object.asset, object.object_from_asset));
      Eigen::AlignedBox3d bounds;
      for (const Eigen::Vector3f& at : facts.kernels->positions_m) bounds.extend(at.cast<double>());
      facts.mesh.size_m = facts.mesh.box_m = bounds.sizes();
      std::sort(facts.mesh.box_m.data(), facts.mesh.box_m.data() + 3, std::greater<>());
      facts.mesh.volume_m3 = 0.2 * bounds.volume();
      facts.mesh.hull_volume_m3 = 0.5 * bounds.volume();
      facts.mesh.area_m2 = 0.2 * bounds.sizes().squaredNorm();
      facts.mesh.mean_wall_m = 2 * facts.mesh.volume_m3 / facts.mesh.area_m2;
      facts.mesh.solidity = 0.4;
      AnalysisTarget target;
      target.object_id = static_cast<uint32_t>(i + 1);
      target.offline = estimate_offline(facts);
      target.facts = std::make_shared<const ObjectFacts>(std::move(facts));
      targets.push_back(std::move(target));
    }
  }

  Result<std::vector<TargetView>> look(uint32_t object_id, int count) {
    const CompositeObject& object = objects[object_id - 1];
    const DrawnObject drawn{&object.asset, &kernels[object_id - 1], object_id};
    ViewOptions options;
    options.long_side_px = 256;
    options.view_count = count;
    options.sight_stride = surface_stride(object.asset.size());
    auto views = object_views(std::span(&drawn, 1), object_id, options);
    if (!views) return views.error();
    std::vector<TargetView> looks;
    for (ObjectView& view : *views) {
      TargetView look;
      look.images = {{"outlined", "image/png", "a"}, {"cut-out", "image/png", "b"}};
      look.sights = std::move(view.sights);
      looks.push_back(std::move(look));
    }
    return looks;
  }
};

// The bounds of the pixels of one part on one picture, in thousandths, each side off by up to 1.5 % of the
// picture: synthetic, as a careful observer marks them. Empty if the part is hardly seen there.
json box_of_part(const CompositeObject& object, const PictureSights& sights, size_t picture, uint16_t part,
                 std::mt19937& random) {
  std::map<uint16_t, std::pair<double, double>> cells;  // weight of the part and of all
  for (const PictureSights::Seen& seen : sights.seen) {
    auto& [own, all] = cells[seen.cell];
    all += seen.weight;
    if (object.part[seen.kernel] == part) own += seen.weight;
  }
  int left = sights.columns, top = sights.rows, right = -1, bottom = -1, count = 0;
  for (const auto& [cell, weights] : cells) {
    if (weights.second < 0.3 || weights.first < 0.5 * weights.second) continue;
    const int column = cell % sights.columns, row = cell / sights.columns;
    left = std::min(left, column), right = std::max(right, column + 1);
    top = std::min(top, row), bottom = std::max(bottom, row + 1);
    ++count;
  }
  if (count < 5) return nullptr;
  const auto thousandths = [&](int at, int of) {
    const double off = 30.0 * (random() / 4294967295.0 - 0.5);
    return std::clamp(std::round(1000.0 * at / of + off), 0.0, 1000.0);
  };
  return {picture + 1, thousandths(left, sights.columns), thousandths(top, sights.rows),
          thousandths(right, sights.columns), thousandths(bottom, sights.rows)};
}

json marked_answer(const CompositeObject& object, const ObjectFacts& facts,
                   const std::vector<PictureSights>& sights, std::mt19937& random) {
  const ObjectRow& row = *find_object_row(object.name);
  json answer = mug_answer();
  answer["name"] = object.name;
  answer["fill"] = "assembly";
  answer["parts"] = json::array();
  for (size_t i = 0; i < row.parts.size(); ++i) {
    json boxes = json::array();
    for (size_t picture = 0; picture < sights.size(); ++picture) {
      json box = box_of_part(object, sights[picture], picture, static_cast<uint16_t>(i), random);
      if (!box.is_null()) boxes.push_back(std::move(box));
    }
    const bool inside = row.parts[i].place == PartPlace::Inside || row.parts[i].place == PartPlace::Filling;
    answer["parts"].push_back({{"name", row.parts[i].name},
                               {"material_id", row.parts[i].material},
                               {"share", row.parts[i].mass_share},
                               {"thickness_mm", nullptr},
                               {"inside", inside ? json(row.parts[0].name) : json(nullptr)},
                               {"boxes", boxes.empty() ? json(nullptr) : boxes}});
  }
  const double mass_g = 1e3 * estimate_offline(facts).mass_kg().best();
  answer["mass_g"] = {{"low", 0.8 * mass_g}, {"best", mass_g}, {"high", 1.25 * mass_g}};
  answer["fragile"] = false;
  for (const char* field : {"young_mpa", "structure_s", "plasticity_level", "plasticity"})
    answer[field] = nullptr;
  return answer;
}

// The same answer with each part listed twice: its left and its right half.
json in_halves(json answer) {
  json parts = json::array();
  for (const json& part : answer["parts"]) {
    for (const bool left : {true, false}) {
      json half = part;
      half["share"] = 0.5 * part["share"].get<double>();
      for (json& box : half["boxes"]) box[left ? 3 : 1] = 0.5 * (box[1].get<double>() + box[3].get<double>());
      parts.push_back(std::move(half));
    }
  }
  answer["parts"] = std::move(parts);
  return answer;
}

double share_in_right_part(const CompositeObject& object, const v1::PhysicalParameters& physics) {
  const PartPlaces places(physics.parts());
  const ObjectRow& row = *find_object_row(object.name);
  size_t right = 0;
  for (size_t i = 0; i < object.part.size(); ++i) {
    const Eigen::Vector3d point = object.object_from_asset * object.asset.positions[i].cast<double>();
    // The parts of an answer are sorted; names identify them.
    right +=
        physics.parts(static_cast<int>(places.at(point))).name() == row.parts[object.part[i]].name ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(object.part.size());
}

TEST(PictureVotes, BoxesOfAModelDivideEightObjects) {
  using Views = std::vector<std::pair<int, bool>>;  // count, boxes in halves
  for (const auto& [views, halves] :
       gate_or_full(Views{{1, true}}, Views{{1, false}, {1, true}, {3, false}})) {
    ViewedObjects viewed;
    std::mt19937 random(3);
    std::map<std::string, std::vector<TargetView>> shown;
    const TargetViews look = [&](uint32_t id, int count, std::stop_token) { return viewed.look(id, count); };
    const int view_count = views;
    const bool in_two = halves;
    // The fake model marks the pictures of the view it was asked about.
    std::map<std::string, size_t> asked;
    std::mutex one_at_a_time;
    FakeEndpoint endpoint(
        [&](const AnalysisQuestion& question, const ToolBox& tools, int) -> Result<std::string> {
          const std::lock_guard lock(one_at_a_time);
          const std::string& name = tools.object().name;
          const auto object = std::find_if(viewed.objects.begin(), viewed.objects.end(),
                                           [&](const auto& one) { return one.name == name; });
          const auto id = static_cast<uint32_t>(object - viewed.objects.begin() + 1);
          (void)question;
          const auto looks = viewed.look(id, view_count);
          const json answer =
              marked_answer(*object, tools.object(), (*looks)[asked[name]++ % looks->size()].sights, random);
          return (in_two ? in_halves(answer) : answer).dump();
        });
    AnalysisOptions options;
    options.views = views;
    std::vector<AnalysisUpdate> last(viewed.targets.size());
    analyze_scene(viewed.targets, &endpoint, look, options,
                  [&](const AnalysisUpdate& update) { last[update.index] = update; });
    for (size_t i = 0; i < last.size(); ++i) {
      const v1::PhysicalParameters& physics = last[i].judgement.proposal;
      ASSERT_EQ(last[i].judgement.verdict == Verdict::Refused, false) << last[i].judgement.message;
      const double right = share_in_right_part(viewed.objects[i], physics);
      std::printf("%d views, %-14s %.1f %% right; %s\n", views, viewed.objects[i].name.c_str(), 100 * right,
                  physics.parts_reason().c_str());
      EXPECT_EQ(physics.parts_source(), v1::EstimatedValue::MODEL);
      EXPECT_EQ(static_cast<size_t>(physics.parts_size()),
                find_object_row(viewed.objects[i].name)->parts.size());
      EXPECT_GE(right, 0.8) << viewed.objects[i].name;
    }
  }
}

TEST(PictureVotes, SmallestBoxCountsAndUnmarkedPicturesSayNothing) {
  // Two pictures of 10 x 10 cells; one kernel per cell of the first, all of them in one cell of the second.
  std::vector<PictureSights> pictures(2);
  for (PictureSights& picture : pictures) picture.columns = picture.rows = 10;
  for (uint32_t i = 0; i < 100; ++i) {
    pictures[0].seen.push_back({i, static_cast<uint16_t>(i), 1.0f});
    pictures[1].seen.push_back({i, 0, 5.0f});
  }
  std::vector<BoxedPart> parts(2);
  parts[0].boxes = {{0, 0, 0, 1, 1}};
  parts[1].boxes = {{0, 0, 0, 0.5, 0.2}};
  auto votes = picture_votes(pictures, parts, 100);
  for (uint32_t i = 0; i < 100; ++i) {
    const bool small = i % 10 < 5 && i / 10 < 2;
    EXPECT_EQ(votes[1][i], small ? 1.0f : 0.0f) << i;
    EXPECT_EQ(votes[0][i], small ? 0.0f : 1.0f) << i;
  }
  // A part without boxes has the rest of a marked picture.
  parts[0].boxes.clear();
  votes = picture_votes(pictures, parts, 100);
  EXPECT_EQ(votes[0][99], 1.0f);
  EXPECT_EQ(votes[0][0], 0.0f);
  // Out of range values of another picture are harmless.
  pictures[0].seen.push_back({1000, 5, 1.0f});
  pictures[0].seen.push_back({5, 60000, 1.0f});
  EXPECT_EQ(picture_votes(pictures, parts, 100)[0][99], 1.0f);
}

// Votes of two parts that are mixed everywhere cannot be separated by boxes.
TEST(PictureVotes, MixedVotesAreOnePart) {
  const CompositeObject object = composite_objects().front();
  const SurfaceKernels kernels = surface_kernels(object.asset, object.object_from_asset);
  MaterialParts parts;
  for (const char* name : {"a", "b"}) parts.Add()->set_name(name);
  std::vector<std::vector<float>> votes(2, std::vector<float>(kernels.weights.size(), 0.0f));
  for (size_t i = 0; i < kernels.weights.size(); ++i) votes[i * 7919 % 13 < 6 ? 0 : 1][i] = 1;
  const std::vector<std::optional<PartHolder>> inside(2);
  const VotedDivision mixed = divide_by_votes(kernels, votes, inside, parts);
  EXPECT_FALSE(mixed.divided) << mixed.reason;
  EXPECT_FALSE(PartPlaces(parts).divided());
  for (auto& part : votes) std::fill(part.begin(), part.end(), 0.0f);
  EXPECT_FALSE(divide_by_votes(kernels, votes, inside, parts).divided);
}

}  // namespace
}  // namespace livegs
