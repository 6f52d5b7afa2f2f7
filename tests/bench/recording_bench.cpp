// SPDX-License-Identifier: Apache-2.0
// Size of a recording and time of seeks in it. Prints CSV: `recording_bench [MINUTES] >
// results/<machine>/recording.csv`.
// Four elastic blocks and 200 boxes (bench/support/dragged_blocks.h) move for a tenth of the time, six
// seconds at a time, or always. Two tracked hands of one person are recorded throughout. The six seconds are
// simulated once and played forwards and backwards. A seek goes to a random time and returns the objects and
// the frame, ready to draw; 200 seeks, in wall time and in processor time. goal_seek_ms_max is the bound of a
// seek. The file is read from the page cache.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <random>

#include "bench/support/arguments.h"
#include "bench/support/dragged_blocks.h"
#include "core/clock.h"
#include "recording/recording_writer.h"
#include "scratch_folder.h"
#include "stream/replay/recording_playback.h"
#include "wire/rest_body_codec.h"

using namespace livegs;

namespace {

constexpr double kRate_hz = 90;

// Each value of a hand changes slightly from tick to tick. Values are floats, as on the wire.
void move_hands(InputSample& sample, std::mt19937_64& random) {
  std::normal_distribution<double> step(0, 1e-3);
  for (HandSample& hand : sample.hands) {
    hand.active = true;
    for (Pose* pose : {&hand.aim, &hand.grip}) {
      for (int k = 0; k < 3; ++k)
        pose->position_m[k] = static_cast<float>(pose->position_m[k] + step(random));
      Eigen::Vector4d turned = pose->orientation.coeffs();
      for (int k = 0; k < 4; ++k) turned[k] += step(random);
      turned.normalize();
      for (int k = 0; k < 4; ++k) pose->orientation.coeffs()[k] = static_cast<float>(turned[k]);
    }
  }
  ++sample.sequence;
  sample.for_tick = sample.sequence;
  sample.sampled_ns += 11'111'111 + static_cast<int64_t>(random() % 1000);
}

// The simulated frame that a tick shows.
size_t shown(uint64_t tick, double activity, size_t frames) {
  const uint64_t period = static_cast<uint64_t>(static_cast<double>(frames) / activity);
  const uint64_t stretch = tick / period, within = std::min<uint64_t>(tick % period, frames - 1);
  return stretch % 2 == 0 ? within : frames - 1 - within;
}

double share_of(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

void check(const Result<void>& result) {
  if (result) return;
  std::fprintf(stderr, "%s\n", result.error().message.c_str());
  std::exit(1);
}

void report(const std::vector<DriverFrame>& motion, const std::vector<v1::SessionEvent>& objects,
            double activity, double minutes, bool inputs_only) {
  const ScratchFolder folder;
  v1::RecordingStart start;
  start.set_rate_hz(kRate_hz);
  start.set_inputs_only(inputs_only);
  auto writer = RecordingWriter::create(folder / "a.lvgrec", start);
  if (!writer) check(writer.error());
  for (const v1::SessionEvent& event : objects) check(writer->add_event(1, event));
  std::mt19937_64 random(3);
  InputSample sample;
  const auto ticks = static_cast<uint64_t>(60 * minutes * kRate_hz);
  std::vector<double> write_ms;
  for (uint64_t tick = 1; tick <= ticks; ++tick) {
    DriverFrame frame = motion[shown(tick - 1, activity, motion.size())];
    frame.tick = tick;
    frame.simulated_ns = static_cast<int64_t>(static_cast<double>(tick) * 1e9 / kRate_hz);
    move_hands(sample, random);
    RecordingWriter::Tick one;
    one.tick = tick;
    one.drivers = &frame;
    one.actions.samples.push_back({1, {sample}});
    const int64_t begun_ns = now_ns();
    check(writer->add_tick(std::move(one)));
    write_ms.push_back(milliseconds_from_ns(now_ns() - begun_ns));
  }
  check(writer->finish());
  const double megabytes = static_cast<double>(writer->bytes()) * 1e-6;
  std::vector<double> seek_ms{0}, seek_cpu_ms{0}, decoded{0};
  double open_ms = 0, open_cut_ms = 0;
  const auto opened = [&](double& ms) {
    const int64_t begun_ns = now_ns();
    auto reader = RecordingReader::open(folder / "a.lvgrec");
    ms = milliseconds_from_ns(now_ns() - begun_ns);
    if (!reader) check(reader.error());
  };
  opened(open_ms);
  if (!inputs_only) {
    auto playback = RecordingPlayback::open(folder / "a.lvgrec");
    if (!playback) check(playback.error());
    seek_ms.clear();
    seek_cpu_ms.clear();
    decoded.clear();
    std::uniform_real_distribution<double> moment(0, playback->length_s());
    for (int i = 0; i < 200; ++i) {
      const double wanted = moment(random);
      const int64_t begun_ns = now_ns();
      const std::clock_t cpu_begun = std::clock();
      check(playback->seek(wanted));
      seek_cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu_begun) / CLOCKS_PER_SEC);
      seek_ms.push_back(milliseconds_from_ns(now_ns() - begun_ns));
      decoded.push_back(static_cast<double>(playback->decoded()));
    }
  }
  std::filesystem::resize_file(folder / "a.lvgrec", std::filesystem::file_size(folder / "a.lvgrec") - 8);
  opened(open_cut_ms);
  std::printf("%.0f,%.1f,%s,%.1f,%.1f,%.3f,%.3f,%.2f,%.0f,%.1f,%.1f,%s,%.1f,%.1f,%.0f\n", 100 * activity,
              minutes, inputs_only ? "inputs" : "frames and inputs", megabytes, megabytes / minutes * 60,
              share_of(write_ms, 0.5), share_of(write_ms, 0.99), open_ms, open_cut_ms, share_of(seek_ms, 0.5),
              share_of(seek_ms, 1.0), inputs_only ? "" : "200", share_of(seek_cpu_ms, 0.5),
              share_of(seek_cpu_ms, 1.0), share_of(decoded, 1.0));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  double minutes = 10;
  CLI::App app("Size of recordings and time of seeks; CSV on standard output", "recording_bench");
  app.add_option("MINUTES", minutes, "Length of each recording")
      ->check(bench::between(0.1, 600))
      ->capture_default_str();
  bench::read_arguments(app, argc, argv);
  World world = bench::dragged_blocks();
  std::vector<DriverFrame> motion;
  for (int i = 0; i < 540; ++i) {
    bench::drag(world, world.tick());
    world.step();
    motion.push_back(world.drivers());
  }
  std::vector<v1::SessionEvent> objects;
  for (const ObjectDrivers& drivers : motion.front().objects) {
    v1::ObjectDescription& object = *objects.emplace_back().mutable_object_added();
    object.set_object_id(drivers.object_id);
    object.set_asset_hash(std::string(64, '0'));
    const std::vector<std::byte> rest = encode_rest_body(world.rest_body(drivers.object_id));
    object.set_rest_body(rest.data(), rest.size());
  }
  std::printf(
      "activity_percent,minutes,holds,mb,mb_an_hour,write_ms_p50,write_ms_p99,open_ms,open_cut_ms,seek_ms_"
      "p50,seek_ms_max,goal_seek_ms_max,"
      "seek_cpu_ms_p50,seek_cpu_ms_max,frames_decoded_max\n");
  report(motion, objects, 0.1, minutes, false);
  report(motion, objects, 1.0, minutes, false);
  report(motion, objects, 0.1, minutes, true);
}
