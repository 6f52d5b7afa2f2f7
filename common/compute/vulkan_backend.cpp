// SPDX-License-Identifier: Apache-2.0
#include "compute/vulkan_backend.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "compute/vulkan_commands.h"
#include "compute/vulkan_handles.h"
#include "compute/vulkan_memory.h"
#include "compute/vulkan_pipeline.h"

namespace livegs {

namespace {

constexpr VkDeviceSize kStagingBytes = VkDeviceSize{8} << 20;
constexpr uint32_t kMaxRecordedDispatches = 1024;  // then the recorded ones run first

class VulkanBackend final : public Backend, public VulkanCommands {
 public:
  explicit VulkanBackend(std::shared_ptr<VulkanDevice> device)
      : device_(std::move(device)), handles_(device_->handles()), vk_(handles_.vk), memory_(handles_) {}
  ~VulkanBackend() override;

  Result<void> initialise();

  Result<BufferId> create_buffer(size_t bytes) override;
  size_t max_buffer_bytes() const override {
    return std::min<size_t>(kMaxBufferBytes, handles_.properties.limits.maxStorageBufferRange);
  }
  Result<void> destroy_buffer(BufferId buffer) override;
  Result<void> upload(BufferId buffer, std::span<const std::byte> bytes) override;
  Result<void> dispatch(const Pass& pass, std::span<const BufferId> buffers,
                        std::span<const std::byte> constants, uint32_t count) override;
  Result<void> submit() override;
  Result<void> read(BufferId buffer, std::span<std::byte> bytes) override;

  Result<VkCommandBuffer> record() override;
  const Traffic& traffic() const override { return traffic_; }
  VkBuffer buffer_of(BufferId buffer) const override;

 private:
  struct Buffer {
    VkBuffer buffer = VK_NULL_HANDLE;
    VulkanMemory::Range range;
    size_t bytes = 0;
  };

  Result<void> begin();   // starts recording if necessary
  Result<void> finish();  // runs the recorded commands, waits, and prepares for recording again
  void barrier();
  Result<void> record_copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region);
  Result<const VulkanPipeline*> pipeline_of(const Pass& pass);

  std::shared_ptr<VulkanDevice> device_;
  const VulkanHandles& handles_;
  const VulkanFunctions& vk_;
  VulkanMemory memory_;
  std::map<BufferId, Buffer> buffers_;
  uint64_t last_id_ = 0;
  std::map<const uint32_t*, VulkanPipeline> pipelines_;  // by the SPIR-V of the pass

  HostBuffer staging_;
  VkDeviceSize staged_ = 0;  // bytes at its front that recorded copies still have to read

  VkCommandPool command_pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkDescriptorPool descriptor_pool_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  bool recording_ = false;
  uint32_t recorded_dispatches_ = 0;
  Traffic traffic_;
};

VulkanBackend::~VulkanBackend() {
  vk_.DeviceWaitIdle(handles_.device);
  vk_.DestroyFence(handles_.device, fence_, nullptr);
  vk_.DestroyDescriptorPool(handles_.device, descriptor_pool_, nullptr);
  vk_.DestroyCommandPool(handles_.device, command_pool_, nullptr);
  for (const auto& [id, buffer] : buffers_) vk_.DestroyBuffer(handles_.device, buffer.buffer, nullptr);
}

Result<void> VulkanBackend::initialise() {
  auto pool = vulkan_info<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.queueFamilyIndex = handles_.queue_family;
  if (const VkResult made = vk_.CreateCommandPool(handles_.device, &pool, nullptr, &command_pool_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateCommandPool", made);
  }
  auto commands = vulkan_info<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  commands.commandPool = command_pool_;
  commands.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  commands.commandBufferCount = 1;
  if (const VkResult made = vk_.AllocateCommandBuffers(handles_.device, &commands, &commands_);
      made != VK_SUCCESS) {
    return vulkan_error("vkAllocateCommandBuffers", made);
  }
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                  kMaxRecordedDispatches * kMaxPassBuffers};
  auto descriptors = vulkan_info<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  descriptors.maxSets = kMaxRecordedDispatches;
  descriptors.poolSizeCount = 1;
  descriptors.pPoolSizes = &size;
  if (const VkResult made =
          vk_.CreateDescriptorPool(handles_.device, &descriptors, nullptr, &descriptor_pool_);
      made != VK_SUCCESS) {
    return vulkan_error("vkCreateDescriptorPool", made);
  }
  const auto fence = vulkan_info<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  if (const VkResult made = vk_.CreateFence(handles_.device, &fence, nullptr, &fence_); made != VK_SUCCESS) {
    return vulkan_error("vkCreateFence", made);
  }
  return staging_.create(handles_, kStagingBytes,
                         VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
}

Result<BufferId> VulkanBackend::create_buffer(size_t bytes) {
  if (auto checked = check_buffer_size(bytes); !checked) return checked.error();
  const size_t limit = max_buffer_bytes();
  if (bytes > limit) {
    return Error{ErrorCode::TooLarge, "buffer: " + std::to_string(bytes) + " bytes exceed the limit of " +
                                          device_->name() + ", " + std::to_string(limit) +
                                          "; split the buffer"};
  }
  auto info = vulkan_info<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
               VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  Buffer made{VK_NULL_HANDLE, {}, bytes};
  if (const VkResult result = vk_.CreateBuffer(handles_.device, &info, nullptr, &made.buffer);
      result != VK_SUCCESS) {
    return vulkan_error("vkCreateBuffer", result);
  }
  VkMemoryRequirements needs;
  vk_.GetBufferMemoryRequirements(handles_.device, made.buffer, &needs);
  auto range = memory_.allocate(needs);
  if (!range) {
    vk_.DestroyBuffer(handles_.device, made.buffer, nullptr);
    return range.error();
  }
  made.range = *range;
  if (const VkResult bound =
          vk_.BindBufferMemory(handles_.device, made.buffer, memory_.memory_of(*range), range->offset);
      bound != VK_SUCCESS) {
    vk_.DestroyBuffer(handles_.device, made.buffer, nullptr);
    memory_.free(*range);
    return vulkan_error("vkBindBufferMemory", bound);
  }
  const BufferId id{++last_id_};
  buffers_[id] = made;
  return id;
}

Result<void> VulkanBackend::destroy_buffer(BufferId buffer) {
  const auto found = buffers_.find(buffer);
  if (found == buffers_.end()) return unknown_buffer(buffer);
  if (auto done = finish(); !done) return done;
  vk_.DestroyBuffer(handles_.device, found->second.buffer, nullptr);
  memory_.free(found->second.range);
  buffers_.erase(found);
  return {};
}

Result<void> VulkanBackend::begin() {
  if (recording_) return {};
  auto info = vulkan_info<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  if (const VkResult begun = vk_.BeginCommandBuffer(commands_, &info); begun != VK_SUCCESS) {
    return vulkan_error("vkBeginCommandBuffer", begun);
  }
  recording_ = true;
  return {};
}

// A single kind of barrier: all earlier writes are visible to all later commands and to the host.
void VulkanBackend::barrier() {
  auto memory = vulkan_info<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  memory.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  memory.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  memory.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT;
  memory.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  auto dependency = vulkan_info<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vk_.CmdPipelineBarrier2(commands_, &dependency);
  ++traffic_.barriers;
}

Result<void> VulkanBackend::finish() {
  if (!recording_) return {};
  recording_ = false;
  recorded_dispatches_ = 0;
  staged_ = 0;
  if (const VkResult ended = vk_.EndCommandBuffer(commands_); ended != VK_SUCCESS) {
    return vulkan_error("vkEndCommandBuffer", ended);
  }
  auto commands = vulkan_info<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  commands.commandBuffer = commands_;
  auto info = vulkan_info<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  info.commandBufferInfoCount = 1;
  info.pCommandBufferInfos = &commands;
  VkResult done = vk_.QueueSubmit2(handles_.queue, 1, &info, fence_);
  if (done != VK_SUCCESS) return vulkan_error("vkQueueSubmit2", done);
  ++traffic_.submissions;
  done = vk_.WaitForFences(handles_.device, 1, &fence_, VK_TRUE, UINT64_MAX);
  if (done != VK_SUCCESS) return vulkan_error("vkWaitForFences", done);
  vk_.ResetFences(handles_.device, 1, &fence_);
  vk_.ResetDescriptorPool(handles_.device, descriptor_pool_, 0);
  vk_.ResetCommandPool(handles_.device, command_pool_, 0);
  return {};
}

Result<void> VulkanBackend::record_copy(VkBuffer from, VkBuffer to, const VkBufferCopy& region) {
  if (auto begun = begin(); !begun) return begun;
  barrier();
  vk_.CmdCopyBuffer(commands_, from, to, 1, &region);
  return {};
}

// Copies are recorded like dispatches, so the drivers and passes of a frame are one submission. Recorded
// commands run early only if the staging buffer is full.
Result<void> VulkanBackend::upload(BufferId buffer, std::span<const std::byte> bytes) {
  const auto found = buffers_.find(buffer);
  if (found == buffers_.end()) return unknown_buffer(buffer);
  if (auto checked = check_transfer(bytes.size(), found->second.bytes); !checked) return checked;
  for (size_t offset = 0; offset < bytes.size();) {
    if (staged_ == kStagingBytes) {
      if (auto done = finish(); !done) return done;
    }
    const size_t part = std::min<size_t>(kStagingBytes - staged_, bytes.size() - offset);
    std::memcpy(staging_.bytes() + staged_, bytes.data() + offset, part);
    if (auto copied = record_copy(staging_.buffer(), found->second.buffer, {staged_, offset, part}); !copied)
      return copied;
    staged_ += part;
    offset += part;
  }
  traffic_.uploaded_bytes += bytes.size();
  return {};
}

Result<void> VulkanBackend::read(BufferId buffer, std::span<std::byte> bytes) {
  const auto found = buffers_.find(buffer);
  if (found == buffers_.end()) return unknown_buffer(buffer);
  if (auto checked = check_transfer(bytes.size(), found->second.bytes); !checked) return checked;
  if (auto done = finish(); !done) return done;
  for (size_t offset = 0; offset < bytes.size(); offset += kStagingBytes) {
    const size_t part = std::min<size_t>(kStagingBytes, bytes.size() - offset);
    if (auto copied = record_copy(found->second.buffer, staging_.buffer(), {offset, 0, part}); !copied)
      return copied;
    barrier();
    if (auto done = finish(); !done) return done;
    std::memcpy(bytes.data() + offset, staging_.bytes(), part);
  }
  return {};
}

Result<const VulkanPipeline*> VulkanBackend::pipeline_of(const Pass& pass) {
  auto found = pipelines_.find(pass.spirv.data());
  if (found == pipelines_.end()) {
    auto made = VulkanPipeline::create(handles_, pass);
    if (!made) return made.error();
    found = pipelines_.emplace(pass.spirv.data(), *std::move(made)).first;
  }
  return static_cast<const VulkanPipeline*>(&found->second);
}

Result<void> VulkanBackend::dispatch(const Pass& pass, std::span<const BufferId> buffers,
                                     std::span<const std::byte> constants, uint32_t count) {
  if (auto checked = check_dispatch(pass, buffers, constants); !checked) return checked;
  std::array<VkDescriptorBufferInfo, kMaxPassBuffers> bound{};
  for (size_t i = 0; i < buffers.size(); ++i) {
    const auto found = buffers_.find(buffers[i]);
    if (found == buffers_.end()) return unknown_buffer(buffers[i]);
    bound[i] = {found->second.buffer, 0, VK_WHOLE_SIZE};
  }
  if (count == 0) return {};
  const uint32_t groups = (count - 1) / pass.group_size + 1;
  if (groups > handles_.properties.limits.maxComputeWorkGroupCount[0]) {
    return Error{ErrorCode::TooLarge, "pass " + std::string(pass.name) + ": " + std::to_string(count) +
                                          " items exceed the groups that " + device_->name() +
                                          " runs in one dispatch; split the dispatch"};
  }
  auto pipeline = pipeline_of(pass);
  if (!pipeline) return pipeline.error();
  if (recorded_dispatches_ == kMaxRecordedDispatches) {
    if (auto done = finish(); !done) return done;
  }

  const VkDescriptorSetLayout set_layout = (*pipeline)->set_layout();
  auto allocation = vulkan_info<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocation.descriptorPool = descriptor_pool_;
  allocation.descriptorSetCount = 1;
  allocation.pSetLayouts = &set_layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  if (const VkResult made = vk_.AllocateDescriptorSets(handles_.device, &allocation, &set);
      made != VK_SUCCESS) {
    return vulkan_error("vkAllocateDescriptorSets", made);
  }
  auto write = vulkan_info<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = set;
  write.descriptorCount = pass.buffer_count;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = bound.data();  // one write covers consecutive bindings
  vk_.UpdateDescriptorSets(handles_.device, 1, &write, 0, nullptr);

  if (auto begun = begin(); !begun) return begun;
  const std::string label(pass.name);
  if (vk_.CmdBeginDebugUtilsLabelEXT) {
    auto info = vulkan_info<VkDebugUtilsLabelEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT);
    info.pLabelName = label.c_str();
    vk_.CmdBeginDebugUtilsLabelEXT(commands_, &info);
  }
  barrier();
  vk_.CmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, (*pipeline)->pipeline());
  vk_.CmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, (*pipeline)->layout(), 0, 1, &set, 0,
                            nullptr);
  if (!constants.empty()) {
    vk_.CmdPushConstants(commands_, (*pipeline)->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                         pass.constants_bytes, constants.data());
  }
  vk_.CmdDispatch(commands_, groups, 1, 1);
  if (vk_.CmdEndDebugUtilsLabelEXT) vk_.CmdEndDebugUtilsLabelEXT(commands_);
  ++recorded_dispatches_;
  ++traffic_.dispatches;
  return {};
}

Result<void> VulkanBackend::submit() { return finish(); }

Result<VkCommandBuffer> VulkanBackend::record() {
  if (auto begun = begin(); !begun) return begun.error();
  barrier();
  return Result<VkCommandBuffer>(commands_);
}

VkBuffer VulkanBackend::buffer_of(BufferId buffer) const {
  const auto found = buffers_.find(buffer);
  return found == buffers_.end() ? VK_NULL_HANDLE : found->second.buffer;
}

}  // namespace

VulkanCommands* vulkan_commands(Backend& backend) { return dynamic_cast<VulkanCommands*>(&backend); }

Result<std::unique_ptr<Backend>> create_vulkan_backend(std::shared_ptr<VulkanDevice> device) {
  auto backend = std::make_unique<VulkanBackend>(std::move(device));
  if (auto ready = backend->initialise(); !ready) return ready.error();
  return Result<std::unique_ptr<Backend>>(std::move(backend));
}

}  // namespace livegs
