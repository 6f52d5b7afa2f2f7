// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/replay.h"

#include <google/protobuf/util/json_util.h>
#include <unistd.h>

#include <cstdio>

#include "cli/commands.h"
#include "core/clock.h"
#include "recording/recording_reader.h"
#include "session/recording/verify_recording.h"

namespace livegs {
namespace {

unsigned long long count(uint64_t value) { return value; }

void print_summary(RecordingReader& recording) {
  const v1::RecordingStart& start = recording.start();
  const v1::RecordingTotals& totals = recording.totals();
  const double length_s = seconds_from_ns(totals.last_ns() - totals.first_ns());
  std::printf("recording  %s: %.1f MB, of %s, livegs %s, protocol %u\n", recording.path().c_str(),
              static_cast<double>(recording.bytes()) * 1e-6, start.scene().name().c_str(),
              start.livegs_version().c_str(), start.protocol_version());
  std::printf("length     %.1f s, ticks %llu to %llu, %.0f per second, %zu key ticks%s%s\n", length_s,
              count(totals.first_tick()), count(totals.last_tick()), start.rate_hz(), recording.keys().size(),
              start.inputs_only() ? "; inputs only" : "",
              recording.ended_in_order() ? "" : "; incomplete: the server or its disk failed");
  const auto objects = recording.seek(INT64_MIN);
  const size_t there = objects ? objects->size() : 0;
  std::printf("objects    %zu initially, %llu added, %llu removed, %llu breaks\n", there,
              count(totals.objects_added() - std::min<uint64_t>(there, totals.objects_added())),
              count(totals.objects_removed()), count(totals.breaks()));
  std::printf("inputs     %llu hand samples, %llu changes, %llu resets%s\n", count(totals.inputs()),
              count(totals.changes()), count(totals.resets()),
              start.whole() ? "; complete from the start; use --verify to simulate it again" : "");
}

// Checks all check sums up to the end, or to the point where the file is cut off.
Result<void> read_through(RecordingReader& recording) {
  recording.rewind();
  for (;;) {
    const auto next = recording.next();
    if (!next) return next.error();
    if (!*next) return {};
  }
}

void print_json(const RecordingReader& recording) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = options.preserve_proto_field_names = options.always_print_primitive_fields = true;
  std::string text;
  if (google::protobuf::util::MessageToJsonString(recording.totals(), &text, options).ok())
    std::fputs(text.c_str(), stdout);
}

int verify(RecordingReader& recording, const ReplayRequest& options) {
  const bool shows = isatty(STDERR_FILENO) != 0;
  const uint64_t last = recording.totals().last_tick();
  const auto seen = verify_recording(recording, options.folder, [&](uint64_t tick) {
    if (shows && tick % 90 == 0) std::fprintf(stderr, "\rtick %llu of %llu", count(tick), count(last));
  });
  if (shows) std::fputc('\n', stderr);
  if (!seen) return report(seen.error());
  const auto& difference = seen->difference;
  if (options.json) {
    std::printf("{\"ticks\": %llu, \"frames\": %llu, \"equal\": %s", count(seen->ticks), count(seen->frames),
                difference ? "false" : "true");
    if (difference)
      std::printf(", \"tick\": %llu, \"object_id\": %u", count(difference->tick), difference->object_id);
    std::printf("}\n");
  } else if (difference) {
    std::printf("different: at tick %llu (%.3f s) object %u (%s) %s\n", count(difference->tick),
                static_cast<double>(difference->tick) / recording.start().rate_hz(), difference->object_id,
                difference->object.c_str(), difference->what.c_str());
  } else {
    std::printf("bit-equal: %llu ticks, %llu frames\n", count(seen->ticks), count(seen->frames));
  }
  return difference ? 1 : 0;
}

}  // namespace

int replay(const ReplayRequest& options) {
  auto recording = RecordingReader::open(options.file);
  if (!recording) return report(recording.error());
  if (options.verify) return verify(*recording, options);
  if (options.json)
    print_json(*recording);
  else
    print_summary(*recording);
  if (auto read = read_through(*recording); !read) return report(read.error());
  if (!options.json)
    std::printf("checksums  valid%s\n", recording->ended_in_order() ? "" : " up to the incomplete end");
  return 0;
}

}  // namespace livegs
