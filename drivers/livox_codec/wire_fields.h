#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/bytes.h"

/// Fields that several packets of the protocol share.
namespace rigcal::livox {

constexpr std::size_t kBroadcastCodeLength = 15;

/// 15 printable characters and a NUL; nothing where the bytes are something else or end too soon.
[[nodiscard]] std::optional<std::string> read_broadcast_code(ByteReader& reader);
/// `code` must have 15 characters.
void write_broadcast_code(const std::string& code, ByteWriter& writer);

/// Unix time in nanoseconds of year, month, day, hour (a byte each, the year from 2000) and microseconds in the hour;
/// nothing where that is no date.
[[nodiscard]] std::optional<std::int64_t> read_utc_time(ByteReader& reader);
/// Cut to microseconds; the time must lie in the years 2000 to 2255.
void write_utc_time(std::int64_t unix_ns, ByteWriter& writer);

}  // namespace rigcal::livox
