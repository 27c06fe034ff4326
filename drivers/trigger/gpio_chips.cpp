#include "drivers/trigger/gpio_chips.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace rigcal::trigger {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_chips = 256;

std::string chips_text(const std::vector<GpioChip>& chips) {
  if (chips.empty()) return "this machine has no GPIO chip";
  std::string text = "there are: ";
  for (const GpioChip& chip : chips)
    text += (&chip == &chips.front() ? "" : ", ") + chip.name + (chip.label.empty() ? "" : " (" + chip.label + ")");
  return text;
}

const GpioChip* find_chip(const std::vector<GpioChip>& chips, const std::string& chip) {
  const auto found = std::find_if(chips.begin(), chips.end(), [&chip](const GpioChip& known) {
    return known.name == chip || known.label == chip || "/dev/" + known.name == chip;
  });
  return found == chips.end() ? nullptr : &*found;
}

}  // namespace

std::vector<GpioChip> list_chips() {
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::directory_iterator entry("/dev", error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().filename().string().starts_with("gpiochip") && paths.size() < most_chips)
      paths.push_back(entry->path().string());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<GpioChip> chips;
  for (const std::string& path : paths) chips.push_back(describe_chip(path));
  return chips;
}

std::string chip_path(const std::string& chip) {
  if (chip.starts_with("/")) return chip;
  for (const GpioChip& known : list_chips())
    if (known.label == chip) return "/dev/" + known.name;
  return "/dev/" + chip;
}

Error line_error(const LineAddress& address, const std::string& verb, int refusal, const LineUse& use,
                 const std::vector<GpioChip>& chips) {
  const std::string where = address.chip + ", line " + std::to_string(address.line);
  const GpioChip* chip = find_chip(chips, address.chip);
  switch (refusal) {
    case ENOENT:
    case ENXIO:
      return system_error("there is no such GPIO chip", where, "correct the rig file's gpiochip; " + chips_text(chips));
    case EACCES:
    case EPERM:
      return system_error(
          "this user may not use the GPIO chip", where,
          "install the rules of rigcal (rigcal doctor says how), and: sudo adduser $USER plugdev (then log in again)");
    case EBUSY:
      return system_error("the line is held by " + (use.consumer.empty() ? "another program" : use.consumer), where,
                          "end that program, or take another line");
    case EINVAL:
      if (chip != nullptr && address.line >= chip->lines && chip->lines > 0)
        return system_error("the chip has no such line, only 0 to " + std::to_string(chip->lines - 1), where,
                            "correct the rig file's line");
      break;
    case ENODEV:
    case EIO:
      return system_error("the GPIO chip is gone", where, "plug it in again, or load its driver");
    case ENOSYS:
    case EOPNOTSUPP:
      return system_error("the line cannot " + verb + ": its chip has no interrupts, or only the other direction",
                          where, "take another line");
    default:
      break;
  }
  return system_error("the line cannot " + verb + ": " + std::strerror(refusal), where,
                      "look at what it is wired for with: gpioinfo");
}

}  // namespace rigcal::trigger
