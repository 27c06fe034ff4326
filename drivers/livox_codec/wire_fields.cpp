#include "drivers/livox_codec/wire_fields.h"

#include <algorithm>
#include <chrono>

#include "core/base/error.h"

namespace rigcal::livox {
namespace {

constexpr std::int64_t hour_microseconds = 3'600'000'000;
constexpr std::int64_t microsecond_ns = 1000;

bool is_printable(std::uint8_t character) { return character > 0x20 && character < 0x7F; }

}  // namespace

std::optional<std::string> read_broadcast_code(ByteReader& reader) {
  const ByteView field = reader.take(kBroadcastCodeLength + 1);
  if (!reader.ok()) return std::nullopt;
  const auto text = field.first(kBroadcastCodeLength);
  if (!std::all_of(text.begin(), text.end(), is_printable) || field.back() != 0) return std::nullopt;
  return std::string(text.begin(), text.end());
}

void write_broadcast_code(const std::string& code, ByteWriter& writer) {
  RIGCAL_ASSERT(code.size() == kBroadcastCodeLength, "broadcast code '" + code + "' has not 15 characters");
  writer.write_text(code, kBroadcastCodeLength + 1);
}

std::optional<std::int64_t> read_utc_time(ByteReader& reader) {
  const int year = 2000 + reader.read<std::uint8_t>();
  const unsigned month = reader.read<std::uint8_t>();
  const unsigned day = reader.read<std::uint8_t>();
  const int hour = reader.read<std::uint8_t>();
  const std::int64_t microseconds = reader.read<std::uint32_t>();
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{month}, std::chrono::day{day}};
  if (!reader.ok() || !date.ok() || hour > 23 || microseconds >= hour_microseconds) return std::nullopt;
  const std::int64_t hours = std::int64_t{std::chrono::sys_days{date}.time_since_epoch().count()} * 24 + hour;
  return (hours * hour_microseconds + microseconds) * microsecond_ns;
}

void write_utc_time(std::int64_t unix_ns, ByteWriter& writer) {
  const std::chrono::sys_time<std::chrono::nanoseconds> time{std::chrono::nanoseconds{unix_ns}};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{day};
  const std::int64_t microseconds = (time - day).count() / microsecond_ns;
  const int year = static_cast<int>(date.year()) - 2000;
  RIGCAL_ASSERT(year >= 0 && year <= 255, "UTC times on the wire reach from 2000 to 2255");
  writer.write(static_cast<std::uint8_t>(year));
  writer.write(static_cast<std::uint8_t>(static_cast<unsigned>(date.month())));
  writer.write(static_cast<std::uint8_t>(static_cast<unsigned>(date.day())));
  writer.write(static_cast<std::uint8_t>(microseconds / hour_microseconds));
  writer.write(static_cast<std::uint32_t>(microseconds % hour_microseconds));
}

}  // namespace rigcal::livox
