#include "drivers/gige_codec/frame.h"

#include <algorithm>

#include "core/base/error.h"
#include "drivers/gige_codec/command.h"

namespace rigcal::gige {

std::vector<std::uint8_t> make_frame(std::uint16_t first, std::uint16_t what, std::uint16_t id, ByteView payload) {
  RIGCAL_ASSERT(payload.size() <= kMaxControlPayload, "a payload longer than a frame");
  std::vector<std::uint8_t> out(kHeaderBytes + payload.size());
  auto byte = out.begin();
  for (const std::uint16_t value : {first, what, static_cast<std::uint16_t>(payload.size()), id}) {
    *byte++ = static_cast<std::uint8_t>(value >> 8U);
    *byte++ = static_cast<std::uint8_t>(value);
  }
  std::copy(payload.begin(), payload.end(), byte);
  return out;
}

}  // namespace rigcal::gige
