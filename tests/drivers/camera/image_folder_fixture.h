#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/frame_files.h"
#include "core/io/image_file.h"

namespace rigcal::camera {

/// An image of which each pixel tells where it lies and which image it is.
inline Image numbered_image(int number, int width = 64, int height = 48) {
  Image image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.bytes.push_back(static_cast<std::uint8_t>(x + 3 * y + 5 * number));
  }
  return image;
}

/// A camera's folder of a session: images a period apart with their frames.csv.
inline void write_camera_folder(const std::filesystem::path& folder, int images, std::int64_t period_ns) {
  std::filesystem::create_directories(folder);
  std::vector<FrameRecord> records;
  for (int i = 0; i < images; ++i) {
    FrameRecord record;
    record.file = std::to_string(i) + ".png";
    record.stamp_ns = 1'700'000'000'000'000'000 + i * period_ns;
    record.exposure_us = 1500.0;
    ASSERT_TRUE(write_image((folder / record.file).string(), numbered_image(i)).has_value());
    records.push_back(std::move(record));
  }
  ASSERT_TRUE(write_frames((folder / "frames.csv").string(), records).has_value());
}

}  // namespace rigcal::camera
