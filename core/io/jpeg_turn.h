#pragma once

#include "core/base/bytes.h"
#include "core/records/image.h"

namespace rigcal {

/// How the pixels of a JPEG file are to be turned before they are shown, by the orientation that its EXIF data tells
/// (tag 0x0112 of the first directory, EXIF 2.3): 1 as they are, 2 mirrored from left to right, 3 turned by 180
/// degrees, 4 mirrored from top to bottom, 5 rows and columns swapped, 6 turned by 90 degrees clockwise, 7 swapped and
/// turned by 180 degrees, 8 turned by 90 degrees the other way. 1 where nothing is told, or nonsense.
[[nodiscard]] int jpeg_orientation(ByteView file);

/// An image as it is to be shown by such an orientation; a consistent one.
[[nodiscard]] Image turned_upright(Image image, int orientation);

}  // namespace rigcal
