#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/io/lvx_reader.h"
#include "tests/support/files.h"

namespace rigcal {

/// Builds an .lvx file from the vendor's description of the format, frame by frame.
class LvxBuilder {
 public:
  LvxBuilder(int minor, const std::vector<LvxDevice>& devices) : minor_(minor), out_(bytes_) {
    out_.write_text("livox_tech", 16);
    for (const int part : {1, minor, 0, 0}) out_.write(static_cast<std::uint8_t>(part));
    out_.write(std::uint32_t{0xAC0EA767});
    if (minor == 1) out_.write(std::uint32_t{50});
    out_.write(static_cast<std::uint8_t>(devices.size()));
    for (const LvxDevice& device : devices) {
      out_.write_text(device.broadcast_code, 16);
      out_.write_text("HUB", 16);
      out_.write(device.index);
      out_.write(device.type);
      if (minor == 1) out_.write(static_cast<std::uint8_t>(device.has_extrinsics ? 1 : 0));
      for (const float value : device.roll_pitch_yaw_deg) out_.write(value);
      for (const float value : device.translation_m) out_.write(value);
    }
  }

  /// `packet` as on the wire; for version 1.0 of data type 0, whose millimetres are written as floats in metres.
  void add_package(std::uint8_t device, ByteView packet) {
    packages_.push_back(device);
    const std::size_t start = packages_.size();
    packages_.insert(packages_.end(), packet.begin(), packet.end());
    ++count_;
    if (minor_ == 1) return;
    for (std::size_t at = start + 18; at + 13 <= packages_.size(); at += 13) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::int32_t whole = 0;
        std::memcpy(&whole, packages_.data() + at + 4 * axis, sizeof(whole));
        const float metres = static_cast<float>(whole) / 1000.0F;
        std::memcpy(packages_.data() + at + 4 * axis, &metres, sizeof(metres));
      }
    }
  }

  void end_frame() {
    const std::uint64_t start = bytes_.size();
    const std::uint64_t head = minor_ == 0 ? 32 : 24;
    out_.write(start);
    out_.write(start + head + packages_.size());
    out_.write(frames_++);
    if (minor_ == 0) out_.write(count_);
    out_.write_bytes(packages_);
    packages_.clear();
    count_ = 0;
  }

  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  void save(const std::string& path) const { save_bytes(path, bytes_); }

 private:
  int minor_;
  std::vector<std::uint8_t> bytes_;
  ByteWriter out_;
  std::vector<std::uint8_t> packages_;
  std::uint64_t frames_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace rigcal
