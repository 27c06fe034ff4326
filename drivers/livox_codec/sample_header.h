#pragma once

#include <cstdint>
#include <vector>

#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::livox {

/// The 18 bytes of the header. Shared by the encoders of this room.
void append_sample_header(const SampleHeader& header, std::vector<std::uint8_t>& bytes);

/// Replaces `bytes` by the 18 bytes of the header, with room reserved for the whole packet.
void write_sample_header(const SampleHeader& header, std::vector<std::uint8_t>& bytes);

}  // namespace rigcal::livox
