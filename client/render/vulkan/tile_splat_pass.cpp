// SPDX-License-Identifier: Apache-2.0
#include "compute/vulkan_commands.h"
#include "core/assert.h"
#include "render/vulkan/eye_images.h"
#include "render/vulkan/splat_pass.h"
#include "splat/tiles/frame_tiles.h"
#include "splat/tiles/tile_splats_layout.h"

namespace livegs {
namespace {

class TileSplatPass final : public SplatPass {
 public:
  TileSplatPass(Backend& backend, const VulkanHandles& handles, bool blended)
      : backend_(backend),
        commands_(*vulkan_commands(backend)),
        handles_(handles),
        tiles_(backend, {.floats = blended}) {}
  ~TileSplatPass() override { (void)backend_.submit(); }  // recorded commands must not outlive the images

  Result<void> paint(const FrameSplats& frame, int width, int height, int eyes) override {
    width_ = width;
    height_ = height;
    eyes_ = eyes;
    return tiles_.bin(frame, width, height, eyes);
  }
  int eyes_a_draw() const override { return eyes_; }
  Result<void> resolve(const Eigen::Vector3f& background) override { return tiles_.blend(background); }
  Result<void> read(std::vector<Image>& images) override { return tiles_.finish(images); }
  Result<void> read_blended(std::vector<Image>& images) override { return read(images); }
  Result<void> copy_into(const DeviceImage& image) override;

 private:
  Backend& backend_;
  VulkanCommands& commands_;
  const VulkanHandles& handles_;
  FrameTiles tiles_;
  std::unique_ptr<EyeImages> images_;  // a blit from an image, since the channel order may differ
  int width_ = 0, height_ = 0, eyes_ = 0;
};

Result<void> TileSplatPass::copy_into(const DeviceImage& image) {
  if (auto done = tiles_.finish(); !done) return done;
  LIVEGS_ASSERT(image.layers == eyes_ && image.width >= width_ && image.height >= height_);
  if (!images_ || !images_->is_of(width_, height_, eyes_)) {
    images_.reset();
    auto made = EyeImages::create(handles_, VK_FORMAT_UNDEFINED, width_, height_, eyes_);
    if (!made) return Error{made.error().code, "eye images: " + made.error().message};
    images_ = *std::move(made);
  }
  auto commands = commands_.record();
  if (!commands) return commands.error();
  const VkImage resolved = images_->resolved();
  change_layout(handles_.vk, *commands, resolved, eyes_, VK_IMAGE_LAYOUT_UNDEFINED,
                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  VkBufferImageCopy copy{};
  copy.bufferOffset = kTileHeaderWords * sizeof(uint32_t);
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, static_cast<uint32_t>(eyes_)};
  copy.imageExtent = {static_cast<uint32_t>(width_), static_cast<uint32_t>(height_), 1};
  handles_.vk.CmdCopyBufferToImage(*commands, commands_.buffer_of(tiles_.picture()), resolved,
                                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  change_layout(handles_.vk, *commands, resolved, eyes_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  images_->blit_resolved(*commands, image);
  return backend_.submit();
}

}  // namespace

std::unique_ptr<SplatPass> SplatPass::create_tiles(Backend& backend, const VulkanHandles& handles,
                                                   bool blended) {
  return std::make_unique<TileSplatPass>(backend, handles, blended);
}

}  // namespace livegs
