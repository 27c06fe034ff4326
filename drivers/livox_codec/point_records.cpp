#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/livox_codec/sample_header.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::livox {
namespace {

constexpr float millimetre = 0.001F;
constexpr std::uint32_t max_zenith = 18000;  // 0.01 degrees.
constexpr std::uint32_t max_azimuth = 36000;

struct SinCos {
  float sin;
  float cos;
};

/// Sine and cosine of every angle that a record can hold: 288 kB, of which a sweep touches neighbours only.
const std::vector<SinCos>& sin_cos_table() {
  static const std::vector<SinCos> table = [] {
    std::vector<SinCos> values(max_azimuth + 1);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double angle = static_cast<double>(i) * std::numbers::pi / 18000.0;
      values[i] = {static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle))};
    }
    return values;
  }();
  return table;
}

template <class T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

// The readers below write each slot's point to `out` and step on only where there is a return: a branch would be
// guessed wrong at every second edge of the scene.

template <bool kTagged>
Point* read_cartesian(const std::uint8_t* record, std::uint16_t shot, Point* out) {
  const auto x = load<std::int32_t>(record);
  const auto y = load<std::int32_t>(record + 4);
  const auto z = load<std::int32_t>(record + 8);
  // Divided, not multiplied by 0.001F: that is the float nearest to the millimetres, which other readers give too.
  *out = {static_cast<float>(x) / 1000.0F,        static_cast<float>(y) / 1000.0F,
          static_cast<float>(z) / 1000.0F,        record[12],
          kTagged ? record[13] : std::uint8_t{0}, shot};
  return out + ((x | y | z) != 0 ? 1 : 0);
}

template <std::size_t kEchoes, bool kTagged>
std::size_t decode_cartesian(const std::uint8_t* record, std::size_t slots, Point* out) {
  Point* end = out;
  for (std::size_t shot = 0; shot < slots; ++shot) {
    for (std::size_t echo = 0; echo < kEchoes; ++echo) {
      end = read_cartesian<kTagged>(record, static_cast<std::uint16_t>(shot), end);
      record += kTagged ? 14 : 13;
    }
  }
  return static_cast<std::size_t>(end - out);
}

struct Direction {
  float x;
  float y;
  float z;
  bool possible;
};

Direction direction(const SinCos* table, std::uint32_t zenith, std::uint32_t azimuth) {
  const SinCos elevation = table[std::min(zenith, max_zenith)];
  const SinCos heading = table[std::min(azimuth, max_azimuth)];
  return {elevation.sin * heading.cos, elevation.sin * heading.sin, elevation.cos,
          zenith <= max_zenith && azimuth <= max_azimuth};
}

Point* put_polar(const Direction& way, std::uint32_t depth_mm, std::uint8_t reflectivity, std::uint8_t tag,
                 std::uint16_t shot, Point* out) {
  const float depth = static_cast<float>(depth_mm) * millimetre;
  *out = {depth * way.x, depth * way.y, depth * way.z, reflectivity, tag, shot};
  return out + ((depth_mm != 0 && way.possible) ? 1 : 0);
}

template <bool kTagged>
std::size_t decode_spherical(const std::uint8_t* record, std::size_t slots, Point* out) {
  const SinCos* table = sin_cos_table().data();
  Point* end = out;
  for (std::size_t shot = 0; shot < slots; ++shot) {
    const Direction way = direction(table, load<std::uint16_t>(record + 4), load<std::uint16_t>(record + 6));
    end = put_polar(way, load<std::uint32_t>(record), record[8], kTagged ? record[9] : std::uint8_t{0},
                    static_cast<std::uint16_t>(shot), end);
    record += kTagged ? 10 : 9;
  }
  return static_cast<std::size_t>(end - out);
}

/// Dual and triple returns: the angles come first, then depth, reflectivity and tag of each echo.
template <std::size_t kEchoes>
std::size_t decode_spherical_echoes(const std::uint8_t* record, std::size_t slots, Point* out) {
  const SinCos* table = sin_cos_table().data();
  Point* end = out;
  for (std::size_t shot = 0; shot < slots; ++shot) {
    const Direction way = direction(table, load<std::uint16_t>(record), load<std::uint16_t>(record + 2));
    record += 4;
    for (std::size_t echo = 0; echo < kEchoes; ++echo) {
      end = put_polar(way, load<std::uint32_t>(record), record[4], record[5], static_cast<std::uint16_t>(shot), end);
      record += 6;
    }
  }
  return static_cast<std::size_t>(end - out);
}

std::int32_t to_millimetres(float metres) {
  RIGCAL_ASSERT(std::abs(metres) < 2.0e6F, "a coordinate that no packet can hold: " + std::to_string(metres));
  return static_cast<std::int32_t>(std::lround(static_cast<double>(metres) * 1000.0));
}

struct Polar {
  std::uint32_t depth_mm;
  std::uint16_t zenith;
  std::uint16_t azimuth;
};

Polar to_polar(const Point& point) {
  const double x = point.x;
  const double y = point.y;
  const double z = point.z;
  const double depth = std::sqrt(x * x + y * y + z * z);
  RIGCAL_ASSERT(depth < 4.0e6, "a depth that no packet can hold: " + std::to_string(depth));
  if (depth == 0.0) return {0, 0, 0};
  constexpr double per_radian = 18000.0 / std::numbers::pi;
  const long zenith = std::lround(std::atan2(std::sqrt(x * x + y * y), z) * per_radian);
  const long azimuth = std::lround(std::atan2(y, x) * per_radian);  // -18000 .. 18000
  return {static_cast<std::uint32_t>(std::lround(depth * 1000.0)), static_cast<std::uint16_t>(zenith),
          static_cast<std::uint16_t>(azimuth < 0 ? azimuth + 36000 : azimuth)};
}

template <class T>
void store(T value, std::uint8_t* bytes) {
  std::memcpy(bytes, &value, sizeof(T));
}

void write_cartesian(const Point& point, bool tagged, std::uint8_t* record) {
  store(to_millimetres(point.x), record);
  store(to_millimetres(point.y), record + 4);
  store(to_millimetres(point.z), record + 8);
  record[12] = point.reflectivity;
  if (tagged) record[13] = point.tag;
}

void write_spherical(const Point& point, bool tagged, std::uint8_t* record) {
  const Polar polar = to_polar(point);
  store(polar.depth_mm, record);
  store(polar.zenith, record + 4);
  store(polar.azimuth, record + 6);
  record[8] = point.reflectivity;
  if (tagged) record[9] = point.tag;
}

void write_spherical_echo(const Point& point, std::size_t echo, std::uint8_t* slot) {
  const Polar polar = to_polar(point);
  if (echo == 0) {
    store(polar.zenith, slot);
    store(polar.azimuth, slot + 2);
  }
  std::uint8_t* record = slot + 4 + 6 * echo;
  store(polar.depth_mm, record);
  record[4] = point.reflectivity;
  record[5] = point.tag;
}

}  // namespace

void decode_points(const SamplePacket& packet, std::vector<Point>& points) {
  const DataType type = packet.header.data_type;
  const RecordLayout& layout = record_layout(type);
  RIGCAL_ASSERT(type != DataType::imu && packet.records.size() == packet_bytes(type) - kSampleHeaderBytes,
                "not a packet that parse_sample_packet has given");
  points.resize(std::size_t{layout.slots} * layout.echoes);
  const std::uint8_t* records = packet.records.data();
  const std::size_t slots = layout.slots;
  std::size_t count = 0;
  switch (type) {
    case DataType::cartesian:
      count = decode_cartesian<1, false>(records, slots, points.data());
      break;
    case DataType::spherical:
      count = decode_spherical<false>(records, slots, points.data());
      break;
    case DataType::cartesian_tagged:
      count = decode_cartesian<1, true>(records, slots, points.data());
      break;
    case DataType::spherical_tagged:
      count = decode_spherical<true>(records, slots, points.data());
      break;
    case DataType::dual_cartesian:
      count = decode_cartesian<2, true>(records, slots, points.data());
      break;
    case DataType::dual_spherical:
      count = decode_spherical_echoes<2>(records, slots, points.data());
      break;
    case DataType::triple_cartesian:
      count = decode_cartesian<3, true>(records, slots, points.data());
      break;
    case DataType::triple_spherical:
      count = decode_spherical_echoes<3>(records, slots, points.data());
      break;
    case DataType::imu:
      break;
  }
  points.resize(count);
}

void encode_points(const SampleHeader& header, std::span<const Point> points, std::vector<std::uint8_t>& bytes) {
  RIGCAL_ASSERT(header.data_type != DataType::imu, "points in an IMU packet");
  const RecordLayout& layout = record_layout(header.data_type);
  write_sample_header(header, bytes);
  bytes.resize(packet_bytes(header.data_type), 0);
  std::array<std::uint8_t, kMaxSlots> echoes{};
  for (const Point& point : points) {
    RIGCAL_ASSERT(point.shot < layout.slots && echoes[point.shot] < layout.echoes,
                  "no place for a point of shot " + std::to_string(point.shot));
    const std::size_t echo = echoes[point.shot]++;
    std::uint8_t* slot = bytes.data() + kSampleHeaderBytes + std::size_t{point.shot} * layout.slot_bytes;
    if (!layout.spherical) {
      write_cartesian(point, layout.tagged, slot + echo * (layout.slot_bytes / layout.echoes));
    } else if (layout.echoes == 1) {
      write_spherical(point, layout.tagged, slot);
    } else {
      write_spherical_echo(point, echo, slot);
    }
  }
}

}  // namespace rigcal::livox
