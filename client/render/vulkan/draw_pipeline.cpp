// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/draw_pipeline.h"

#include <array>
#include <vector>

namespace livegs {

DrawPipeline::~DrawPipeline() {
  const VulkanFunctions& vk = handles_.vk;
  for (const VkPipeline pipeline : pipelines_) vk.DestroyPipeline(handles_.device, pipeline, nullptr);
  vk.DestroyDescriptorPool(handles_.device, pool_, nullptr);
  vk.DestroyPipelineLayout(handles_.device, layout_, nullptr);
  vk.DestroyDescriptorSetLayout(handles_.device, set_layout_, nullptr);
}

Result<void> DrawPipeline::create(const Description& description) {
  if (auto made = create_layout(description); !made) return made;
  if (auto made = create_set(description); !made) return made;
  const VulkanFunctions& vk = handles_.vk;
  VkShaderModule modules[2] = {};
  const std::span<const uint32_t> code[2] = {description.vertex_spirv, description.fragment_spirv};
  VkResult made = VK_SUCCESS;
  for (int i = 0; i < 2 && made == VK_SUCCESS; ++i) {
    auto info = vulkan_info<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    info.codeSize = code[i].size_bytes();
    info.pCode = code[i].data();
    made = vk.CreateShaderModule(handles_.device, &info, nullptr, &modules[i]);
  }
  Result<void> done;
  if (made != VK_SUCCESS) done = vulkan_error("vkCreateShaderModule", made);
  for (int eyes = 1; eyes <= 2 && done; ++eyes)
    done = create_pipeline(description, modules[0], modules[1], eyes);
  for (const VkShaderModule module : modules) vk.DestroyShaderModule(handles_.device, module, nullptr);
  return done;
}

Result<void> DrawPipeline::create_layout(const Description& description) {
  const VulkanFunctions& vk = handles_.vk;
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (uint32_t i = 0; i < description.binding_count; ++i)
    bindings.push_back({i, description.binding_type, 1, description.binding_stage, nullptr});
  auto set =
      vulkan_info<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set.bindingCount = description.binding_count;
  set.pBindings = bindings.data();
  if (const VkResult made = vk.CreateDescriptorSetLayout(handles_.device, &set, nullptr, &set_layout_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateDescriptorSetLayout", made);
  }
  const VkPushConstantRange constants{description.constants_stage, 0, description.constants_bytes};
  auto layout = vulkan_info<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &constants;
  if (const VkResult made = vk.CreatePipelineLayout(handles_.device, &layout, nullptr, &layout_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreatePipelineLayout", made);
  }
  return {};
}

Result<void> DrawPipeline::create_set(const Description& description) {
  const VulkanFunctions& vk = handles_.vk;
  const VkDescriptorPoolSize size{description.binding_type, description.binding_count};
  auto pool = vulkan_info<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = 1;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  if (const VkResult made = vk.CreateDescriptorPool(handles_.device, &pool, nullptr, &pool_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateDescriptorPool", made);
  }
  auto set = vulkan_info<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  set.descriptorPool = pool_;
  set.descriptorSetCount = 1;
  set.pSetLayouts = &set_layout_;
  if (const VkResult made = vk.AllocateDescriptorSets(handles_.device, &set, &set_); made != VK_SUCCESS) {
    return vulkan_error("vkAllocateDescriptorSets", made);
  }
  return {};
}

Result<void> DrawPipeline::create_pipeline(const Description& description, VkShaderModule vertex,
                                           VkShaderModule fragment, int eyes) {
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  for (auto& stage : stages) {
    stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stage.pName = "main";
  }
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = vertex;
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  stages[1].module = fragment;
  const auto vertex_input = vulkan_info<VkPipelineVertexInputStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  auto assembly = vulkan_info<VkPipelineInputAssemblyStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = description.topology;
  auto viewport =
      vulkan_info<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  auto raster = vulkan_info<VkPipelineRasterizationStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.cullMode = VK_CULL_MODE_NONE;
  raster.lineWidth = 1.0f;
  auto samples = vulkan_info<VkPipelineMultisampleStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineColorBlendAttachmentState attachment{};
  attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                              VK_COLOR_COMPONENT_A_BIT;
  if (description.front_to_back) {
    attachment.blendEnable = VK_TRUE;
    attachment.srcColorBlendFactor = attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA;
    attachment.dstColorBlendFactor = attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    attachment.colorBlendOp = attachment.alphaBlendOp = VK_BLEND_OP_ADD;
  }
  auto blend = vulkan_info<VkPipelineColorBlendStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = 1;
  blend.pAttachments = &attachment;
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamic =
      vulkan_info<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamic.dynamicStateCount = dynamic_states.size();
  dynamic.pDynamicStates = dynamic_states.data();
  auto rendering =
      vulkan_info<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.viewMask = (1u << eyes) - 1;
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachmentFormats = &description.format;

  auto info = vulkan_info<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  info.pNext = &rendering;
  info.stageCount = stages.size();
  info.pStages = stages.data();
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout_;
  const VkResult made = handles_.vk.CreateGraphicsPipelines(handles_.device, handles_.pipeline_cache, 1,
                                                            &info, nullptr, &pipelines_[eyes - 1]);
  if (made != VK_SUCCESS) {
    pipelines_[eyes - 1] = VK_NULL_HANDLE;
    return vulkan_error("vkCreateGraphicsPipelines", made);
  }
  return {};
}

}  // namespace livegs
