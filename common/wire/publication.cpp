// SPDX-License-Identifier: Apache-2.0
// The layout is proto/frame_format.md, "Publications".
#include "wire/publication.h"

#include <algorithm>

#include "core/assert.h"
#include "wire/frame_stream.h"
#include "wire/header.h"
#include "wire/little_endian.h"

namespace livegs {
namespace {

constexpr MessageHeader<uint8_t, uint8_t> kHeader{"publication", " with 0xD7", 0xD7, 1};
constexpr size_t kInstanceBytes = 16;
constexpr const char* kDigits = "0123456789abcdef";

int digit(char c) {
  const char* const found = std::find(kDigits, kDigits + 16, c);
  LIVEGS_ASSERT(found != kDigits + 16);
  return static_cast<int>(found - kDigits);
}

}  // namespace

std::vector<std::byte> encode_publication(const Publication& publication) {
  LIVEGS_ASSERT(publication.server_instance.size() == 2 * kInstanceBytes);
  ByteWriter out;
  kHeader.write(out);
  for (size_t i = 0; i < kInstanceBytes; ++i) {
    out.write(static_cast<uint8_t>(digit(publication.server_instance[2 * i]) << 4 |
                                   digit(publication.server_instance[2 * i + 1])));
  }
  out.write(publication.event_number);
  out.write(publication.stepped_ns);
  std::vector<std::byte> bytes = std::move(out).take();
  // A subscriber reads each frame separately: computing neighbours would cost more than they save.
  StreamOptions options;
  options.send_neighbours = false;
  const std::vector<std::byte> frame = encode_stream_frame(publication.frame, nullptr, options).bytes;
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  return bytes;
}

Result<Publication> decode_publication(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const auto magic = in.read<uint8_t>(), version = in.read<uint8_t>();
  if (auto known = kHeader.check(magic, version, in.failed()); !known) return known.error();
  Publication publication;
  for (size_t i = 0; i < kInstanceBytes; ++i) {
    const auto byte = in.read<uint8_t>();
    publication.server_instance += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  publication.event_number = in.read<uint64_t>();
  publication.stepped_ns = in.read<int64_t>();
  if (in.failed()) return kHeader.invalid("is truncated");
  auto frame = StreamReader().read(bytes.subspan(in.offset()));
  if (!frame) return frame.error();
  publication.frame = std::move(*frame);
  return publication;
}

}  // namespace livegs
