#pragma once

#include "core/records/records.h"

namespace rigcal {

/// What stands before the IP header in the frames of a dump.
enum class LinkLayer { ethernet, raw_ip, cooked_v1, cooked_v2, null };

enum class FrameKind { udp, not_udp, fragment, malformed };

/// Finds the UDP payload in one captured frame. On `udp` fills in from, to and bytes (a view into `frame`); the stamp
/// is left alone. Checksums are not looked at: capturing machines often leave them to the network card.
[[nodiscard]] FrameKind parse_udp(LinkLayer link, ByteView frame, Datagram& datagram);

}  // namespace rigcal
