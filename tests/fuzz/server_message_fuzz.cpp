// SPDX-License-Identifier: Apache-2.0
// What a client takes from a server: a livegs.v1.JoinReply, then messages of the stream with events and
// frames.
#include "fuzz/moving_objects.h"
#include "livegs/v1/session.pb.h"
#include "stream/received/known_objects.h"
#include "wire/frame_stream.h"
#include "wire/rest_body_codec.h"

namespace livegs::fuzz::server_message_fuzz {
namespace {

template <class Message>
Bytes bytes_of(const Message& message) {
  const std::string text = message.SerializeAsString();
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <class Message>
bool parse(Message& message, std::span<const std::byte> bytes) {
  return message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

void check_object(const StreamedObject& object) {
  // They become names of files.
  check(object.asset_hash.size() == 64 &&
            object.asset_hash.find_first_not_of("0123456789abcdef") == std::string::npos,
        "a hash is one");
  check(object.broken_asset_hash.empty() || object.broken_asset_hash.size() == 64,
        "a broken asset has a hash or is not");
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  KnownObjects objects;
  StreamReader frames;
  bool joined = false;
  for (const auto part : parts_of(input)) {
    if (!joined) {
      joined = true;
      v1::JoinReply reply;
      if (!parse(reply, part)) return;
      std::vector<const v1::ObjectDescription*> described;
      for (const v1::ObjectDescription& object : reply.objects()) described.push_back(&object);
      const auto difference = objects.replace(described);
      if (!difference) return;
      for (const StreamedObject& object : difference->added) check_object(object);
      const auto again = objects.replace(described);
      check(again && again->added.empty() && again->changed.empty() && again->removed.empty(),
            "told twice, nothing is new");
      continue;
    }
    v1::ServerMessage message;
    if (!parse(message, part)) return;
    for (const v1::SessionEvent& event : message.events()) {
      if (event.has_object_removed()) objects.remove(event.object_removed().object_id());
      if (!event.has_object_added() && !event.has_object_changed()) continue;
      const auto object =
          objects.take(event.has_object_added() ? event.object_added() : event.object_changed());
      if (!object) return;  // ends the session
      check_object(*object);
    }
    if (message.frame().empty()) continue;
    if (const auto frame = frames.read(std::as_bytes(std::span(message.frame())))) check_finite(*frame);
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  v1::JoinReply reply;
  reply.set_session_id("0123456789abcdef0123456789abcdef");
  reply.set_rate_hz(90);
  reply.set_server_instance("00112233445566778899aabbccddeeff");
  const auto describe = [](uint32_t id, const RestBody& rest, v1::ObjectDescription& object) {
    object.set_object_id(id);
    object.set_name("thing " + std::to_string(id));
    object.set_asset_hash(std::string(64, 'a'));
    object.set_asset_bytes(1000);
    object.set_kernel_count(13);
    object.mutable_physics();
    object.add_warnings("its surface was mended");
    const Bytes bytes = encode_rest_body(rest);
    object.set_rest_body(bytes.data(), bytes.size());
  };
  const std::vector<RestBody> rests = rest_bodies();
  for (uint32_t id = 1; id <= 3; ++id)
    describe(3 * id, rests[id % 2 == 0 ? 4 : id - 1], *reply.add_objects());
  std::vector<Bytes> messages{bytes_of(reply)};
  seeds.push_back(joined(messages));
  StreamBaselinePtr baseline;
  for (uint64_t tick = 1; tick < 6; ++tick) {
    const EncodedStreamFrame encoded = encode_stream_frame(frame_at(tick), baseline);
    baseline = encoded.next;
    v1::ServerMessage message;
    message.set_tick(tick);
    message.set_stepped_ns(1000);
    message.set_echoed_ns(10);
    message.set_frame(encoded.bytes.data(), encoded.bytes.size());
    v1::HandState& hand = *message.add_hands();
    for (int i = 0; i < 3; ++i) hand.add_point_m(0.5f);
    if (tick == 2) describe(12, rests[0], *message.add_events()->mutable_object_added());
    if (tick == 3) describe(12, rests[1], *message.add_events()->mutable_object_changed());
    if (tick == 4) message.add_events()->mutable_object_removed()->set_object_id(12);
    if (tick == 5) message.add_events()->set_draining("the end");
    messages.push_back(bytes_of(message));
    seeds.push_back(joined(messages));
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"server_message", look_at, seeds});

}  // namespace livegs::fuzz::server_message_fuzz
