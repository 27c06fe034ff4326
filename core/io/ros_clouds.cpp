#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "core/io/point_values.h"
#include "core/io/ros_messages.h"
#include "core/io/ros_reader.h"

namespace rigcal {
namespace {

constexpr std::size_t livox_point_bytes = 19;
constexpr std::size_t most_fields = 256;

/// A field of a PointCloud2.
struct Field {
  std::string_view name;
  std::uint32_t offset = 0;
  char type = 'F';
  std::size_t size = 0;  ///< 0: a datatype that the definition does not know.
};

Field make_field(std::string_view name, std::uint32_t offset, std::uint8_t datatype) {
  constexpr std::array<std::size_t, 9> sizes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  constexpr std::string_view types = " IUIUIUFF";
  if (datatype >= sizes.size()) return {name, offset, 'F', 0};
  return {name, offset, types[datatype], sizes[datatype]};
}

struct CloudLayout {
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::vector<Field> fields;
  bool big_endian = false;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  ByteView data;

  [[nodiscard]] const Field* find(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names) {
      const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
      if (found != fields.end()) return &*found;
    }
    return nullptr;
  }
};

Expected<CloudLayout> read_layout(ByteReader& reader) {
  CloudLayout layout;
  layout.height = reader.read<std::uint32_t>();
  layout.width = reader.read<std::uint32_t>();
  const auto count = reader.read<std::uint32_t>();
  if (!reader.ok()) return message_is_cut();
  if (count > most_fields) return input_error("has " + std::to_string(count) + " fields");
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string_view name = read_ros_text(reader);
    const auto offset = reader.read<std::uint32_t>();
    const auto datatype = reader.read<std::uint8_t>();
    static_cast<void>(reader.read<std::uint32_t>());  // how many; the first is used
    layout.fields.push_back(make_field(name, offset, datatype));
  }
  layout.big_endian = reader.read<std::uint8_t>() != 0;
  layout.point_step = reader.read<std::uint32_t>();
  layout.row_step = reader.read<std::uint32_t>();
  layout.data = reader.take(reader.read<std::uint32_t>());
  if (!reader.ok()) return message_is_cut();
  const std::uint64_t row = std::uint64_t{layout.width} * layout.point_step;
  if (layout.height == 1) layout.row_step = static_cast<std::uint32_t>(std::min<std::uint64_t>(row, UINT32_MAX));
  if (row > layout.row_step || std::uint64_t{layout.row_step} * layout.height > layout.data.size()) {
    return input_error("has fewer bytes than its width, height and steps need");
  }
  if (row == 0) layout.height = 0;  // billions of rows without a point would take as long as if they had some
  for (const Field& field : layout.fields) {
    if (field.size > 0 && std::uint64_t{field.offset} + field.size > layout.point_step) {
      return input_error("has a field that reaches out of its point");
    }
  }
  return layout;
}

class CloudDecoder {
 public:
  explicit CloudDecoder(const CloudLayout& layout)
      : layout_(layout),
        x_(layout.find({"x"})),
        y_(layout.find({"y"})),
        z_(layout.find({"z"})),
        reflectivity_(layout.find({"reflectivity", "intensity"})),
        tag_(layout.find({"tag"})),
        time_(layout.find({"offset_time", "t", "time", "timestamp"})) {}

  Expected<void> decode(RosCloud& cloud) const {
    for (const Field* field : {x_, y_, z_}) {
      if (field == nullptr || field->type != 'F' || field->size == 0)
        return input_error("has no fields x, y and z of floats");
    }
    for (const Field* field : {reflectivity_, tag_, time_}) {
      if (field != nullptr && field->size == 0) return input_error("has a field of an unknown type");
    }
    cloud.shots = std::uint64_t{layout_.width} * layout_.height;
    std::vector<double> told;
    for (std::uint32_t row = 0; row < layout_.height; ++row) {
      const std::uint8_t* at = layout_.data.data() + std::size_t{row} * layout_.row_step;
      for (std::uint32_t i = 0; i < layout_.width; ++i, at += layout_.point_step) add(at, cloud, told);
    }
    set_times(told, cloud);
    return {};
  }

 private:
  [[nodiscard]] double value(const std::uint8_t* point, const Field& field) const {
    if (!layout_.big_endian) return load_value(point + field.offset, field.type, field.size);
    std::array<std::uint8_t, 8> turned{};
    std::reverse_copy(point + field.offset, point + field.offset + field.size, turned.begin());
    return load_value(turned.data(), field.type, field.size);
  }

  void add(const std::uint8_t* at, RosCloud& cloud, std::vector<double>& told) const {
    Point point;
    point.x = to_float(value(at, *x_));
    point.y = to_float(value(at, *y_));
    point.z = to_float(value(at, *z_));
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) {
      ++cloud.not_finite;
      return;
    }
    if (point.x == 0.0F && point.y == 0.0F && point.z == 0.0F) {
      ++cloud.at_origin;
      return;
    }
    if (reflectivity_ != nullptr) {
      const double intensity = value(at, *reflectivity_);
      cloud.intensity.add(intensity);
      point.reflectivity = rounded<std::uint8_t>(intensity);
    }
    if (tag_ != nullptr) point.tag = rounded<std::uint8_t>(value(at, *tag_));
    cloud.points.push_back(point);
    if (time_ != nullptr) told.push_back(value(at, *time_));
  }

  // All points of a cloud count alike, so what they count is told by all of them. None has times where one has none
  // that a clock could show.
  void set_times(const std::vector<double>& told, RosCloud& cloud) const {
    if (told.empty()) return;
    const auto [first, last] = std::minmax_element(told.begin(), told.end());
    const double largest = std::max(std::abs(*first), std::abs(*last));
    const bool ns = time_->type != 'F' || (time_->size == 8 && counts_ns(*last - *first, largest));
    const double unit = ns ? 1.0 : 1e9;
    constexpr double latest_ns = 9e18;
    if (!std::all_of(told.begin(), told.end(), [&](double time) { return std::abs(time) * unit < latest_ns; })) return;
    // A cloud's stamp is of its first point, or of its last; what is farther from it is the time of some clock.
    constexpr double longest_after_ns = 10e9;
    const std::int64_t from_ns = largest * unit <= longest_after_ns ? cloud.header.stamp_ns : 0;
    for (const double time : told) cloud.times_ns.push_back(from_ns + static_cast<std::int64_t>(time * unit));
  }

  // Seconds since 1970 have ten digits, and no cloud takes two seconds and more.
  static bool counts_ns(double span, double largest) { return largest > 1e10 || span > 2.0; }

  const CloudLayout& layout_;
  const Field* x_;
  const Field* y_;
  const Field* z_;
  const Field* reflectivity_;
  const Field* tag_;
  const Field* time_;
};

Expected<void> decode_livox_points(ByteReader& reader, RosCloud& cloud) {
  const auto timebase = reader.read<std::uint64_t>();
  static_cast<void>(reader.read<std::uint32_t>());  // how many; it stands before them again
  cloud.lidar_id = reader.read<std::uint8_t>();
  constexpr std::size_t reserved = 3;
  static_cast<void>(reader.take(reserved));
  const auto count = reader.read<std::uint32_t>();
  if (!reader.ok() || reader.left() < count * livox_point_bytes) return message_is_cut();
  const bool has_base = timebase > 0 && timebase < 9'000'000'000'000'000'000U;
  const std::int64_t base_ns = has_base ? static_cast<std::int64_t>(timebase) : cloud.header.stamp_ns;
  cloud.shots = count;
  cloud.points.reserve(count);
  cloud.times_ns.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto offset_ns = reader.read<std::uint32_t>();
    Point point;
    point.x = reader.read<float>();
    point.y = reader.read<float>();
    point.z = reader.read<float>();
    point.reflectivity = reader.read<std::uint8_t>();
    point.tag = reader.read<std::uint8_t>();
    static_cast<void>(reader.read<std::uint8_t>());  // line
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) {
      ++cloud.not_finite;
    } else if (point.x == 0.0F && point.y == 0.0F && point.z == 0.0F) {
      ++cloud.at_origin;
    } else {
      cloud.points.push_back(point);
      cloud.times_ns.push_back(base_ns + offset_ns);
    }
  }
  return {};
}

}  // namespace

Expected<void> decode_cloud(RosType type, ByteView message, RosCloud& cloud) {
  cloud.points.clear();
  cloud.times_ns.clear();
  cloud.shots = cloud.not_finite = cloud.at_origin = 0;
  cloud.lidar_id = 0;
  cloud.intensity = {};
  ByteReader reader(message);
  cloud.header = read_ros_header(reader);
  if (type == RosType::livox_points) return decode_livox_points(reader, cloud);
  const Expected<CloudLayout> layout = read_layout(reader);
  if (!layout) return layout.error();
  return CloudDecoder(*layout).decode(cloud);
}

}  // namespace rigcal
