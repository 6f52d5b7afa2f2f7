// SPDX-License-Identifier: Apache-2.0
#include "viewer/runs/loading_window.h"

namespace livegs {
namespace {

constexpr double kPictureInterval_s = 1.0 / 30;  // limit for a hidden display, which does not pace

}  // namespace

Result<std::unique_ptr<ConnectedScene>> load_in_window(SceneLoader& loading, WindowDisplay& display,
                                                       const std::atomic<bool>& interrupted) {
  const Image dark{1, 1, {0.08f, 0.08f, 0.1f, 1.0f}};
  while (!loading.wait(kPictureInterval_s)) {
    const auto planned = display.wait_frame();
    if (!planned || interrupted) return std::unique_ptr<ConnectedScene>();
    const SceneLoader::Progress progress = loading.progress();
    WindowOverlay overlay;
    overlay.panels.loading = LoadingPanel{progress.text, progress.share};
    display.set_overlay(std::move(overlay));
    if (auto submitted = display.submit(*planned, {&dark, 1}); !submitted) return submitted.error();
  }
  return loading.take();
}

}  // namespace livegs
