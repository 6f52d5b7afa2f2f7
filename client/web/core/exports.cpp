// SPDX-License-Identifier: Apache-2.0
// Functions that worker.js calls, by plain numbers and addresses in the module's memory. Times are
// nanoseconds of the worker's clock, or of the server's where it says so, as doubles: exact for 104 days. A
// function that can fail returns 0 for success; error_text() then has the reason of the last failure.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "stream/time/clock_offset.h"
#include "stream/time/tick_aim.h"
#include "web/core/live_scene.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

struct State {
  LiveScene scene;
  ClockOffset clock;
  std::optional<TickAim> aim;
  LiveScene::Packed packed;
  std::string error;
};

State& state() {
  static State* const one = new State;
  return *one;
}

template <class Value>
int done(const Result<Value>& result) {
  if (result) return 0;
  state().error = result.error().message;
  return 1;
}

std::span<const std::byte> bytes_at(const void* data, size_t size) {
  return {static_cast<const std::byte*>(data), size};
}

int64_t ns(double value) { return static_cast<int64_t>(value); }

// What describe_kernels() and describe_drivers() return the address of.
struct KernelsView {
  uint32_t base = 0, count = 0, sh_degree = 0, antialiased = 0, is_lattice = 0, cell_count = 0,
           node_count = 0;
  const void* rest = nullptr;
  const void* cells = nullptr;
  const void* looks = nullptr;
  const void* bands = nullptr;
  uint32_t band_words = 0;
  float bounds_m[6] = {};
};
struct DriversView {
  const void* rows = nullptr;
  uint32_t row_count = 0;  // of 64 bytes
  uint32_t is_lattice = 0, moved = 0, unpacked = 0;
  float cell_width_m = 0;
  float lattice_from_asset[4] = {};  // x y z w
  float body_gradient[9] = {};       // by rows
};
KernelsView kernels_view;
DriversView drivers_view;

}  // namespace
}  // namespace livegs

using namespace livegs;

#define EXPORT(name) __attribute__((export_name(#name))) name

extern "C" {

void* EXPORT(allocate)(size_t size) { return std::malloc(size); }
void EXPORT(release)(void* data) { std::free(data); }
const char* EXPORT(error_text)() { return state().error.c_str(); }
uint32_t EXPORT(protocol_version)() { return kProtocolVersion; }

int EXPORT(take_asset)(uint32_t asset, const void* data, size_t size) {
  return done(state().scene.take_asset(asset, bytes_at(data, size)));
}
int EXPORT(asset_complete)(uint32_t asset) { return state().scene.asset_complete(asset); }
void EXPORT(drop_asset)(uint32_t asset) { state().scene.drop_asset(asset); }

int EXPORT(describe_object)(uint32_t id, int added, int environment, int hidden, uint32_t asset,
                            const void* rest, size_t size) {
  return done(
      state().scene.describe(id, added != 0, environment != 0, hidden != 0, asset, bytes_at(rest, size)));
}
void EXPORT(remove_object)(uint32_t id) { state().scene.remove(id); }
int EXPORT(bind_arrived)() { return done(state().scene.bind_arrived()); }
uint32_t EXPORT(waiting_objects)() { return static_cast<uint32_t>(state().scene.waiting()); }

// Once for each stream of a session.
void EXPORT(begin_stream)(double rate_hz) {
  state().scene.begin_stream();
  state().aim.emplace(rate_hz);
}
// Forgets the time of a server that was restarted.
void EXPORT(restart)() {
  state().scene.restart();
  state().clock = {};
}
int EXPORT(needs_keyframe)() { return state().scene.needs_keyframe(); }
// `begun_ns`: start of the step, server's clock.
int EXPORT(take_frame)(const void* data, size_t size, double received_ns, double tick, double begun_ns) {
  if (state().aim) state().aim->add_frame(static_cast<uint64_t>(tick), ns(begun_ns));
  return done(state().scene.take_frame(bytes_at(data, size), ns(received_ns)));
}
// A message and its echo (ClockSample).
void EXPORT(take_clock)(double sent_ns, double server_received_ns, double server_sent_ns,
                        double received_ns) {
  state().clock.add({ns(sent_ns), ns(server_received_ns), ns(server_sent_ns), ns(received_ns)});
  if (state().aim) state().aim->arrived(ns(sent_ns), ns(server_received_ns));
}
double EXPORT(clock_offset_ns)(double now_ns) {
  const auto known = state().clock.at(ns(now_ns));
  return known ? static_cast<double>(known->offset_ns) : 0;
}
double EXPORT(aimed_tick)(double now_ns) {
  return state().aim ? static_cast<double>(state().aim->tick_at(ns(now_ns))) : 0;
}

// Moves the scene to the playout moment; 1 if anything changed.
int EXPORT(play)(double now_ns) { return state().scene.play(ns(now_ns)); }
double EXPORT(shown_tick)() { return static_cast<double>(state().scene.shown_tick()); }
uint32_t EXPORT(drawn_count)() { return static_cast<uint32_t>(state().scene.drawn().size()); }
const uint32_t* EXPORT(drawn_ids)() { return state().scene.drawn().data(); }

// Drivers of a drawn object.
const void* EXPORT(describe_drivers)(uint32_t id) {
  drivers_view = {};
  const LiveScene::Object* object = state().scene.find(id);
  if (!object || !object->posed_by) return &drivers_view;
  const bool lattice = object->rest.kind == DriverKind::Lattice;
  drivers_view.rows =
      lattice ? static_cast<const void*>(object->rows.nodes.data()) : object->rows.bodies.data();
  drivers_view.row_count =
      static_cast<uint32_t>(lattice ? object->rows.nodes.size() : object->rows.bodies.size());
  drivers_view.is_lattice = lattice;
  drivers_view.moved = object->moved;
  drivers_view.unpacked = object->unpacked != nullptr;
  const LatticeBody& body = object->rows.lattice;
  if (!lattice) return &drivers_view;
  drivers_view.cell_width_m = body.cell_width_m;
  std::copy_n(body.lattice_from_asset.coeffs().data(), 4, drivers_view.lattice_from_asset);
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(drivers_view.body_gradient) = body.gradient;
  return &drivers_view;
}

// Packs the kernels of a drawn object that was bound; valid until the next call.
const void* EXPORT(describe_kernels)(uint32_t id) {
  kernels_view = {};
  const LiveScene::Object* object = state().scene.find(id);
  if (!object) return &kernels_view;
  LiveScene::Packed& packed = state().packed = state().scene.packed(id);
  kernels_view.base = object->base;
  kernels_view.count = static_cast<uint32_t>(packed.rest.size());
  kernels_view.sh_degree = static_cast<uint32_t>(object->sh_degree);
  kernels_view.antialiased = object->antialiased;
  kernels_view.is_lattice = object->rest.kind == DriverKind::Lattice;
  kernels_view.cell_count = static_cast<uint32_t>(object->rest.cells.size());
  kernels_view.node_count = static_cast<uint32_t>(object->rest.node_coordinates.size());
  kernels_view.rest = packed.rest.data();
  kernels_view.cells = object->rest.cells.data();
  kernels_view.looks = packed.looks.data();
  kernels_view.bands = packed.bands.data();
  kernels_view.band_words = static_cast<uint32_t>(packed.bands.size());
  for (int axis = 0; axis < 3; ++axis) {
    kernels_view.bounds_m[axis] = packed.bounds_m.min()[axis];
    kernels_view.bounds_m[3 + axis] = packed.bounds_m.max()[axis];
  }
  return &kernels_view;
}
void EXPORT(release_kernels)() { state().packed = {}; }

void EXPORT(set_view)(float x_m, float y_m, float z_m, float axis_x, float axis_y, float axis_z,
                      int by_distance) {
  state().scene.set_view({{x_m, y_m, z_m}, {axis_x, axis_y, axis_z}, by_distance != 0});
}
void EXPORT(update_keys)() { state().scene.update_keys(); }
// Sorts by the keys; the number of kernels.
uint32_t EXPORT(sort_kernels)() { return static_cast<uint32_t>(state().scene.sort().size()); }
const uint32_t* EXPORT(order)() { return state().scene.order().data(); }

}  // extern "C"
