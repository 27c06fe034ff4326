#pragma once

#include "core/edges/image_edges.h"
#include "core/records/image.h"

namespace rigcal {

/// How many bits of an image's values carry what the camera measured: those that its pixel format names, 16 where a
/// value does not fit (drivers that shift to the left), and as few of 8, 10, 12, 14 and 16 as hold the largest value
/// where it names none, or 16 (in which drivers carry 10 to 14, too).
[[nodiscard]] int value_bits(const Image& image);

/// Whether its pixels lie behind a Bayer filter: so says the pixel format, and it has one channel only.
[[nodiscard]] bool is_mosaic(const Image& image);

/// Grey values 0 .. 255 of an image whose values have `bits` bits. A Bayer mosaic is weighted 1 2 1 along rows and
/// columns: everywhere a quarter red, half green, a quarter blue, so that no pattern of the filter is left and nothing
/// is moved. Colour becomes luma (BT.601). The image must be consistent.
[[nodiscard]] GreyImage to_grey(const Image& image, int bits);

/// The mean of each square of two by two pixels, so often after each other; a row or column that is left over at the
/// end is dropped.
[[nodiscard]] GreyImage halved(GreyImage grey, int times);

/// How much an image shows: the difference between its 1 % and 99 % grey values. A covered lens and one that looks into
/// the sun show next to none.
[[nodiscard]] float grey_spread(const GreyImage& grey);

}  // namespace rigcal
