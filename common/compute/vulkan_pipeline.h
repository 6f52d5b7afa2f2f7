// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/pass.h"
#include "compute/vulkan_handles.h"

namespace livegs {

// The Vulkan objects needed to run one pass.
class VulkanPipeline {
 public:
  static Result<VulkanPipeline> create(const VulkanHandles& handles, const Pass& pass);

  ~VulkanPipeline();
  VulkanPipeline(VulkanPipeline&& other) noexcept;
  VulkanPipeline& operator=(VulkanPipeline&&) = delete;

  VkDescriptorSetLayout set_layout() const { return set_layout_; }
  VkPipelineLayout layout() const { return layout_; }
  VkPipeline pipeline() const { return pipeline_; }

 private:
  explicit VulkanPipeline(const VulkanHandles& handles) : handles_(&handles) {}
  Result<void> build(const Pass& pass);

  const VulkanHandles* handles_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace livegs
