// A rig file of any bytes: no crash, and what is accepted is accepted again after writing.
#include <string>

#include "core/rig/rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string text(bytes, bytes + size);
  const rigcal::Expected<rigcal::Rig> rig = rigcal::parse_rig(text, "rig.yaml");
  if (!rig) return 0;
  const rigcal::Expected<rigcal::Rig> again = rigcal::parse_rig(rigcal::write_rig(*rig), "again.yaml");
  if (!again || again->sensors.size() != rig->sensors.size() || again->base != rig->base) __builtin_trap();
  return 0;
}
