// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <functional>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/differences.h"
#include "common/gaussian/gltf/gltf_sample.h"
#include "common/gaussian/synthetic_asset.h"
#include "core/file.h"
#include "gaussian/asset_file.h"
#include "gaussian/spherical_harmonics.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

using Json = nlohmann::json;

AssetFile read_glb(const GltfSample& sample) {
  Result<AssetFile> file = decode_asset(sample.glb(), "sample.glb");
  EXPECT_TRUE(file) << file.error().message;
  return file ? std::move(*file) : AssetFile{};
}

void expect_equal_kernels(const GaussianAsset& a, const GaussianAsset& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.sh_degree, b.sh_degree);
  const Differences worst = differences(a, b, same_order(a.size()));
  EXPECT_LE(worst.position, 1e-6f);
  EXPECT_LE(worst.log_scale, 1e-5f);
  EXPECT_LE(worst.rotation_deg, 0.05f);
  EXPECT_LE(worst.opacity, 1e-6f);
  EXPECT_LE(worst.sh_dc, 1e-6f);
  EXPECT_LE(worst.sh1, 1e-5f);
  EXPECT_LE(worst.sh_rest, 1e-5f);
}

TEST(Gltf, ReadsEveryDegreeFromEveryContainer) {
  const ScratchFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianAsset asset = synthetic_asset(120, degree, 70 + static_cast<uint64_t>(degree));
    const GltfSample sample = gltf_sample(asset);
    const AssetFile glb = read_glb(sample);
    expect_equal_kernels(asset, glb.asset);
    EXPECT_EQ(glb.format, AssetFormat::Gltf);
    EXPECT_TRUE(glb.y_up_in_file);
    EXPECT_EQ(glb.frame.metres_per_unit, 1);
    const auto inside = decode_asset(sample.gltf(sample.data_uri()), "sample.gltf");
    ASSERT_TRUE(inside) << inside.error().message;
    expect_equal_kernels(asset, inside->asset);
    ASSERT_TRUE(write_file_atomically(folder / "the buffer.bin", sample.binary));
    ASSERT_TRUE(write_file_atomically(folder / "s.gltf", sample.gltf("the%20buffer.bin")));
    const auto apart = read_asset(folder / "s.gltf");
    ASSERT_TRUE(apart) << apart.error().message;
    expect_equal_kernels(asset, apart->asset);
    // The bytes alone have no folder.
    EXPECT_FALSE(decode_asset(sample.gltf("the%20buffer.bin"), "s.gltf"));
  }
  for (const char* uri : {"../secret.bin", "/etc/passwd", "a/../../b", "%2e%2e/b", "C:\\b", ""}) {
    ASSERT_TRUE(write_file_atomically(folder / "s.gltf", gltf_sample(synthetic_asset(3, 0, 1)).gltf(uri)));
    const auto refused = read_asset(folder / "s.gltf");
    ASSERT_FALSE(refused) << uri;
    EXPECT_NE(refused.error().message.find("below"), std::string::npos) << refused.error().message;
  }
}

Eigen::Matrix3d covariance_of(const GaussianAsset& asset, size_t i) {
  const Eigen::Matrix3d axes = asset.rotations[i].cast<double>().toRotationMatrix();
  const Eigen::Array3d variances = (2 * asset.log_scales[i].cast<double>().array()).exp();
  return axes * variances.matrix().asDiagonal() * axes.transpose();
}

Eigen::Vector3f colour_of(const GaussianAsset& asset, size_t i, const Eigen::Vector3d& direction) {
  return evaluate_sh_colour(asset.sh_dc[i], asset.sh_rest.data() + i * asset.sh_rest_count(), asset.sh_degree,
                            direction.normalized().cast<float>());
}

// Nodes move, turn, stretch, shear and mirror: positions by M, covariances by M C M^T, and a colour is the
// same seen from the moved direction.
TEST(Gltf, NodesPlaceKernels) {
  const GaussianAsset asset = synthetic_asset(60, 3, 75);
  const Eigen::Matrix3d flip = Eigen::Vector3d(1, -1, -1).asDiagonal();  // -y up from y up
  Eigen::Affine3d turned = Eigen::Affine3d::Identity();
  turned.translate(Eigen::Vector3d(1, -2, 3));
  turned.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()));
  Eigen::Affine3d uniform = turned, stretched = turned, mirrored = turned;
  uniform.scale(0.25);
  stretched.scale(Eigen::Vector3d(0.5, 1, 3));
  mirrored.scale(Eigen::Vector3d(-2, 2, 2));
  for (const Eigen::Affine3d& placement : {turned, uniform, stretched, mirrored}) {
    GltfSample sample = gltf_sample(asset);
    // Half of it by a parent with a matrix, half by a child with parts.
    Eigen::Affine3d parent = placement;
    parent.translate(Eigen::Vector3d(0, 0, -1));
    std::vector<double> matrix(parent.matrix().data(), parent.matrix().data() + 16);
    sample.json["nodes"][1] = {{"matrix", matrix}, {"children", Json::array({0})}};
    sample.json["nodes"][0]["translation"] = Json::array({0, 0, 1});
    sample.json["scenes"][0]["nodes"] = Json::array({1});
    const AssetFile file = read_glb(sample);
    ASSERT_EQ(file.asset.size(), asset.size());
    expect_invariants(file.asset, "placed");
    const Eigen::Matrix3d linear = flip * placement.linear() * flip;
    const bool stretch = std::abs(placement.linear().col(0).norm() - placement.linear().col(2).norm()) > 1e-9;
    for (size_t i = 0; i < asset.size(); ++i) {
      const Eigen::Vector3d expected = flip * (placement * (flip * asset.positions[i].cast<double>()));
      EXPECT_LE((file.asset.positions[i].cast<double>() - expected).norm(), 2e-6);
      const Eigen::Matrix3d shape = linear * covariance_of(asset, i) * linear.transpose();
      EXPECT_LE((covariance_of(file.asset, i) - shape).norm(), 2e-5 * shape.norm());
      if (stretch) continue;  // directions of colours follow the turn only
      const Eigen::Vector3d direction(0.3, -0.5, 0.8);
      const Eigen::Vector3f before = colour_of(asset, i, direction),
                            after = colour_of(file.asset, i, linear * direction);
      EXPECT_LE((before - after).cwiseAbs().maxCoeff(), 2e-5f);
    }
  }
}

// A translation of UTM coordinates in a node is kept in double precision.
TEST(Gltf, FarNodesKeepTheirShape) {
  GaussianAsset asset = synthetic_asset(100, 0, 76);
  for (Eigen::Vector3f& scale : asset.log_scales) scale.setConstant(-4);
  GltfSample sample = gltf_sample(asset);
  sample.json["nodes"][0]["translation"] = Json::array({500000.5, 300.25, -5400000.125});
  const AssetFile file = read_glb(sample);
  for (size_t i = 0; i < asset.size(); ++i) {
    const Eigen::Vector3d place = file.frame.origin + file.asset.positions[i].cast<double>();
    const Eigen::Vector3d expected =
        Eigen::Vector3d(500000.5, -300.25, 5400000.125) + asset.positions[i].cast<double>();
    EXPECT_LE((place - expected).norm(), 1e-6);
  }
}

TEST(Gltf, ReadsSpzInABufferView) {
  const GaussianAsset asset = synthetic_asset(80, 1, 77);
  for (const bool nested : {true, false}) {
    GltfSample sample = gltf_sample(asset);
    const size_t view = sample.add_view(*encode_spz(asset));
    Json& extensions = sample.json["meshes"][0]["primitives"][0]["extensions"];
    if (nested) {
      extensions["KHR_gaussian_splatting"]["extensions"]["KHR_gaussian_splatting_compression_spz_2"] = {
          {"bufferView", view}};
    } else {
      extensions["KHR_spz_gaussian_splats_compression"] = {{"bufferView", view}};
    }
    const AssetFile file = read_glb(sample);
    ASSERT_EQ(file.asset.size(), asset.size());
    const Differences worst = differences(asset, file.asset, same_order(asset.size()));
    EXPECT_LE(worst.position, 1.0f / 8192 + 1e-5f);
    EXPECT_LE(worst.log_scale, 1.0f / 32 + 1e-5f);
    EXPECT_LE(worst.sh1, 4.5f / 128 + 1e-5f);
  }
}

// The draft of 2025: _ROTATION, _SCALE, and COLOR_0 with opacity.
TEST(Gltf, NodesShareAnSpz) {
  GltfSample sample = gltf_sample(synthetic_asset(80, 1, 77));
  const size_t view = sample.add_view(*encode_spz(synthetic_asset(80, 1, 77)));
  Json& extensions = sample.json["meshes"][0]["primitives"][0]["extensions"];
  extensions["KHR_spz_gaussian_splats_compression"] = {{"bufferView", view}};
  Json second = sample.json["nodes"][0];
  second["translation"] = {5, 0, 0};
  sample.json["nodes"].push_back(second);
  sample.json["scenes"][0]["nodes"] = {0, 1};
  const AssetFile file = read_glb(sample);
  ASSERT_EQ(file.asset.size(), 160u);
  for (size_t i = 0; i < 80; ++i)
    EXPECT_NEAR(file.asset.positions[80 + i].x() - file.asset.positions[i].x(), 5, 1e-5);
}

// A kernel of infinite size under a node that stretches is dropped, with the same bits in every run.
TEST(Gltf, InfiniteKernelsAreDropped) {
  GltfSample sample = gltf_sample(synthetic_asset(20, 0, 77));
  sample.json["nodes"][0]["scale"] = {1, 2, 3};
  const size_t accessor =
      sample.json["meshes"][0]["primitives"][0]["attributes"]["KHR_gaussian_splatting:SCALE"];
  const size_t view = sample.json["accessors"][accessor]["bufferView"];
  const size_t offset = sample.json["bufferViews"][view].value("byteOffset", size_t{0});
  const float infinite = INFINITY;
  std::memcpy(sample.binary.data() + offset, &infinite, sizeof infinite);
  EXPECT_EQ(read_glb(sample).asset.size(), 19u);
}

TEST(Gltf, ReadsTheDraft) {
  const GaussianAsset asset = synthetic_asset(30, 0, 78);
  GltfSample sample = gltf_sample(asset);
  Json& attributes = sample.json["meshes"][0]["primitives"][0]["attributes"];
  std::vector<float> colours;
  for (size_t i = 0; i < asset.size(); ++i) {
    for (const float dc : asset.sh_dc[i]) colours.push_back(0.5f + kShBand0 * dc);
    colours.push_back(0.25f);
  }
  attributes = {{"POSITION", attributes["POSITION"]},
                {"_ROTATION", attributes["KHR_gaussian_splatting:ROTATION"]},
                {"_SCALE", attributes["KHR_gaussian_splatting:SCALE"]},
                {"COLOR_0", sample.add(colours, 4)}};
  const AssetFile file = read_glb(sample);
  EXPECT_LE((file.asset.sh_dc[7] - asset.sh_dc[7]).norm(), 1e-5);
  EXPECT_NEAR(file.asset.opacity_logits[7], std::log(0.25 / 0.75), 1e-5);
}

// Linear colours become sRGB: a grey of 0.2140 in light is 0.5 on the screen.
TEST(Gltf, ConvertsLinearColours) {
  GaussianAsset asset = synthetic_asset(1, 0, 79);
  asset.sh_dc[0].setConstant((0.21404f - 0.5f) / kShBand0);
  GltfSample sample = gltf_sample(asset);
  sample.json["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]["colorSpace"] =
      "lin_rec709_display";
  const AssetFile file = read_glb(sample);
  EXPECT_NEAR(file.asset.sh_dc[0].x(), 0, 1e-3);
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST(Gltf, FramesOfOurOwnAreRead) {
  GltfSample sample = gltf_sample(synthetic_asset(3, 0, 79));
  sample.json["asset"]["extras"]["livegs"] = Json::array({"Unit: unknown", "SplatRenderMode: mip", 7});
  const AssetFile file = read_glb(sample);
  EXPECT_EQ(file.frame.metres_per_unit, 0);
  EXPECT_TRUE(file.asset.antialiased);
}

TEST(Gltf, RefusesWithTheReason) {
  const auto refused = [](const std::function<void(GltfSample&)>& change, const std::string& reason) {
    GltfSample sample = gltf_sample(synthetic_asset(4, 1, 80));
    change(sample);
    const auto file = decode_asset(sample.glb(), "bad.glb");
    ASSERT_FALSE(file) << reason;
    EXPECT_TRUE(file.error().message.starts_with("bad.glb")) << file.error().message;
    EXPECT_NE(file.error().message.find(reason), std::string::npos) << file.error().message;
  };
  const auto primitive = [](GltfSample& s) -> Json& { return s.json["meshes"][0]["primitives"][0]; };
  refused([&](GltfSample& s) { primitive(s).erase("extensions"); }, "not a mesh");
  refused([&](GltfSample& s) { primitive(s)["attributes"].erase("KHR_gaussian_splatting:SCALE"); }, "SCALE");
  refused([&](GltfSample& s) { primitive(s)["attributes"].erase("KHR_gaussian_splatting:OPACITY"); },
          "COLOR_0");
  refused(
      [&](GltfSample& s) { primitive(s)["attributes"].erase("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2"); },
      "SH_DEGREE_1_COEF_2");
  refused([&](GltfSample& s) { primitive(s)["extensions"]["KHR_gaussian_splatting"]["kernel"] = "cube"; },
          "instead of ellipse");
  refused([](GltfSample& s) { s.json["accessors"][0]["count"] = 4000000000u; },
          "more than its buffer view holds");
  refused([](GltfSample& s) { s.json["accessors"][1]["count"] = 3; }, "3 elements for 4 kernels");
  refused([](GltfSample& s) { s.json["accessors"][0]["type"] = "VEC2"; }, "3 components");
  refused([](GltfSample& s) { s.json["accessors"][0]["sparse"] = Json::object(); }, "sparse");
  refused([](GltfSample& s) { s.json["bufferViews"][0]["byteLength"] = 1e9; }, "beyond its buffer");
  refused(
      [](GltfSample& s) {
        s.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = Json::object();
      },
      "EXT_meshopt_compression");
  refused([](GltfSample& s) { s.json["buffers"][0]["byteLength"] = 1u << 30; }, "bytes instead of");
  refused([](GltfSample& s) { s.json["nodes"][0]["children"] = Json::array({0}); }, "two parents");
  refused([](GltfSample& s) { s.json["nodes"][0]["scale"] = "large"; }, "no valid matrix");
  refused([](GltfSample& s) { s.json["nodes"][0]["mesh"] = 5; }, "meshes");
  refused([](GltfSample& s) { s.json["scene"] = -1; }, "scenes");
  refused([](GltfSample& s) { s.json.erase("asset"); }, "asset.version");
}

// A mesh of many nodes is an asset of many kernels, but not of more than its size explains.
TEST(Gltf, InstancesAreLimited) {
  GltfSample sample = gltf_sample(synthetic_asset(200, 0, 81));
  const auto with_nodes = [&](int count) {
    Json nodes = Json::array(), roots = Json::array();
    for (int i = 0; i < count; ++i) {
      nodes.push_back({{"mesh", 0}, {"translation", Json::array({i, 0, 0})}});
      roots.push_back(i);
    }
    sample.json["nodes"] = nodes;
    sample.json["scenes"][0]["nodes"] = roots;
    return decode_asset(sample.glb(), "many.glb");
  };
  const auto five = with_nodes(5);
  ASSERT_TRUE(five) << five.error().message;
  EXPECT_EQ(five->asset.size(), 1000u);
  const auto many = with_nodes(4000);
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("repeats"), std::string::npos) << many.error().message;
}

}  // namespace
}  // namespace livegs
