// SPDX-License-Identifier: Apache-2.0
// Makes every Stage of this program step its body on the Vulkan device. Without one, nothing is compared.
#include <gtest/gtest.h>

#include <cstdio>

#include "common/compute/shared_vulkan.h"
#include "device/device_elastic.h"

namespace livegs {
namespace {

class OnDevice final : public ::testing::Environment {
 public:
  void SetUp() override {
    test_devices().validation = false;  // device_elastic_test has it; here it would take most of the time
    if (const auto& why = shared_vulkan.no_device()) {
      std::printf("skipped on the device: %s\n", why->message.c_str());
      return;
    }
    const auto backend = shared_vulkan.backend();
    ASSERT_TRUE(backend) << backend.error().message;
    device_ = std::make_shared<DeviceElastic>(**backend);
    set_elastic_device(device_);
  }
  void TearDown() override {
    set_elastic_device(nullptr);
    if (!device_) return;
    EXPECT_EQ(device_->failure(), "");
    EXPECT_GT(device_->counts().body_ticks, 0u);
    std::printf("device: %zu ticks of bodies\n", static_cast<size_t>(device_->counts().body_ticks));
    device_.reset();
  }

 private:
  std::shared_ptr<DeviceElastic> device_;
};

[[maybe_unused]] OnDevice& on_device = register_after_vulkan<OnDevice>();

}  // namespace
}  // namespace livegs
