// What a table may send over a serial line, and wishes of a user between: no crash, bounded output, angles that are
// numbers.
#include <cmath>
#include <cstdint>
#include <string>

#include "drivers/turntable/ascii_protocol.h"
#include "drivers/turntable/grbl_protocol.h"

namespace {

void walk(rigcal::turntable::TableProtocol& table, const std::string& text) {
  double now_s = 0.0;
  table.open(now_s);
  for (std::size_t i = 0; i < text.size(); i += 8) {
    const std::string part = text.substr(i, 8);
    if (part.front() % 8 == 1) table.turn_by(18.0, now_s);
    if (part.front() % 8 == 2) now_s += 1.0;
    table.receive(part, now_s);
    table.tick(now_s);
    if (table.take_output().size() > 1000) __builtin_trap();
    for (const auto& news : table.take_news())
      if (!(std::abs(news.angle_deg) <= 2e6)) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(bytes, bytes + size);
  rigcal::turntable::GrblProtocol grbl({'A', 10.0});
  walk(grbl, text);
  rigcal::turntable::AsciiProtocol plain({});
  walk(plain, text);
  rigcal::turntable::AsciiOptions words;
  words.ask = "";
  words.done = "OK";
  rigcal::turntable::AsciiProtocol own(words);
  walk(own, text);
  return 0;
}
