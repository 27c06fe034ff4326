#pragma once

#include <optional>
#include <string>

#include "core/io/png_file.h"
#include "core/io/ros_messages.h"
#include "core/records/image.h"

namespace rigcal {

/// The pixels of a raw image as its message holds them; nothing where the encoding is not known.
[[nodiscard]] std::optional<PixelView> pixels_of(const RosImage& image);

/// The Bayer layout that its encoding names, as the rig file calls it ("BayerRG8"); empty: none, or a compressed image
/// that had been turned into grey or colours.
[[nodiscard]] std::string bayer_format(const RosImage& image);

/// An image of a message, raw or compressed, as values; `pixel_format` where the encoding names a Bayer layout. Errors
/// without a place: an encoding that is not known, sizes that contradict each other, a damaged file inside.
[[nodiscard]] Expected<Image> image_of(RosType type, const RosImage& image);

}  // namespace rigcal
