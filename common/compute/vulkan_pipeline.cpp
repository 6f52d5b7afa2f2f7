// SPDX-License-Identifier: Apache-2.0
#include "compute/vulkan_pipeline.h"

#include <array>
#include <utility>

namespace livegs {

Result<VulkanPipeline> VulkanPipeline::create(const VulkanHandles& handles, const Pass& pass) {
  VulkanPipeline pipeline(handles);
  if (auto built = pipeline.build(pass); !built) {
    return Error{built.error().code, "pass " + std::string(pass.name) + ": " + built.error().message};
  }
  return Result<VulkanPipeline>(std::move(pipeline));
}

VulkanPipeline::VulkanPipeline(VulkanPipeline&& other) noexcept
    : handles_(other.handles_),
      set_layout_(std::exchange(other.set_layout_, VK_NULL_HANDLE)),
      layout_(std::exchange(other.layout_, VK_NULL_HANDLE)),
      pipeline_(std::exchange(other.pipeline_, VK_NULL_HANDLE)) {}

VulkanPipeline::~VulkanPipeline() {
  const VulkanFunctions& vk = handles_->vk;
  vk.DestroyPipeline(handles_->device, pipeline_, nullptr);
  vk.DestroyPipelineLayout(handles_->device, layout_, nullptr);
  vk.DestroyDescriptorSetLayout(handles_->device, set_layout_, nullptr);
}

Result<void> VulkanPipeline::build(const Pass& pass) {
  const VulkanFunctions& vk = handles_->vk;
  const VkDevice device = handles_->device;

  std::array<VkDescriptorSetLayoutBinding, kMaxPassBuffers> bindings{};
  for (uint32_t i = 0; i < pass.buffer_count; ++i) {
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  }
  auto set_info =
      vulkan_info<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set_info.bindingCount = pass.buffer_count;
  set_info.pBindings = bindings.data();
  if (const VkResult made = vk.CreateDescriptorSetLayout(device, &set_info, nullptr, &set_layout_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateDescriptorSetLayout", made);
  }

  const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, pass.constants_bytes};
  auto layout_info = vulkan_info<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout_;
  layout_info.pushConstantRangeCount = pass.constants_bytes > 0 ? 1 : 0;
  layout_info.pPushConstantRanges = &constants;
  if (const VkResult made = vk.CreatePipelineLayout(device, &layout_info, nullptr, &layout_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreatePipelineLayout", made);
  }

  auto module_info = vulkan_info<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  module_info.codeSize = pass.spirv.size_bytes();
  module_info.pCode = pass.spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  if (const VkResult made = vk.CreateShaderModule(device, &module_info, nullptr, &module);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateShaderModule", made);
  }
  const VkSpecializationMapEntry entry{0, 0, sizeof(uint32_t)};
  const VkSpecializationInfo specialization{1, &entry, sizeof(uint32_t), &pass.group_size};
  auto info = vulkan_info<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialization;
  info.layout = layout_;
  const VkResult made =
      vk.CreateComputePipelines(device, handles_->pipeline_cache, 1, &info, nullptr, &pipeline_);
  vk.DestroyShaderModule(device, module, nullptr);
  if (made != VK_SUCCESS) {
    pipeline_ = VK_NULL_HANDLE;
    return vulkan_error("vkCreateComputePipelines", made);
  }
  return {};
}

}  // namespace livegs
