// SPDX-License-Identifier: Apache-2.0
// Kinds of .ply that tools write besides that of the INRIA trainer: two scales or one, colours as bytes,
// names of axes and units, marks of antialiased training, positions far from zero, activated values.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/differences.h"
#include "common/gaussian/ply/ply_columns.h"
#include "common/gaussian/synthetic_asset.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"

namespace livegs {
namespace {

bool any_note(const AssetFile& file, const std::string& text) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const std::string& note) { return note.find(text) != note.npos; });
}

TEST(PlyKinds, TwoScalesAreFlatKernels) {
  const GaussianAsset asset = synthetic_asset(50, 0, 1);
  for (const bool text : {false, true}) {
    std::vector<Column> columns = columns_of(asset);
    remove(columns, "scale_2");
    const auto file = decode_asset(ply_of(columns, 50, "", text), "surfels.ply");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_TRUE(any_note(*file, "2DGS"));
    for (size_t i = 0; i < 50; ++i) {
      EXPECT_EQ(file->asset.log_scales[i].head<2>(), asset.log_scales[i].head<2>());
      EXPECT_NEAR(file->asset.log_scales[i].z(), asset.log_scales[i].head<2>().minCoeff() + std::log(1e-3),
                  1e-5);
      EXPECT_LT((file->asset.rotations[i].coeffs() - asset.rotations[i].coeffs()).norm(), 1e-6);
    }
  }
}

TEST(PlyKinds, OneScaleIsARoundKernel) {
  const GaussianAsset asset = synthetic_asset(50, 0, 1);
  for (const bool rotated : {false, true}) {
    std::vector<Column> columns = columns_of(asset);
    for (const char* name : {"scale_1", "scale_2"}) remove(columns, name);
    for (const char* name : {"rot_0", "rot_1", "rot_2", "rot_3"}) {
      if (!rotated) remove(columns, name);
    }
    const auto file = decode_asset(ply_of(columns, 50), "round.ply");
    ASSERT_TRUE(file) << file.error().message;
    expect_invariants(file->asset, "round");
    EXPECT_EQ(file->asset.log_scales[7], Eigen::Vector3f::Constant(asset.log_scales[7].x()));
  }
}

TEST(PlyKinds, MissingPropertiesAreNamed) {
  const GaussianAsset asset = synthetic_asset(5, 0, 1);
  for (const char* name : {"x", "f_dc_1", "opacity", "scale_0", "scale_1", "rot_2"}) {
    std::vector<Column> columns = columns_of(asset);
    remove(columns, name);
    const auto file = decode_asset(ply_of(columns, 5), "part.ply");
    ASSERT_FALSE(file) << name;
    EXPECT_NE(file.error().message.find(name), std::string::npos) << file.error().message;
  }
}

TEST(PlyKinds, ColoursOfBytesIntegersAndFractions) {
  const GaussianAsset asset = synthetic_asset(200, 0, 2);
  struct Kind {
    const char* type;
    double full, step;
    std::array<const char*, 3> names;
  };
  for (const Kind& kind :
       {Kind{"uchar", 255, 1, {"red", "green", "blue"}},
        Kind{"uchar", 255, 1, {"diffuse_red", "diffuse_green", "diffuse_blue"}},
        Kind{"ushort", 65535, 1, {"red", "green", "blue"}}, Kind{"float", 1, 0, {"red", "green", "blue"}},
        Kind{"float", 255, 0, {"r", "g", "b"}}}) {
    std::vector<Column> columns = columns_of(asset);
    for (int k = 0; k < 3; ++k) {
      Column& column = named(columns, "f_dc_" + std::to_string(k));
      column = {kind.type, kind.names[static_cast<size_t>(k)], [&asset, &kind, k](size_t i) {
                  const double share =
                      std::clamp(0.5 + double{kShBand0} * double{asset.sh_dc[i][k]}, 0.0, 1.0);
                  return kind.step > 0 ? std::round(share * kind.full) : share * kind.full;
                }};
    }
    const auto file = decode_asset(ply_of(columns, 200), "colours.ply");
    ASSERT_TRUE(file) << file.error().message;
    for (size_t i = 0; i < 200; ++i) {
      const double bound = 0.5 * kind.step / kind.full / double{kShBand0} + 1e-5;
      EXPECT_LE((file->asset.sh_dc[i] - asset.sh_dc[i]).cwiseAbs().maxCoeff(), bound) << kind.type << i;
    }
  }
}

// Both kinds of colour: the harmonic is exact and is used.
TEST(PlyKinds, HarmonicsComeBeforeBytes) {
  const GaussianAsset asset = synthetic_asset(20, 0, 2);
  std::vector<Column> columns = columns_of(asset);
  for (const char* name : {"red", "green", "blue"})
    columns.push_back({"uchar", name, [](size_t) { return 9.0; }});
  const auto file = decode_asset(ply_of(columns, 20), "both.ply");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->asset.sh_dc[3], asset.sh_dc[3]);
}

TEST(PlyKinds, CommentsNameAxesUnitsAndOrigin) {
  const GaussianAsset asset = synthetic_asset(40, 0, 3);
  const auto frame_of = [&](const std::string& comment) {
    const auto file = decode_asset(ply_of(columns_of(asset), 40, "comment " + comment + "\n"), "a.ply");
    EXPECT_TRUE(file) << file.error().message;
    return std::pair(file->frame, file->notes.size());
  };
  for (const auto& [comment, axis] :
       {std::pair("Vertical Axis: z", "z"), std::pair("vertical axis: Z", "z"),
        std::pair("Vertical axis: y", "y"), std::pair("VERTICAL AXIS :-Y", "-y"),
        std::pair("Up Axis: +x", "x"), std::pair("up: z-up", "z")}) {
    EXPECT_EQ(frame_of(comment).first.up_axis, axis) << comment;
    EXPECT_EQ(frame_of(comment).second, 0u) << comment;
  }
  for (const char* comment :
       {"Vertical Axis: q", "Vertical Axis:", "Unit: parsec", "Unit: -2 m", "Unit: nan m"}) {
    EXPECT_EQ(frame_of(comment).second, 1u) << comment;  // one note, the file is read
    EXPECT_EQ(frame_of(comment).first.up_axis, "");
    EXPECT_EQ(frame_of(comment).first.metres_per_unit, 0);
  }
  EXPECT_EQ(frame_of("Unit: mm").first.metres_per_unit, 0.001);
  EXPECT_EQ(frame_of("units: Feet").first.metres_per_unit, 0.3048);
  EXPECT_EQ(frame_of("Unit: 0.25 m").first.metres_per_unit, 0.25);
  EXPECT_EQ(frame_of("Origin: 5 -6e5 7.25").first.origin, Eigen::Vector3d(5, -6e5, 7.25));
  EXPECT_EQ(frame_of("Origin: Kyoto").first.origin, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(frame_of("Generated by Nerstudio 1.1.5").second, 0u);
}

TEST(PlyKinds, AntialiasedMarksOfAllTools) {
  const GaussianAsset asset = synthetic_asset(5, 0, 3);
  const auto marked = [&](const std::string& comments) {
    const auto file = decode_asset(ply_of(columns_of(asset), 5, comments), "a.ply");
    EXPECT_TRUE(file) << file.error().message;
    return file->asset.antialiased;
  };
  for (const char* mark : {"SplatRenderMode: mip", "SplatRenderMode: Mip", "SPLATRENDERMODE: MIP",
                           "splatRenderMode:mip", "antialiased 1", "Antialiased 1", "antialiased: true"})
    EXPECT_TRUE(marked(std::string("comment ") + mark + "\n")) << mark;
  for (const char* mark : {"SplatRenderMode: default", "SplatRenderMode: 2dgs", "antialiased 0", "mip",
                           "not antialiased 1", "SplatRenderMode:"})
    EXPECT_FALSE(marked(std::string("comment ") + mark + "\n")) << mark;
  EXPECT_TRUE(marked("comment Exported from Brush\ncomment SH degree: 0\ncomment SplatRenderMode: Mip\n"));
}

// A cube that is moved to a place on the earth. Positions as doubles, or as text, keep its shape.
TEST(PlyKinds, DoublesFarFromZeroKeepTheirShape) {
  GaussianAsset asset = synthetic_asset(300, 0, 4);
  for (Eigen::Vector3f& scale : asset.log_scales) scale.setConstant(std::log(0.02f));
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(500000.25, 5400000.5, 312.125), Eigen::Vector3d(-2694045.5, -4266795.25, 3888310.0),
        Eigen::Vector3d(0, 0, 4e6), Eigen::Vector3d(3e9, 0, 0)}) {
    for (const bool text : {false, true}) {
      std::vector<Column> columns = columns_of(asset);
      for (int k = 0; k < 3; ++k) {
        Column& column = named(columns, std::string(1, "xyz"[k]));
        column.type = text ? "float" : "double";
        column.value = [&, k](size_t i) { return place[k] + double{asset.positions[i][k]}; };
      }
      const auto file = decode_asset(ply_of(columns, 300, "", text), "utm.ply");
      ASSERT_TRUE(file) << file.error().message;
      EXPECT_TRUE(any_note(*file, "subtracted")) << place.transpose();
      double worst = 0;
      for (size_t i = 0; i < 300; ++i) {
        const Eigen::Vector3d moved = file->frame.origin + file->asset.positions[i].cast<double>();
        worst = std::max(worst, (moved - place - asset.positions[i].cast<double>()).cwiseAbs().maxCoeff());
      }
      EXPECT_LE(worst, place.x() > 1e9 ? 1e-6 : 2e-7)
          << place.transpose();  // a float of 3 and a double of 1e9
      EXPECT_LE(file->asset.positions[0].norm(), 5) << place.transpose();

      // Written back on request, else noted.
      const auto with = decode_asset(encode_ply(file->asset, file->frame, true), "back.ply");
      const auto noted = decode_asset(encode_ply(file->asset, file->frame), "noted.ply");
      ASSERT_TRUE(with && noted);
      for (const auto* back : {&*with, &*noted}) {
        EXPECT_LE((back->frame.origin + back->asset.positions[9].cast<double>() - file->frame.origin -
                   file->asset.positions[9].cast<double>())
                      .norm(),
                  1e-6);
      }
    }
  }
}

TEST(PlyKinds, FloatsFarFromZeroAreReportedWithTheLoss) {
  GaussianAsset asset = synthetic_asset(300, 0, 4);
  for (Eigen::Vector3f& scale : asset.log_scales) scale.setConstant(std::log(0.02f));
  GaussianAsset far = asset;
  for (Eigen::Vector3f& position : far.positions) position += Eigen::Vector3f(500000, 5400000, 30);
  const auto file = decode_asset(encode_ply(far), "far.ply");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(any_note(*file, "steps of 0.5 units")) << file->notes.size();
  EXPECT_LE(file->asset.positions[0].norm(), 5);
  // Near zero nothing happens, for floats and doubles.
  const auto near = decode_asset(encode_ply(asset), "near.ply");
  ASSERT_TRUE(near);
  EXPECT_TRUE(near->notes.empty());
  EXPECT_TRUE(near->frame.origin.isZero(0));
  std::vector<Column> columns = columns_of(asset);
  for (const char* axis : {"x", "y", "z"}) named(columns, axis).type = "double";
  const auto doubles = decode_asset(ply_of(columns, 300), "near.ply");
  ASSERT_TRUE(doubles);
  EXPECT_TRUE(doubles->notes.empty());
  EXPECT_EQ(doubles->asset.positions[5], asset.positions[5]);
}

// A far point does not move an asset that lies at zero.
TEST(PlyKinds, AFarPointMovesNothing) {
  GaussianAsset asset = synthetic_asset(100, 0, 4);
  for (Eigen::Vector3f& scale : asset.log_scales) scale.setConstant(std::log(0.02f));
  asset.positions[3] = {1e7f, -1e12f, 1e17f};
  const auto file = decode_asset(encode_ply(asset), "a.ply");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->asset.positions[3], asset.positions[3]);
}

std::vector<std::byte> activated(const GaussianAsset& asset, bool opacities = true) {
  GaussianAsset raw = asset;
  for (Eigen::Vector3f& scale : raw.log_scales) scale = scale.array().exp();
  for (float& opacity : raw.opacity_logits) opacity = opacities ? opacity_of_logit(opacity) : opacity;
  return encode_ply(raw);
}

TEST(PlyKinds, ActivatedValuesAreRecognised) {
  for (const double deviation : {0.001, 0.01, 0.1}) {
    for (const double opacity : {0.2, 0.9, 0.999}) {
      const GaussianAsset asset = ball_asset(500, deviation, opacity);
      const auto file = decode_asset(activated(asset), "activated.ply");
      ASSERT_TRUE(file) << file.error().message;
      EXPECT_TRUE(any_note(*file, "activated")) << deviation;
      EXPECT_NEAR(file->asset.log_scales[3].x(), asset.log_scales[3].x(), 1e-4);
      EXPECT_NEAR(opacity_of_logit(file->asset.opacity_logits[3]), opacity, 1e-4);
    }
  }
  // Activated deviations with logits: only the deviations are converted.
  const auto mixed = decode_asset(activated(ball_asset(500, 0.01, 0.9), false), "mixed.ply");
  ASSERT_TRUE(mixed);
  EXPECT_NEAR(mixed->asset.log_scales[3].x(), std::log(0.01), 1e-4);
  EXPECT_NEAR(opacity_of_logit(mixed->asset.opacity_logits[3]), 0.9, 1e-4);
}

TEST(PlyKinds, UsualFilesAreNotTakenForActivated) {
  for (const double deviation : {0.001, 0.01, 0.3}) {
    const auto file = decode_asset(encode_ply(ball_asset(500, deviation, 0.7)), "logs.ply");
    ASSERT_TRUE(file);
    EXPECT_FALSE(any_note(*file, "activated"));
    EXPECT_NEAR(file->asset.log_scales[3].x(), std::log(deviation), 1e-6);
  }
  // Large units: kernels of deviation 1.5 on a ball of radius 100 have scales above 0 as logarithms too.
  GaussianAsset large = ball_asset(500, 1.5, 0.7);
  for (Eigen::Vector3f& position : large.positions) position *= 100;
  const auto file = decode_asset(encode_ply(large), "large.ply");
  ASSERT_TRUE(file);
  EXPECT_NEAR(file->asset.log_scales[3].x(), std::log(1.5), 1e-6);
  EXPECT_TRUE(any_note(*file, "--activated"));  // likely, not certain: said, not done
}

TEST(PlyKinds, OptionDecidesActivatedValues) {
  using Activated = ReadOptions::Activated;
  const std::vector<std::byte> few = activated(ball_asset(5, 0.01, 0.9));
  const auto yes = decode_asset(few, "few.ply", {Activated::Yes});
  ASSERT_TRUE(yes) << yes.error().message;
  EXPECT_NEAR(yes->asset.log_scales[0].x(), std::log(0.01), 1e-4);
  const auto no = decode_asset(activated(ball_asset(500, 0.01, 0.9)), "no.ply", {Activated::No});
  ASSERT_TRUE(no);
  EXPECT_NEAR(no->asset.log_scales[0].x(), 0.01, 1e-6);
  const auto refused = decode_asset(encode_ply(ball_asset(5, 0.01, 0.999)), "logs.ply", {Activated::Yes});
  EXPECT_FALSE(refused);
  // A deviation of 0 and opacities of 0 and 1 are values that the readers repair.
  GaussianAsset edge = ball_asset(5, 0.01, 0.9);
  for (Eigen::Vector3f& scale : edge.log_scales) scale.setZero();
  edge.opacity_logits = {0, 1, 0.5f, 1, 0};
  const auto repaired = decode_asset(encode_ply(edge), "edge.ply", {Activated::Yes});
  ASSERT_TRUE(repaired) << repaired.error().message;
  expect_invariants(repaired->asset, "edge");
}

}  // namespace
}  // namespace livegs
