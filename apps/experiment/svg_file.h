#pragma once

#include <string>

namespace rigcal {

/// A picture of `SvgPlot` as a file that stands alone: with the colours and the type that a page would give it.
[[nodiscard]] std::string svg_file(std::string svg);

}  // namespace rigcal
