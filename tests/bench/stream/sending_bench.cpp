// SPDX-License-Identifier: Apache-2.0
// Errors of a client with a bandwidth cap, and savings if it looks elsewhere. Prints CSV: `sending_bench >
// results/<machine>/sending.csv`.
// Motion: codec_bench (dragged_blocks.h), 6 s at 90 Hz, without the first second. The client is 0.8 m in
// front of the first of four blocks; the fourth is 1.6 m further away. The error of an object is the angle at
// the eye between the position of its worst driver and the client's position of it, for objects in the view
// cone. A pixel of a headset with 25 pixels per degree is 0.7 mrad. `awake_mrad`: awake objects only, because
// most boxes soon rest. `frames`: whole frames or none, for comparison. `objects`: the most important objects
// first. Encoding is processor time of its one thread.
#include <time.h>

#include <algorithm>
#include <cstdio>

#include "bench/support/arguments.h"
#include "bench/support/dragged_blocks.h"
#include "core/percentile.h"
#include "session/frames/send_budget.h"
#include "session/frames/shared_frame_payload.h"
#include "session/frames/tick_encodings.h"

using namespace livegs;
using namespace livegs::bench;

namespace {

constexpr int64_t kTick_ns = 11'111'111;
constexpr size_t kFirst = 90;

double processor_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

struct Client {
  const char* looks;
  std::optional<ViewCone> view;
};

// `whole_frames`: a frame has all objects in view, or is not sent.
void run(const std::vector<DriverFrame>& motion, const Client& client, double cap_mbit_s, bool whole_frames) {
  auto reaches = std::make_shared<ObjectReaches>();
  for (const ObjectDrivers& object : motion.front().objects)
    reaches->emplace(object.object_id, object.kind == DriverKind::Lattice ? 0.05 : 0.07);
  const ClientView who{client.view, {}};
  SendBudget budget;
  budget.set_cap(cap_mbit_s > 0 ? cap_mbit_s * 1e6 / 8 : std::numeric_limits<double>::infinity());
  StreamBaselinePtr baseline;
  StreamReader reader;
  DriverFrame seen;
  std::vector<double> off_mrad, awake_mrad, encode_us;
  std::vector<size_t> bytes(motion.size(), 0);
  size_t sent = 0;
  for (size_t i = 0; i < motion.size(); ++i) {
    const double available = budget.available_bytes(static_cast<int64_t>(i + 1) * kTick_ns);
    if (available > 0) {
      TickEncodings tick(motion[i], nullptr);
      tick.reaches = reaches;
      const double begun_us = processor_us();
      const EncodedFrame frame =
          whole_frames ? tick.for_client(baseline, who) : tick.for_client(baseline, who, available);
      if (i >= kFirst) encode_us.push_back(processor_us() - begun_us);
      baseline = frame.next;
      budget.pay(static_cast<double>(frame.bytes));
      bytes[i] = frame.bytes;
      const auto* const end = reinterpret_cast<const std::byte*>(frame.tail->slice.end());
      auto read = reader.read({end - frame.bytes, end});
      if (!read) std::fprintf(stderr, "%s\n", read.error().message.c_str());
      if (read) seen = std::move(*read);
      sent += i >= kFirst ? 1 : 0;
    }
    if (i < kFirst) continue;
    const Eigen::Vector3d eye = client.view ? client.view->position_m : Eigen::Vector3d(0, 0.3, 1.0);
    for (size_t k = 0; k < motion[i].objects.size(); ++k) {
      const ObjectDrivers &is = motion[i].objects[k], &has = seen.objects[k];
      const ObjectBall ball = ball_around(is, 0.05);
      if (client.view && !client.view->touches(ball.centre_m, ball.radius_m)) continue;
      double off_m = 0;
      for (size_t d = 0; d < is.positions_m.size(); ++d)
        off_m = std::max(off_m, static_cast<double>((is.positions_m[d] - has.positions_m[d]).norm()));
      for (size_t d = 0; d < is.poses.size(); ++d)
        off_m = std::max(off_m, (is.poses[d].position_m - has.poses[d].position_m).norm());
      off_mrad.push_back(1e3 * off_m / std::max(0.25, (ball.centre_m - eye).norm()));
      if (!is.asleep) awake_mrad.push_back(off_mrad.back());
    }
  }
  size_t total = 0, most_a_second = 0;
  for (size_t i = kFirst; i < bytes.size(); ++i) {
    total += bytes[i];
    size_t second = 0;
    for (size_t k = i; k < std::min(bytes.size(), i + 90); ++k) second += bytes[k];
    most_a_second = std::max(most_a_second, second);
  }
  const double seconds = static_cast<double>(motion.size() - kFirst) / 90;
  std::printf("%s,%s,%s,%.1f,%.2f,%.2f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.0f,%.0f\n", client.looks,
              cap_mbit_s > 0 ? std::to_string(static_cast<int>(cap_mbit_s)).c_str() : "none",
              whole_frames ? "frames" : "objects", static_cast<double>(sent) / seconds,
              8e-6 * static_cast<double>(total) / seconds, 8e-6 * static_cast<double>(most_a_second),
              percentile(off_mrad, 0.5), percentile(off_mrad, 0.95), percentile(off_mrad, 0.99),
              percentile(awake_mrad, 0.5), percentile(awake_mrad, 0.75), percentile(awake_mrad, 0.95),
              percentile(encode_us, 0.5), percentile(encode_us, 0.99));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Errors of a client with a bandwidth cap; CSV on standard output", "sending_bench");
  read_arguments(app, argc, argv);
  World world = dragged_blocks();
  std::vector<DriverFrame> motion;
  for (int i = 0; i < 540; ++i) {
    drag(world, world.tick());
    world.step();
    motion.push_back(world.drivers());
  }
  std::printf(
      "looks,cap_mbit_s,leaves_out,frames_a_second,mbit_s,most_mbit_s_over_a_second,off_mrad_p50,off_mrad_"
      "p95,off_mrad_p99,"
      "awake_mrad_p50,awake_mrad_p75,awake_mrad_p95,encode_us_p50,encode_us_p99\n");
  const Eigen::Vector3d eye(0, 0.3, 1.0);
  const Client everywhere{"everywhere", std::nullopt};
  const Client at_all{"at all of it", ViewCone{eye, Eigen::Vector3d(0.5, 0, -1).normalized(), 1.4}};
  const Client at_one{"at one block of four", ViewCone{eye, Eigen::Vector3d(-0.3, 0, -1).normalized(), 0.35}};
  const Client away{"away", ViewCone{eye, Eigen::Vector3d(0, 0, 1), 0.5}};
  for (const Client& client : {everywhere, at_all, at_one, away}) run(motion, client, 0, false);
  for (const double cap_mbit_s : {8, 4, 2, 1}) {
    for (const bool whole_frames : {true, false}) run(motion, at_all, cap_mbit_s, whole_frames);
  }
  return 0;
}
