#include "drivers/livox_codec/status.h"

namespace rigcal::livox {
namespace {

std::uint32_t bits(std::uint32_t word, unsigned lowest, unsigned count) {
  return (word >> lowest) & ((1U << count) - 1U);
}

Level level(std::uint32_t word, unsigned lowest) { return static_cast<Level>(bits(word, lowest, 2)); }

/// Puts fields of bits into a word.
struct WordBuilder {
  std::uint32_t word = 0;

  template <class Value>
  void put(Value value, unsigned lowest, unsigned count) {
    word |= bits(static_cast<std::uint32_t>(value), 0, count) << lowest;
  }
};

}  // namespace

std::string sync_text(const Status& status) {
  switch (status.time_sync) {
    case TimeSync::not_started:
      break;
    case TimeSync::ptp:
      return "synchronised by PTP";
    case TimeSync::gps:
      return "synchronised by pulses and the time of day (GPS)";
    case TimeSync::pps:
      return "synchronised by pulses (PPS), without the time of day";
    case TimeSync::abnormal:
      return "its synchronisation has failed";
  }
  if (status.ptp_ok) return "not synchronised, although it hears a PTP master";
  if (status.pps_ok) return "not synchronised, although it has pulses (PPS)";
  return "not synchronised";
}

Status decode_status(std::uint32_t word) {
  Status status;
  status.temperature = level(word, 0);
  status.voltage = level(word, 2);
  status.motor = level(word, 4);
  status.dirty = static_cast<std::uint8_t>(bits(word, 6, 2));
  status.firmware_abnormal = bits(word, 8, 1) != 0;
  status.pps_ok = bits(word, 9, 1) != 0;
  status.near_end_of_life = bits(word, 10, 1) != 0;
  status.fan_warning = bits(word, 11, 1) != 0;
  status.self_heating_bit = bits(word, 12, 1) != 0;
  status.ptp_ok = bits(word, 13, 1) != 0;
  status.time_sync = static_cast<TimeSync>(bits(word, 14, 3));
  status.reserved = static_cast<std::uint16_t>(bits(word, 17, 13));
  status.system = level(word, 30);
  return status;
}

std::uint32_t encode_status(const Status& status) {
  WordBuilder builder;
  builder.put(status.temperature, 0, 2);
  builder.put(status.voltage, 2, 2);
  builder.put(status.motor, 4, 2);
  builder.put(status.dirty, 6, 2);
  builder.put(status.firmware_abnormal, 8, 1);
  builder.put(status.pps_ok, 9, 1);
  builder.put(status.near_end_of_life, 10, 1);
  builder.put(status.fan_warning, 11, 1);
  builder.put(status.self_heating_bit, 12, 1);
  builder.put(status.ptp_ok, 13, 1);
  builder.put(status.time_sync, 14, 3);
  builder.put(status.reserved, 17, 13);
  builder.put(status.system, 30, 2);
  return builder.word;
}

HubStatus decode_hub_status(std::uint32_t word) {
  HubStatus status;
  status.time_sync = static_cast<std::uint8_t>(bits(word, 0, 2));
  status.temperature = level(word, 2);
  status.lidar_abnormal = bits(word, 4, 1) != 0;
  status.lidar_link_changed = bits(word, 5, 1) != 0;
  status.lidar_firmware_abnormal = bits(word, 6, 1) != 0;
  status.reserved = bits(word, 7, 23);
  status.system = level(word, 30);
  return status;
}

std::uint32_t encode_hub_status(const HubStatus& status) {
  WordBuilder builder;
  builder.put(status.time_sync, 0, 2);
  builder.put(status.temperature, 2, 2);
  builder.put(status.lidar_abnormal, 4, 1);
  builder.put(status.lidar_link_changed, 5, 1);
  builder.put(status.lidar_firmware_abnormal, 6, 1);
  builder.put(status.reserved, 7, 23);
  builder.put(status.system, 30, 2);
  return builder.word;
}

}  // namespace rigcal::livox
