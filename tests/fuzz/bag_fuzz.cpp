// A bag of any bytes: no crash, no hang, every message can be read.
#include "core/io/bag_reader.h"
#include "tests/fuzz/scratch_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ScratchFile file(bytes, size);
  rigcal::Expected<rigcal::BagReader> bag = rigcal::BagReader::open(file.path());
  if (!bag) return 0;
  for (rigcal::BagMessage message;;) {
    const rigcal::Expected<bool> more = bag->next(message);
    if (!more || !*more) break;
    unsigned sum = static_cast<unsigned>(message.connection->topic.size());
    for (const std::uint8_t byte : message.bytes) sum ^= byte;
    if (sum > 0xFFFFFFU) __builtin_trap();  // so that every byte has to be read
  }
  static_cast<void>(bag->truncation());
  return 0;
}
