#pragma once

#include <cstddef>
#include <cstdint>

struct _ArvBuffer;  // Aravis' own name.

namespace rigcal::camera {

/// The image in a buffer that came whole, and how many bytes are there. Before Aravis 0.8.25 (Ubuntu 22.04) that is the
/// buffer itself, whose image stands before its chunks.
[[nodiscard]] const std::uint8_t* image_data(_ArvBuffer* buffer, std::size_t* size);

/// Whether there is something between its rows, as far as Aravis tells (since 0.8.23).
[[nodiscard]] bool has_padded_rows(_ArvBuffer* buffer);

}  // namespace rigcal::camera
