#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "drivers/livox_codec/control_payload.h"
#include "drivers/livox_codec/wire_fields.h"

/// Fields of control payloads off and onto the wire; used by control_payload.cpp only.
namespace rigcal::livox {

template <class T>
concept HasFields = requires(T value) {
  value.fields();
};

/// Whether an enumeration has a value. Error and return codes come in acks only and are never asked.
template <class Enum>
constexpr bool is_defined(Enum value) {
  const auto number = static_cast<unsigned>(value);
  if constexpr (std::is_same_v<Enum, PowerMode>) return number >= 1 && number <= 3;
  if constexpr (std::is_same_v<Enum, Echoes>) return number <= 3;
  return number <= 1;  // Switches of all kinds.
}

/// Reads fields until one is wrong; after that nothing changes any more.
class PayloadReader {
 public:
  explicit PayloadReader(ByteView payload) : bytes_(payload) {}

  /// Whether enumerations must have the value that is read.
  void be_strict(bool strict) { strict_ = strict; }

  /// What is wrong; empty while nothing is.
  [[nodiscard]] const std::string& mistake() const { return mistake_; }
  [[nodiscard]] std::size_t offset() const { return at_; }

  template <class T>
  void read(T& value) {
    if (!mistake_.empty()) return;
    at_ = bytes_.offset();
    if constexpr (HasFields<T>) {
      std::apply([&](auto&... field) { (read(field), ...); }, value.fields());
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(bytes_.read<std::underlying_type_t<T>>());
      if (strict_ && bytes_.ok() && !is_defined(value)) {
        fail("the value " + std::to_string(static_cast<unsigned>(value)) + " is not known");
      }
    } else {
      value = bytes_.read<T>();
      if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(value)) fail("not a finite number");
      }
    }
    if (!bytes_.ok()) fail("ends too soon");
  }

  void read(std::string& code) {
    if (!mistake_.empty()) return;
    at_ = bytes_.offset();
    std::optional<std::string> text = read_broadcast_code(bytes_);
    if (!bytes_.ok()) return fail("ends too soon");
    if (!text) return fail("the broadcast code is not 15 printable characters");
    code = std::move(*text);
  }

  void read(UtcTime& time) {
    if (!mistake_.empty()) return;
    at_ = bytes_.offset();
    const std::optional<std::int64_t> unix_ns = read_utc_time(bytes_);
    if (!bytes_.ok()) return fail("ends too soon");
    if (!unix_ns) return fail("the time is no date");
    time.unix_ns = *unix_ns;
  }

  template <class T, std::size_t size>
  void read(std::array<T, size>& values) {
    for (T& value : values) read(value);
  }

  /// What only new or only some devices send, at the end.
  template <class T>
  void read(std::optional<T>& value) {
    if (mistake_.empty() && bytes_.left() > 0) read(value.emplace());
  }

  template <class T>
  void read(std::vector<T>& items) {
    std::uint8_t count = 0;
    read(count);
    for (unsigned i = 0; i < count && mistake_.empty(); ++i) read(items.emplace_back());
  }

  /// Parameters are not counted: they fill the rest.
  void read(std::vector<Parameter>& parameters) {
    while (mistake_.empty() && bytes_.left() > 0) {
      Parameter& parameter = parameters.emplace_back();
      std::uint16_t length = 0;
      read(parameter.key);
      read(length);
      const ByteView value = bytes_.take(length);
      parameter.value.assign(value.begin(), value.end());
      if (!bytes_.ok()) fail("a parameter ends too soon");
    }
  }

  void finish() {
    if (!mistake_.empty() || bytes_.left() == 0) return;
    at_ = bytes_.offset();
    fail(std::to_string(bytes_.left()) + " bytes too many");
  }

  void fail(std::string_view mistake);

 private:
  ByteReader bytes_;
  bool strict_ = true;
  std::size_t at_ = 0;
  std::string mistake_;
};

class PayloadWriter {
 public:
  explicit PayloadWriter(std::vector<std::uint8_t>& out) : bytes_(out) {}

  template <class T>
  void write(const T& value) {
    if constexpr (HasFields<T>) {
      T copy = value;  // `fields` gives references that can be read into.
      std::apply([&](const auto&... field) { (write(field), ...); }, copy.fields());
    } else if constexpr (std::is_enum_v<T>) {
      bytes_.write(static_cast<std::underlying_type_t<T>>(value));
    } else {
      bytes_.write(value);
    }
  }
  void write(const std::string& code) { write_broadcast_code(code, bytes_); }
  void write(const UtcTime& time) { write_utc_time(time.unix_ns, bytes_); }
  template <class T, std::size_t size>
  void write(const std::array<T, size>& values) {
    for (const T& value : values) write(value);
  }
  template <class T>
  void write(const std::optional<T>& value) {
    if (value) write(*value);
  }
  template <class T>
  void write(const std::vector<T>& items) {
    RIGCAL_ASSERT(items.size() <= std::numeric_limits<std::uint8_t>::max(), "a list of more than 255 entries");
    bytes_.write(static_cast<std::uint8_t>(items.size()));
    for (const T& item : items) write(item);
  }
  void write(const std::vector<Parameter>& parameters) {
    for (const Parameter& parameter : parameters) {
      RIGCAL_ASSERT(parameter.value.size() <= kMaxFrameBytes, "a parameter that fits into no frame");
      bytes_.write(parameter.key);
      bytes_.write(static_cast<std::uint16_t>(parameter.value.size()));
      bytes_.write_bytes(parameter.value);
    }
  }

 private:
  ByteWriter bytes_;
};

}  // namespace rigcal::livox
