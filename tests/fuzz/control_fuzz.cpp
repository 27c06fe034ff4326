// Control frames of any bytes: refused, or the same again after writing, never read past the end. A fuzzer cannot guess
// checksums, so that each input is tried with the right ones too.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "drivers/livox_codec/control_payload.h"

namespace {

using namespace rigcal::livox;

void check_payload(const ControlFrame& frame) {
  const auto payload = decode_control(frame);
  if (!payload) {
    RIGCAL_ASSERT(!payload.error().what.empty() && !payload.error().where.empty(), "an error without text");
    return;
  }
  // Not always the same bytes: a refusal of one byte comes back with all its fields, a handshake as a command.
  const auto bytes = encode_control(*payload, frame.seq);
  const auto again = parse_control_frame(bytes);
  RIGCAL_ASSERT(again && command_of(*again) == command_of(frame), "a frame of another command");
  const auto back = decode_control(*again);
  RIGCAL_ASSERT(back && *back == *payload, "a payload has changed");
}

void check_frame(rigcal::ByteView bytes) {
  const auto frame = parse_control_frame(bytes);
  if (!frame) return;
  const auto back = make_control_frame(*frame);
  RIGCAL_ASSERT(std::equal(back.begin(), back.end(), bytes.begin()), "a frame has changed");
  RIGCAL_ASSERT(parse_control_frame(make_refusal(*frame)).has_value(), "a refusal that is no frame");
  check_payload(*frame);
}

template <class Checksum>
void put_checksum(std::vector<std::uint8_t>& bytes, std::size_t at, Checksum checksum) {
  std::memcpy(bytes.data() + at, &checksum, sizeof checksum);
}

std::vector<std::uint8_t> with_checksums(rigcal::ByteView bytes) {
  std::vector<std::uint8_t> frame(bytes.begin(), bytes.end());
  if (frame.size() < kMinFrameBytes || frame.size() > kMaxFrameBytes) return frame;
  frame[0] = 0xAA;
  frame[1] = 1;
  put_checksum(frame, 2, static_cast<std::uint16_t>(frame.size()));
  put_checksum(frame, 7, crc16(rigcal::ByteView(frame).first(7)));
  put_checksum(frame, frame.size() - 4, crc32(rigcal::ByteView(frame).first(frame.size() - 4)));
  return frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ByteView view(bytes, size);
  check_frame(view);
  check_frame(with_checksums(view));
  return 0;
}
