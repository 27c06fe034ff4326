#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"

/// What commands and acks have in common on the wire; used by command.cpp and ack.cpp only.
namespace rigcal::gige {

/// `first` is key and flags, or a status; `what` the number of a command or an ack. The payload must fit a frame.
[[nodiscard]] std::vector<std::uint8_t> make_frame(std::uint16_t first, std::uint16_t what, std::uint16_t id,
                                                   ByteView payload);

}  // namespace rigcal::gige
