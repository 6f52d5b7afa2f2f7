// SPDX-License-Identifier: Apache-2.0
// What the shaders ask of a device, read from their SPIR-V (its specification, sections 2.3 and 3.31): the
// sort and all else assume no size of a subgroup, which is 8 on lavapipe and 4 to 128 elsewhere, and nothing
// that Vulkan 1.3 leaves open.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace livegs {
namespace {

constexpr uint32_t kMagic = 0x07230203, kSpirv16 = 0x00010600;
constexpr uint32_t kOpExtension = 10, kOpCapability = 17;
constexpr uint32_t kShader = 1, kFirstOfSubgroups = 61, kLastOfSubgroups = 68,
                   kMultiView = 4439;  // GroupNonUniform, ...Quad

struct RequestedAsset {
  std::set<uint32_t> capabilities;
  size_t extensions = 0;
};

RequestedAsset asked_by(const std::vector<uint32_t>& words) {
  RequestedAsset asked;
  for (size_t i = 5, length = 0; i < words.size(); i += length) {
    length = std::max<uint32_t>(1, words[i] >> 16);
    if ((words[i] & 0xffff) == kOpCapability) asked.capabilities.insert(words.at(i + 1));
    if ((words[i] & 0xffff) == kOpExtension) ++asked.extensions;
  }
  return asked;
}

bool is_of_subgroups(uint32_t capability) {
  return capability >= kFirstOfSubgroups && capability <= kLastOfSubgroups;
}

// A generated header: words in hexadecimal after a brace.
std::vector<uint32_t> read_words(const std::filesystem::path& header) {
  std::ostringstream text;
  text << std::ifstream(header).rdbuf();
  const std::string all = text.str();
  std::vector<uint32_t> words;
  for (size_t at = all.find("0x", all.find('{')); at != std::string::npos; at = all.find("0x", at + 2))
    words.push_back(static_cast<uint32_t>(std::stoul(all.substr(at, 10), nullptr, 16)));
  return words;
}

TEST(ShaderModules, AskForNoSubgroupsAndForNothingBeyondVulkan13) {
  std::ifstream list(LIVEGS_SHADER_LIST);  // livegs_room.cmake names all that it builds
  size_t modules = 0;
  for (std::string header; std::getline(list, header);) {
    if (header.empty()) continue;
    ++modules;
    const std::string name = std::filesystem::path(header).filename();
    const std::vector<uint32_t> words = read_words(header);
    ASSERT_GT(words.size(), 5u) << header;
    EXPECT_EQ(words[0], kMagic) << name;
    EXPECT_LE(words[1], kSpirv16) << name;
    const RequestedAsset asked = asked_by(words);
    EXPECT_TRUE(asked.capabilities.contains(kShader)) << name;
    EXPECT_EQ(asked.extensions, 0u) << name;
    for (const uint32_t capability : asked.capabilities) {
      EXPECT_FALSE(is_of_subgroups(capability)) << name << " asks for subgroups: " << capability;
      // Multiview is a feature that every device of Vulkan 1.1 and later has.
      EXPECT_TRUE(capability == kShader || capability == kMultiView)
          << name << " asks for capability " << capability;
    }
  }
  // Skinning two ways, projecting, three steps of the sort; two stages each of drawing and resolving.
  EXPECT_GE(modules, 10u);
}

TEST(ShaderModules, OneThatAskedForSubgroupsWouldBeFound) {
  const std::vector<uint32_t> words = {
      kMagic, kSpirv16, 0, 1, 0, 2u << 16 | kOpCapability, kShader, 2u << 16 | kOpCapability, 63};
  const RequestedAsset asked = asked_by(words);
  EXPECT_EQ(asked.capabilities, (std::set<uint32_t>{kShader, 63}));
  EXPECT_TRUE(std::any_of(asked.capabilities.begin(), asked.capabilities.end(), is_of_subgroups));
}

}  // namespace
}  // namespace livegs
