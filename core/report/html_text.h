#pragma once

#include <string>
#include <string_view>

#include "core/base/bytes.h"

namespace rigcal {

/// A text that comes from outside (a sensor's name, a file's, a warning) so that HTML and SVG show it as it is, also in
/// attributes: what has a meaning there is escaped, bytes that are no UTF-8 and control characters become U+FFFD.
[[nodiscard]] std::string html_text(std::string_view text);

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(ByteView bytes);

}  // namespace rigcal
