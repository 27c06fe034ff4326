#pragma once

#include "apps/recording/datagram_file.h"

namespace rigcal {

/// Whether a file begins as an .lvx file does.
[[nodiscard]] bool is_lvx(const std::string& path);

/// An .lvx recording as the datagrams that its devices sent. The file has no addresses: device N of its list (from 1)
/// speaks from 0.0.0.N, which no real device can have, and tells its broadcast code and type first, as devices on a
/// network do. Nor has it receive stamps: the session clock is that of the device that speaks first (LeadingClock).
[[nodiscard]] Expected<std::unique_ptr<DatagramFile>> open_lvx_datagrams(const std::string& path);

}  // namespace rigcal
