// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/clock.h"
#include "openxr_runtime/record_files.h"
#include "scenes/served_scene.h"
#include "scratch_folder.h"
#include "system/headset/parallax.h"
#include "system/support/fault_proxy.h"
#include "viewer/runs/headset_run.h"

namespace livegs {

// Server, headset client and simulated runtime in one process, with both validation layers. The middle of the
// scene is at (0, 1.6, -1) in the stage.
class HeadsetSession : public ::testing::Test {
 protected:
  struct Settings {
    std::string eye_size = "96x108";
    RendererChoice renderer = RendererChoice::Vulkan;
    double network_delay_ms = 0;
    bool marks = true;
    bool scales = false;                                        // lower the resolution when pictures are late
    std::function<double(const PlannedFrame&)> raster_ms = {};  // as in HeadsetRunOptions
    bool validates = true;          // enables both validation layers, which are slow
    double seconds = 0;             // 0: until the timeline ends the session
    std::string controllers = {};   // LIVEGS_XR_CONTROLLERS; empty: the runtime's default
    bool keeps_ticks = true;        // in seen_; about 200 kB per second
    std::string run_message = {};   // the server's run message from the start
    size_t memory_limit_bytes = 0;  // of the display's device, as in VulkanDeviceOptions
    std::function<void(const PlannedFrame&, const SceneView&, FaultProxy& network)> on_kept =
        {};  // called with each kept picture
  };

  // A scene of floating boxes with these names and positions. Boxes named `fixed` do not move.
  static Scene floating(const std::map<std::string, Eigen::Vector3d>& boxes, const std::string& fixed = {}) {
    std::string objects;
    for (const auto& [name, at] : boxes) {
      char text[400];
      std::snprintf(text, sizeof text,
                    R"(%s{ "name": "%s", "shape": { "box": { "size_m": [0.12, 0.12, 0.12] } },
        "pose": { "position_m": [%g, %g, %g] }, "physics": { "behavior": "%s" } })",
                    objects.empty() ? "" : ", ", name.c_str(), at.x(), at.y(), at.z(),
                    name == fixed ? "STATIC" : R"(RIGID", "mass_kg": 1, "fill": "SOLID)");
      objects += text;
    }
    v1::Scene file;
    const auto parsed = google::protobuf::util::JsonStringToMessage(
        R"({ "gravity_m_s2": [0, 0, 0], "objects": [)" + objects + "] }", &file);
    EXPECT_TRUE(parsed.ok()) << parsed.message();
    auto scene = Scene::build(file, ".", "floating", {});
    EXPECT_TRUE(scene) << scene.error().message;
    return std::move(*scene);
  }

  // Pose of an object in each tick of the simulation, and its number of bodies.
  struct Seen {
    int64_t at_ns = 0;
    std::map<std::string, BodyState> bodies;  // one body per object
    std::map<std::string, size_t> counts;
  };

  Result<HeadsetRunSummary> run(Scene scene, const std::string& timeline, const Settings& settings) {
    for (const BodyState& body : scene.world().bodies()) {
      if (const SceneObject* object = scene.find(body.object_id)) ids_[object->name] = body.object_id;
    }
    ServedScene served(std::move(scene), [&](const Scene& now) {
      if (!settings.keeps_ticks) return;
      Seen one{now_ns(), {}, {}};
      for (const BodyState& body : now.world().bodies()) {
        const SceneObject* object = now.find(body.object_id);
        if (!object) continue;
        one.bodies[object->name] = body;
        ++one.counts[object->name];
      }
      std::lock_guard lock(mutex_);
      seen_.push_back(std::move(one));
    });
    if (!settings.run_message.empty()) served.loop->set_loading(false, settings.run_message);
    FaultProxy proxy(served.port());
    proxy.set_link({.delay_ms = settings.network_delay_ms});
    set("XR_RUNTIME_JSON", LIVEGS_SIMULATED_OPENXR);
    set("LIVEGS_XR_TIMELINE", folder_.write("timeline.txt", timeline));
    set("LIVEGS_XR_OUTPUT", folder_ / "");
    set("LIVEGS_XR_EYE_SIZE", settings.eye_size);
    settings.controllers.empty() ? void(::unsetenv("LIVEGS_XR_CONTROLLERS"))
                                 : set("LIVEGS_XR_CONTROLLERS", settings.controllers);
    set("XR_ENABLE_API_LAYERS", settings.validates ? "XR_APILAYER_LUNARG_core_validation" : "");
    set("XR_CORE_VALIDATION_EXPORT_TYPE", "text");
    set("XR_CORE_VALIDATION_FILE_NAME", folder_ / "core.txt");
    VulkanDeviceOptions vulkan;
    vulkan.validation = settings.validates;
    vulkan.memory_limit_bytes = settings.memory_limit_bytes;
    vulkan.on_validation_message = [this](const std::string& message) {
      std::lock_guard lock(mutex_);
      vulkan_messages_.push_back(message);
    };
    auto display = HeadsetDisplay::open(vulkan);
    if (!display) return display.error();
    HeadsetRunOptions options;
    options.address = "127.0.0.1:" + std::to_string(proxy.port());
    options.seconds = settings.seconds;
    options.camera_file = folder_.write(
        "camera.json", R"({ "position_m": [0, 0, 1], "look_at_m": [0, 0, 0], "vertical_fov_deg": 60 })");
    options.cache = folder_ / "cache";
    options.connect_timeout_s = options.reconnect_s = 60;
    options.renderer = settings.renderer;
    options.scales = settings.scales;
    options.marks = settings.marks;
    options.raster_ms = settings.raster_ms;
    options.on_picture = [this, &settings, &proxy](const PlannedFrame& picture, const SceneView& view) {
      if (hold_against_oracle(picture, view) && settings.on_kept) settings.on_kept(picture, view, proxy);
    };
    const std::atomic<bool> interrupted{false};
    auto done = run_headset(options, **display, interrupted);
    display->reset();
    // After a fallback to the CPU, the comparison would be of the CPU with itself.
    if (done && settings.renderer == RendererChoice::Vulkan) {
      EXPECT_EQ(done->renderer.rfind("vulkan: ", 0), 0u) << done->renderer;
    }
    return done;
  }

  // A picture that the runtime kept, and the CPU picture of the same moment and eyes.
  struct Kept {
    std::array<std::filesystem::path, 2> files;
    std::vector<Image> oracle;
    std::vector<Camera> eyes;
    std::map<std::string, SeenByBothEyes> seen;  // rigid objects, at the time of the picture
    bool hands_in_sight = false;                 // hands or their marks in front of the eyes
  };

  // Conditions that hold after each session: no validation messages, no misuse, no leaked handles.
  void expect_no_complaints() const {
    EXPECT_EQ(text(folder_ / "misuse.txt"), "");
    EXPECT_EQ(text(folder_ / "core.txt"), "");
    EXPECT_TRUE(vulkan_messages_.empty())
        << vulkan_messages_.size() << " messages; first: " << vulkan_messages_.front();
    // All handles were destroyed before their parents. Each session has two rows, the instance three.
    const auto handles = rows(folder_ / "handles.csv");
    EXPECT_GE(handles.size(), 5u);
    for (const auto& row : handles) {
      EXPECT_NE(row.at(2), "0") << "no " << row[1] << " was created";
      EXPECT_EQ(row.at(3), "0") << row[1] << "s not destroyed before the " << row[0] << " was destroyed";
    }
  }

  // Compares both eyes of the kept pictures with the CPU renderer. Rounding to 8 bits alone gives 59 dB.
  // Returns the lowest value.
  double expect_oracle() const {
    double least_db = 1e9;
    for (const Kept& kept : kept_) {
      for (int eye = 0; eye < 2; ++eye) {
        const auto shown = read_png(kept.files[eye]);
        EXPECT_TRUE(shown) << shown.error().message;
        const double db = shown ? psnr_db(*shown, kept.oracle[eye]) : 0;
        EXPECT_GT(db, 50.0) << kept.files[eye];
        least_db = std::min(least_db, db);
      }
    }
    return least_db;
  }

  // Measured parallax of each box that both eyes see without occlusion, relative to the parallax expected
  // from its faces. Skipped if hands are in view. Opaque objects end at pixel edges, so a single value is
  // accurate to half a pixel.
  std::vector<double> expect_parallax(const Kept& kept) const {
    const auto left = read_png(kept.files[0]), right = read_png(kept.files[1]);
    EXPECT_TRUE(left && right);
    std::vector<double> shares;
    // The eyes have the runtime's distance and look in the same direction.
    const Pose left_from_right = kept.eyes[0].world_from_camera.inverse() * kept.eyes[1].world_from_camera;
    EXPECT_LT((left_from_right.position_m - Eigen::Vector3d(kEyesApart_m, 0, 0)).norm(), 1e-6);
    EXPECT_LT(left_from_right.orientation.vec().norm(), 1e-6);
    if (kept.hands_in_sight) return shares;
    for (const auto& [name, seen] : kept.seen) {
      const auto overlaps = [&](const auto& other) {
        return other.first != name && (other.second.in_picture_px[0].intersects(seen.in_picture_px[0]) ||
                                       other.second.in_picture_px[1].intersects(seen.in_picture_px[1]));
      };
      if (!left || !right || std::any_of(kept.seen.begin(), kept.seen.end(), overlaps)) continue;
      const auto found = parallax(*left, *right, kept.eyes, seen);
      EXPECT_TRUE(found) << name << " is not visible in " << kept.files[0];
      if (!found) continue;
      EXPECT_NEAR(*found, seen.parallax, 0.5 / kept.eyes[0].focal_x_px) << name << " in " << kept.files[0];
      shares.push_back(*found / seen.parallax);
    }
    return shares;
  }

  std::vector<std::string> states() const {
    std::vector<std::string> names;
    for (const auto& row : rows(folder_ / "states.csv")) names.push_back(row.at(1));
    return names;
  }

  ScratchFolder folder_;
  std::mutex mutex_;  // guards the next two during a session
  std::vector<Seen> seen_;
  std::vector<std::string> vulkan_messages_;
  std::vector<Kept> kept_;

 private:
  static void set(const char* name, const std::string& value) { ::setenv(name, value.c_str(), 1); }

  bool hold_against_oracle(const PlannedFrame& picture, const SceneView& view) {
    Kept kept;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename();
      if (!name.starts_with("frame_") || !names_.insert(name).second) continue;
      kept.files[name.ends_with("_1.png")] = entry.path();
    }
    if (kept.files[0].empty()) return false;
    const auto cpu = create_cpu_renderer();
    EXPECT_TRUE(view.draw_again(*cpu, picture.views, kept.oracle));
    for (Image& image : kept.oracle) {  // clamped to the range of a screen
      for (float& value : image.pixels) value = std::min(value, 1.0f);
    }
    kept.eyes = picture.views;
    for (const uint32_t hand : {0u, 1u}) {
      const auto marks =
          view.drawn_object(std::numeric_limits<uint32_t>::max() - hand);  // hand_markers.h: the last two ids
      kept.hands_in_sight = kept.hands_in_sight || (marks && is_before(*marks->kernels, kept.eyes));
    }
    for (const auto& [name, id] : ids_) {
      const auto object = view.drawn_object(id);
      if (const auto seen = object ? seen_by_both(*object, kept.eyes) : std::nullopt) kept.seen[name] = *seen;
    }
    kept_.push_back(std::move(kept));
    return true;
  }
  std::set<std::string> names_;
  std::map<std::string, uint32_t> ids_;  // of rigid objects
};

}  // namespace livegs
