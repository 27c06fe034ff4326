#pragma once

#include <string_view>

#include "core/base/seconds.h"
#include "core/io/ros_messages.h"

/// What the deserialisers of messages share.
namespace rigcal {

inline Error message_is_cut() { return input_error("is cut, or of another layout than its type"); }

inline std::string_view read_ros_text(ByteReader& reader) {
  const ByteView text = reader.take(reader.read<std::uint32_t>());
  return {reinterpret_cast<const char*>(text.data()), text.size()};
}

inline RosHeader read_ros_header(ByteReader& reader) {
  RosHeader header;
  header.seq = reader.read<std::uint32_t>();
  const std::int64_t seconds = reader.read<std::uint32_t>();
  header.stamp_ns = seconds * ns_per_second + reader.read<std::uint32_t>();
  static_cast<void>(read_ros_text(reader));  // frame_id
  return header;
}

}  // namespace rigcal
