// SPDX-License-Identifier: Apache-2.0
// Pictures of the sample scene after its objects have fallen: hat, fragments of the cup and pillow on the
// floor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "scene/scene.h"
#include "scene/views/scene_drawing.h"
#include "splat/frame_bounds.h"
#include "splat/image.h"
#include "splat/rasterise.h"
#include "system/support/sample_files.h"

namespace livegs {
namespace {

constexpr int kWidth = 480, kHeight = 360;
constexpr double kFall_s = 5;  // after this time nothing falls any more

class FallenSample : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto text = read_scene(sample_files(LIVEGS_TOOL) / "sample.scene.json");
    ASSERT_TRUE(text) << text.error().message;
    SceneOptions options;
    options.wait_for_pieces = true;
    auto built = Scene::build(text->file, text->folder, text->name, options);
    ASSERT_TRUE(built) << built.error().message;
    scene = new Scene(std::move(*built));
    const auto ticks = static_cast<int>(kFall_s * scene->world().settings().rate_hz);
    for (int tick = 0; tick < ticks; ++tick) scene->step();
    ASSERT_GE(scene->find("cup")->rest.revision, 1u) << "the cup has broken";
  }
  static void TearDownTestSuite() { delete scene; }
  void SetUp() override {
    drawing_.set_shadows(true);
    auto posed = drawing_.pose(*scene);
    ASSERT_TRUE(posed) << posed.error().message;
    all_ = *posed;
    const std::vector<uint32_t> rooms = drawing_.options().environments;
    std::copy_if(all_.begin(), all_.end(), std::back_inserter(things_), [&](const DrawnObject& one) {
      return std::find(rooms.begin(), rooms.end(), one.object_id) == rooms.end();
    });
  }
  Camera towards(uint32_t id) const {
    const Eigen::AlignedBox3d box = robust_bounds(drawing_.kernels(id).positions_m);
    return frame_boxes(std::span(&box, 1), kWidth, kHeight, 0.3, 0.5);
  }
  RasterisedView draw(std::span<const DrawnObject> objects, const Camera& camera, bool shadows) {
    RasteriseOptions options = drawing_.options();
    if (!shadows) options.shadows = nullptr;
    RasterisedView view;
    Rasteriser().draw(objects, camera, options, view);
    return view;
  }

  static inline Scene* scene = nullptr;
  SceneDrawing drawing_;
  std::vector<DrawnObject> all_, things_;  // with and without the room
};

// Within the outline of an object, the picture with the room is that of the objects alone.
TEST_F(FallenSample, FloorDoesNotPierceRestingObjects) {
  constexpr double kMaxPierced = 0.002;  // of the pixels inside the outline
  constexpr int kRim = 2;                // pixels at the outline, where floor shows by right
  constexpr float kDifference = 0.08f;   // of one channel: 20 of 255
  for (const char* name : {"hat", "cup", "pillow"}) {
    SCOPED_TRACE(name);
    const uint32_t id = scene->find(name)->id;
    const Camera camera = towards(id);
    const RasterisedView with = draw(all_, camera, false), without = draw(things_, camera, false);
    int inside = 0, pierced = 0;
    for (int y = kRim; y < kHeight - kRim; ++y) {
      for (int x = kRim; x < kWidth - kRim; ++x) {
        bool within = true;
        for (int dy = -kRim; dy <= kRim; ++dy) {
          for (int dx = -kRim; dx <= kRim; ++dx) {
            const auto at = static_cast<size_t>((y + dy) * kWidth + x + dx);
            within = within && without.object_id[at] == id && without.image.at(x + dx, y + dy)[3] >= 0.98f;
          }
        }
        if (!within) continue;
        ++inside;
        float most = 0;
        for (int c = 0; c < 3; ++c)
          most = std::max(most, std::abs(with.image.at(x, y)[c] - without.image.at(x, y)[c]));
        pierced += most > kDifference;
      }
    }
    ASSERT_GT(inside, 1000);
    std::printf("%s: %.3f %% of %d pixels\n", name, 100.0 * pierced / inside, inside);
    EXPECT_LE(pierced, kMaxPierced * inside);
    if (const char* pictures = std::getenv("LIVEGS_TEST_PICTURES")) {
      ASSERT_TRUE(write_png(std::filesystem::path(pictures) / ("rest_" + std::string(name) + ".png"),
                            draw(all_, camera, true).image));
    }
  }
}

// Each has a shadow on the floor next to it.
TEST_F(FallenSample, EachHasAShadow) {
  for (const char* name : {"hat", "cup", "pillow"}) {
    SCOPED_TRACE(name);
    const Camera camera = towards(scene->find(name)->id);
    const RasterisedView shaded = draw(all_, camera, true), plain = draw(all_, camera, false),
                         things = draw(things_, camera, false);
    int dark = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (things.image.at(x, y)[3] > 0.01f) continue;  // not the floor alone
        const auto brightness = [&](const RasterisedView& view) {
          const float* pixel = view.image.at(x, y);
          return pixel[0] + pixel[1] + pixel[2];
        };
        dark += brightness(shaded) < 0.9f * brightness(plain);
      }
    }
    EXPECT_GT(dark, kWidth * kHeight / 200);
  }
}

}  // namespace
}  // namespace livegs
