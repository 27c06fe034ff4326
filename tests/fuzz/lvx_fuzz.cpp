// An .lvx file of any bytes: no crash, no hang, and every package that is delivered is a whole packet of a listed
// device, of a length that the codec knows.
#include "core/io/lvx_reader.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/fuzz/scratch_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ScratchFile file(bytes, size);
  rigcal::Expected<rigcal::LvxReader> reader = rigcal::LvxReader::open(file.path());
  if (!reader) return 0;
  std::uint64_t delivered = 0;
  for (rigcal::LvxPackage package; reader->next(package); delivered += package.packet.size()) {
    if (package.device >= reader->devices().size()) __builtin_trap();
    const auto type = static_cast<rigcal::livox::DataType>(package.packet[9]);
    if (package.packet.size() != rigcal::livox::packet_bytes(type)) __builtin_trap();
  }
  if (delivered > size) __builtin_trap();
  return 0;
}
