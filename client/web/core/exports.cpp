// SPDX-License-Identifier: Apache-2.0
// Functions that worker.js calls, by plain numbers and addresses in the module's memory. Times are
// nanoseconds of the worker's clock, or of the server's where it says so, as doubles: exact for 104 days. A
// function that can fail returns 0 for success, or one with two answers 0 or 1; error_text() has the reason
// of the last failure. A worker uses either the binder (binder.js) or the scene (worker.js).
#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "stream/time/clock_offset.h"
#include "stream/time/tick_aim.h"
#include "web/core/asset_binder.h"
#include "web/core/live_scene.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

struct State {
  AssetBinder binder;
  LiveScene scene;
  ClockOffset clock;
  std::optional<TickAim> aim;
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

int answer(const Result<bool>& result) {
  if (result) return *result ? 1 : 0;
  state().error = result.error().message;
  return 2;
}

std::span<const std::byte> bytes_at(const void* data, size_t size) {
  return {static_cast<const std::byte*>(data), size};
}

int64_t ns(double value) { return static_cast<int64_t>(value); }

// Result of bound_kernels() and describe_object(), which return its address.
struct BoundView {
  uint32_t description = 0, reserved = 0, count = 0, sh_degree = 0, antialiased = 0;
  const void* rest = nullptr;
  const void* looks = nullptr;
  const void* bands = nullptr;
  uint32_t band_words = 0;
  const void* node_terms = nullptr;
  uint32_t node_term_count = 0;
  const void* node_terms_begin = nullptr;
  uint32_t node_terms_begin_count = 0;
};
struct ObjectView {
  uint32_t description = 0, base = 0, count = 0, fresh = 0, moved = 0;
  const void* rows = nullptr;
  uint32_t row_count = 0;  // of 64 bytes
  uint32_t is_lattice = 0, cell_count = 0, node_count = 0;
  const void* cells = nullptr;
  float cell_width_m = 0;
  float lattice_from_asset[4] = {};  // x y z w
  float body_gradient[9] = {};       // by rows
};
BoundView bound_view;
ObjectView object_view;
float bounds_view_m[6];

}  // namespace
}  // namespace livegs

using namespace livegs;

#define EXPORT(name) __attribute__((export_name(#name))) name

extern "C" {

void* EXPORT(allocate)(size_t size) { return std::malloc(size); }
void EXPORT(release)(void* data) { std::free(data); }
const char* EXPORT(error_text)() { return state().error.c_str(); }
uint32_t EXPORT(protocol_version)() { return kProtocolVersion; }

// The binder.
int EXPORT(take_asset)(uint32_t asset, const void* data, size_t size) {
  return done(state().binder.take_asset(asset, bytes_at(data, size)));
}
int EXPORT(edit_asset)(uint32_t asset, uint32_t base) { return state().binder.edit_asset(asset, base); }
int EXPORT(finish_asset)(uint32_t asset) { return state().binder.finish_asset(asset); }
void EXPORT(drop_asset)(uint32_t asset) { state().binder.drop_asset(asset); }
int EXPORT(bind_object)(uint32_t description, uint32_t asset, const void* rest, size_t size) {
  return done(state().binder.describe(description, asset, bytes_at(rest, size)));
}
void EXPORT(forget_object)(uint32_t description) { state().binder.forget(description); }
// 0: nothing is due; 1: bound_kernels() has an object; 2: it could not be bound.
int EXPORT(bind_next)() { return answer(state().binder.bind_next()); }
const void* EXPORT(bound_kernels)() {
  const AssetBinder::Bound& bound = state().binder.bound();
  bound_view = {bound.description,
                bound.reserved,
                static_cast<uint32_t>(bound.rest.size()),
                static_cast<uint32_t>(bound.sh_degree),
                bound.antialiased,
                bound.rest.data(),
                bound.looks.data(),
                bound.bands.data(),
                static_cast<uint32_t>(bound.bands.size()),
                bound.node_terms.data(),
                static_cast<uint32_t>(bound.node_terms.size()),
                bound.node_terms_begin.data(),
                static_cast<uint32_t>(bound.node_terms_begin.size())};
  return &bound_view;
}
void EXPORT(release_bound)() { state().binder.release(); }

// The scene. 1: the kernels of the description must be bound.
int EXPORT(describe_object)(uint32_t description, uint32_t id, int added, int environment, int hidden,
                            const void* rest, size_t size) {
  return answer(state().scene.describe(description, id, added != 0, environment != 0, hidden != 0,
                                       bytes_at(rest, size)));
}
void EXPORT(remove_object)(uint32_t id) { state().scene.remove(id); }
uint32_t EXPORT(waiting_objects)() { return static_cast<uint32_t>(state().scene.waiting()); }
void EXPORT(begin_bound)(uint32_t description, uint32_t reserved) {
  state().scene.begin_bound(description, reserved);
}
void EXPORT(take_rows)(const RestKernelRow* rows, size_t size) {
  state().scene.take_rows({rows, size / sizeof *rows});
}
// `data`: the terms of the nodes, then their begins. 1: the kernels are used.
int EXPORT(end_bound)(uint32_t term_count, const NodeGradientTerm* data, size_t size) {
  if (size / sizeof *data < term_count) return 2;
  const auto* begins = reinterpret_cast<const uint32_t*>(data + term_count);
  const size_t begin_count = (size - term_count * sizeof *data) / sizeof *begins;
  return answer(state().scene.end_bound({data, term_count}, {begins, begin_count}));
}
void EXPORT(bind_failed)(uint32_t description) { state().scene.bind_failed(description); }

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

// A drawn object.
const void* EXPORT(object)(uint32_t id) {
  object_view = {};
  const LiveScene::Object* object = state().scene.find(id);
  if (!object || !object->posed_by) return &object_view;
  const bool lattice = object->rest.kind == DriverKind::Lattice;
  object_view.description = object->description;
  object_view.base = object->base;
  object_view.count = static_cast<uint32_t>(object->size());
  object_view.fresh = object->fresh;
  object_view.moved = object->moved;
  object_view.rows =
      lattice ? static_cast<const void*>(object->rows.nodes.data()) : object->rows.bodies.data();
  object_view.row_count =
      static_cast<uint32_t>(lattice ? object->rows.nodes.size() : object->rows.bodies.size());
  object_view.is_lattice = lattice;
  const LatticeBody& body = object->rows.lattice;
  if (!lattice) return &object_view;
  object_view.cell_count = static_cast<uint32_t>(object->rest.cells.size());
  object_view.node_count = static_cast<uint32_t>(object->rest.node_coordinates.size());
  object_view.cells = object->rest.cells.data();
  object_view.cell_width_m = body.cell_width_m;
  std::copy_n(body.lattice_from_asset.coeffs().data(), 4, object_view.lattice_from_asset);
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(object_view.body_gradient) = body.gradient;
  return &object_view;
}
// The page gets the kernels of a fresh object: clears `fresh`; its bounds, least and greatest x y z.
const float* EXPORT(sent_kernels)(uint32_t id) {
  const Eigen::AlignedBox3f bounds_m = state().scene.bounds_m(id);
  state().scene.kernels_sent(id);
  for (int axis = 0; axis < 3; ++axis) {
    bounds_view_m[axis] = bounds_m.min()[axis];
    bounds_view_m[3 + axis] = bounds_m.max()[axis];
  }
  return bounds_view_m;
}

void EXPORT(set_view)(float x_m, float y_m, float z_m, float axis_x, float axis_y, float axis_z,
                      int by_distance) {
  state().scene.set_view({{x_m, y_m, z_m}, {axis_x, axis_y, axis_z}, by_distance != 0});
}
void EXPORT(update_keys)() { state().scene.update_keys(); }
// Sorts by the keys; the number of kernels.
uint32_t EXPORT(sort_kernels)() { return static_cast<uint32_t>(state().scene.sort().size()); }
const uint32_t* EXPORT(order)() { return state().scene.order().data(); }

}  // extern "C"
