// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compute/vulkan_backend.h"

namespace livegs {

// Messages of the validation layer. Any thread.
class ValidationMessages {
 public:
  void add(const std::string& message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(message);
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }
  void expect_none() {
    for (const std::string& message : take()) ADD_FAILURE() << message;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

// In the build tree, next to the folder of the programs.
inline std::filesystem::path test_pipeline_cache_folder() {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none).parent_path().parent_path() / "pipeline_cache";
}

// How a test program creates its devices. Change it before the first test only.
struct TestDevices {
  bool validation = true;  // a missing validation layer then fails the tests
  std::filesystem::path pipeline_cache_folder = test_pipeline_cache_folder();
};
inline TestDevices& test_devices() {
  static TestDevices devices;
  return devices;
}

// Creates a device with the validation layer, unless test_devices() excludes it. `messages` receives its
// messages and must outlive it.
inline Result<std::shared_ptr<VulkanDevice>> create_validated_device(ValidationMessages& messages,
                                                                     size_t memory_limit_bytes = 0) {
  VulkanDeviceOptions options;
  options.validation = test_devices().validation;
  options.on_validation_message = [&messages](const std::string& message) { messages.add(message); };
  options.memory_limit_bytes = memory_limit_bytes;
  options.pipeline_cache_folder = test_devices().pipeline_cache_folder;
  return VulkanDevice::create(options);
}

// The only Vulkan device of a test program, and a backend on it. Created at first use, destroyed after the
// last test. Any message of the validation layer fails the current test or, at the end, the program.
class SharedVulkan final : public ::testing::Environment {
 public:
  // The reason for a missing device; tests then skip. Empty if there is a device, or if only the validation
  // layer is missing.
  const std::optional<Error>& no_device() {
    create();
    return no_device_;
  }
  // Precondition: no_device() is empty.
  const Result<std::shared_ptr<VulkanDevice>>& device() { return create(); }
  Result<Backend*> backend() {
    if (!backend_) {
      if (!create()) return create().error();
      auto made = create_vulkan_backend(*create());
      if (!made) return made.error();
      backend_ = *std::move(made);
    }
    return backend_.get();
  }
  ValidationMessages& messages() { return messages_; }

  void TearDown() override {
    backend_.reset();
    device_.reset();
    no_device_.reset();
    messages_.expect_none();
  }

 private:
  const Result<std::shared_ptr<VulkanDevice>>& create() {
    if (!device_) {
      device_ = create_validated_device(messages_);
      if (!*device_) {
        if (const auto plain = VulkanDevice::create(); !plain) no_device_ = plain.error();
      }
    }
    return *device_;
  }

  ValidationMessages messages_;  // outlives the device, which may report until it is destroyed
  std::optional<Result<std::shared_ptr<VulkanDevice>>> device_;
  std::optional<Error> no_device_;
  std::unique_ptr<Backend> backend_;
};

// Owned by GoogleTest, which tears environments down in the reverse order of their registration.
inline SharedVulkan& registered_vulkan() {
  static SharedVulkan& only =
      *static_cast<SharedVulkan*>(::testing::AddGlobalTestEnvironment(new SharedVulkan));
  return only;
}
inline SharedVulkan& shared_vulkan = registered_vulkan();

// Registers an environment that uses shared_vulkan, and is torn down before it.
template <typename Environment>
Environment& register_after_vulkan() {
  registered_vulkan();  // variables of several files have no order
  return *static_cast<Environment*>(::testing::AddGlobalTestEnvironment(new Environment));
}

}  // namespace livegs
