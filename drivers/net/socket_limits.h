#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace rigcal::net {

/// The largest receive buffer that the system gives without privileges (net.core.rmem_max); nothing where it does not
/// say.
[[nodiscard]] std::optional<std::size_t> largest_receive_buffer();

/// What to do where a socket got less than was asked for: one sentence with the command.
[[nodiscard]] std::string receive_buffer_hint(std::size_t asked_bytes, std::size_t got_bytes);

}  // namespace rigcal::net
