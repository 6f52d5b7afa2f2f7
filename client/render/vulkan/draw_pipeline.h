// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "compute/vulkan_handles.h"

namespace livegs {

// Shaders that draw to one colour attachment, for one eye and for two, with one descriptor set.
class DrawPipeline {
 public:
  struct Description {
    std::span<const uint32_t> vertex_spirv, fragment_spirv;
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    VkFormat format = VK_FORMAT_UNDEFINED;
    bool front_to_back = false;  // later draws lie behind: dst += (1 - dst.a) src, premultiplied
    // Bindings 0, 1, ... of set 0, all of one type and stage; push constants for one stage.
    uint32_t binding_count = 0;
    VkDescriptorType binding_type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    VkShaderStageFlags binding_stage = VK_SHADER_STAGE_VERTEX_BIT;
    uint32_t constants_bytes = 0;
    VkShaderStageFlags constants_stage = VK_SHADER_STAGE_VERTEX_BIT;
  };

  explicit DrawPipeline(const VulkanHandles& handles) : handles_(handles) {}
  ~DrawPipeline();
  DrawPipeline(const DrawPipeline&) = delete;
  DrawPipeline& operator=(const DrawPipeline&) = delete;
  Result<void> create(const Description& description);

  VkPipeline pipeline(int eyes) const { return pipelines_[eyes - 1]; }
  VkPipelineLayout layout() const { return layout_; }
  VkDescriptorSet set() const { return set_; }

 private:
  Result<void> create_layout(const Description& description);
  Result<void> create_set(const Description& description);
  Result<void> create_pipeline(const Description& description, VkShaderModule vertex, VkShaderModule fragment,
                               int eyes);

  const VulkanHandles& handles_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkPipeline pipelines_[2]{};
};

}  // namespace livegs
