#include "drivers/camera/aravis/buffer_image.h"

#include <arv.h>

namespace rigcal::camera {

const std::uint8_t* image_data(ArvBuffer* buffer, std::size_t* size) {
#if ARAVIS_CHECK_VERSION(0, 8, 25)
  return static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, size));
#else
  return static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, size));
#endif
}

bool has_padded_rows([[maybe_unused]] ArvBuffer* buffer) {
#if ARAVIS_CHECK_VERSION(0, 8, 23)
  gint x = 0;
  gint y = 0;
  arv_buffer_get_image_padding(buffer, &x, &y);
  return x != 0;
#else
  return false;
#endif
}

}  // namespace rigcal::camera
