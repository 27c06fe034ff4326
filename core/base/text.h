#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace rigcal {

/// The shortest text that reads back to the same bits, always with a point ("1.0e-05"), so that every YAML reader takes
/// it for a number; what is not finite as YAML writes it (".inf", "-.inf", ".nan"). Independent of the locale.
[[nodiscard]] std::string number_text(double value);

/// With so many digits behind the point, for people: fixed_text(1.2345, 2) is "1.23"; there is no "-0.00".
[[nodiscard]] std::string fixed_text(double value, int digits);

/// "1 stop", "3 stops": of nouns that take an s.
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view noun);

/// "a, b, c" by the separator ", ".
[[nodiscard]] std::string joined(const std::vector<std::string>& parts, std::string_view separator);

/// "a, b, c", of more than `most` those, and how many there are beside: "a, b and 3 more".
[[nodiscard]] std::string joined_some(const std::vector<std::string>& parts, std::size_t most);

/// With the letters A to Z made small, all else as it is. Independent of the locale.
[[nodiscard]] std::string small_letters(std::string_view text);

/// Length of the UTF-8 character at `at` (RFC 3629: shortest form, no surrogates); 0: there is none.
[[nodiscard]] std::size_t utf8_length(std::string_view text, std::size_t at);
/// What stands for bytes that are no character: U+FFFD.
inline constexpr std::string_view utf8_replacement = "\xEF\xBF\xBD";

/// A text as a YAML scalar in double quotes; control characters are escaped, bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string quoted_text(std::string_view text);

/// A text as a YAML key: plain where that is safe, quoted otherwise.
[[nodiscard]] std::string key_text(std::string_view text);

}  // namespace rigcal
