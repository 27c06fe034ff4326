// An image file of any bytes: no crash, and what is accepted is consistent.
#include "core/io/image_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::Expected<rigcal::Image> image = rigcal::decode_image({bytes, size}, "image");
  if (image && !image->is_consistent()) __builtin_trap();
  return 0;
}
