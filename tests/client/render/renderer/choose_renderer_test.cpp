// SPDX-License-Identifier: Apache-2.0
#include "render/choose_renderer.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

const Error kNoMemory{ErrorCode::TooLarge, "vulkan: vkAllocateMemory failed with VkResult -2: out of memory"};

// A GPU is present but fails: with Auto the client continues on the CPU and shows the reason.
TEST(ChooseRenderer, CpuFallbackSetsNotice) {
  const auto chosen = made_or_cpu(RendererChoice::Auto, "vulkan: Some Card", kNoMemory);
  ASSERT_TRUE(chosen) << chosen.error().message;
  EXPECT_EQ((*chosen)->name(), "cpu");
  EXPECT_EQ((*chosen)->notice(),
            "vulkan: Some Card: rendering continues on the CPU (" + kNoMemory.message + ")");
}

TEST(ChooseRenderer, ExplicitVulkanDoesNotFallBack) {
  const auto chosen = made_or_cpu(RendererChoice::Vulkan, "vulkan: Some Card", kNoMemory);
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().message, kNoMemory.message);
}

// No notice if the CPU was requested or no GPU is present.
TEST(ChooseRenderer, CpuWithoutGpuHasNoNotice) {
  const auto asked = choose_renderer(RendererChoice::Cpu);
  ASSERT_TRUE(asked);
  EXPECT_EQ((*asked)->notice(), "");
  const auto device = VulkanDevice::create();
  if (device && !(*device)->is_software()) GTEST_SKIP() << "there is a GPU: " << (*device)->name();
  const auto chosen = choose_renderer(RendererChoice::Auto);
  ASSERT_TRUE(chosen) << chosen.error().message;
  EXPECT_EQ((*chosen)->name(), "cpu");
  EXPECT_EQ((*chosen)->notice(), "");
  if (!device) GTEST_SKIP() << device.error().message;
  const auto on_display = choose_renderer(
      RendererChoice::Auto, *device);  // a headset's device is used even if it is a software device
  ASSERT_TRUE(on_display) << on_display.error().message;
  EXPECT_EQ((*on_display)->name(), "vulkan: " + (*device)->name());
}

}  // namespace
}  // namespace livegs
