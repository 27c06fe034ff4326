#include "drivers/gige_codec/pixel_code.h"

#include <array>
#include <utility>

namespace rigcal::gige {
namespace {

constexpr std::array<std::pair<std::string_view, std::uint32_t>, 25> codes{{
    {"Mono8", 0x01080001},     {"Mono10", 0x01100003},    {"Mono12", 0x01100005},    {"Mono14", 0x01100025},
    {"Mono16", 0x01100007},    {"BayerGR8", 0x01080008},  {"BayerRG8", 0x01080009},  {"BayerGB8", 0x0108000A},
    {"BayerBG8", 0x0108000B},  {"BayerGR10", 0x0110000C}, {"BayerRG10", 0x0110000D}, {"BayerGB10", 0x0110000E},
    {"BayerBG10", 0x0110000F}, {"BayerGR12", 0x01100010}, {"BayerRG12", 0x01100011}, {"BayerGB12", 0x01100012},
    {"BayerBG12", 0x01100013}, {"BayerGR16", 0x0110002E}, {"BayerRG16", 0x0110002F}, {"BayerGB16", 0x01100030},
    {"BayerBG16", 0x01100031}, {"RGB8", 0x02180014},      {"BGR8", 0x02180015},      {"RGB16", 0x02300033},
    {"BGR16", 0x0230004B},
}};

}  // namespace

std::optional<std::uint32_t> pixel_code(std::string_view name) {
  for (const auto& [known, code] : codes) {
    if (known == name) return code;
  }
  return std::nullopt;
}

std::string_view pixel_name(std::uint32_t code) {
  for (const auto& [name, known] : codes) {
    if (known == code) return name;
  }
  return {};
}

}  // namespace rigcal::gige
