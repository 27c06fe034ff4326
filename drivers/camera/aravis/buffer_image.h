#pragma once

#include <arv.h>

#include <cstddef>
#include <cstdint>

namespace rigcal::camera {

/// The image in a buffer that came whole, and how many bytes are there. Before Aravis 0.8.25 (Ubuntu 22.04) that is the
/// buffer itself, whose image stands before its chunks.
inline const std::uint8_t* image_data(ArvBuffer* buffer, std::size_t* size) {
#if ARAVIS_CHECK_VERSION(0, 8, 25)
  return static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, size));
#else
  return static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, size));
#endif
}

/// Whether there is something between its rows, as far as Aravis tells (since 0.8.23).
inline bool has_padded_rows(ArvBuffer* buffer) {
#if ARAVIS_CHECK_VERSION(0, 8, 23)
  gint x = 0;
  gint y = 0;
  arv_buffer_get_image_padding(buffer, &x, &y);
  return x != 0;
#else
  static_cast<void>(buffer);
  return false;
#endif
}

}  // namespace rigcal::camera
