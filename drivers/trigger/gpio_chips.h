#pragma once

#include <string>

#include "drivers/trigger/gpio_line.h"

/// What both versions of the library share.
namespace rigcal::trigger {

/// A chip as the library describes the device at that path.
[[nodiscard]] GpioChip describe_chip(const std::string& path);

/// The device of a chip by its name, path or label; by the name where none has that label.
[[nodiscard]] std::string chip_path(const std::string& chip);

/// What to say where the system refused something about a line. `verb`: "be driven", "be read", "be asked for".
[[nodiscard]] Error line_error(const LineAddress& address, const std::string& verb, int refusal, const LineUse& use,
                               const std::vector<GpioChip>& chips);

}  // namespace rigcal::trigger
