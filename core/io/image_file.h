#pragma once

#include <string>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/records/image.h"

namespace rigcal {

/// Reads a PNG or JPEG file (told by its first bytes, not its name): grey or colour, 8 or 16 bits as they are;
/// opacity is left out. A JPEG is turned as its EXIF data say, as viewers and OpenCV do. `pixel_format` stays empty.
/// Errors (kind input): missing, another kind of file, colours of ink, damaged or cut short, more than 65535 pixels
/// along a side or 100 million in all.
[[nodiscard]] Expected<Image> read_image(const std::string& path);
/// The same from a file's bytes; `name` stands for the file in errors.
[[nodiscard]] Expected<Image> decode_image(ByteView file, const std::string& name);

/// Writes a PNG file without loss. Errors: an image whose sizes contradict each other (kind input), the disk (system).
Expected<void> write_image(const std::string& path, const Image& image);

}  // namespace rigcal
