#include "simdata/live/device_time.h"

#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t soonest_ns = 10'000'000;
constexpr std::int64_t latest_ns = 500'000'000;
constexpr std::int64_t utc_lasts_ns = 3 * ns_per_second;
constexpr std::int64_t last_utc_ns = 8'990'000'000 * ns_per_second;  // The year on the wire ends with 2255.

}  // namespace

std::int64_t DeviceTime::since_pulse_ns(std::int64_t time_ns) const {
  const std::int64_t rest = (time_ns - options_.pulse_ns) % ns_per_second;
  return rest < 0 ? rest + ns_per_second : rest;
}

bool DeviceTime::set_utc(std::int64_t now_ns, std::int64_t unix_ns) {
  if (options_.source != TimeSource::pps) return true;
  const std::int64_t since_pulse = since_pulse_ns(now_ns);
  if (since_pulse < soonest_ns || since_pulse > latest_ns || unix_ns > last_utc_ns) return false;
  utc_offset_ns_ = unix_ns - (now_ns - since_pulse);
  utc_end_ns_ = now_ns + utc_lasts_ns;
  utc_lapsed_ = false;
  return true;
}

void DeviceTime::restart() {
  utc_end_ns_.reset();
  utc_lapsed_ = false;
}

void DeviceTime::tick(std::int64_t now_ns) {
  if (!utc_end_ns_ || now_ns < *utc_end_ns_) return;
  utc_end_ns_.reset();
  utc_lapsed_ = true;
}

livox::TimestampType DeviceTime::type() const {
  switch (options_.source) {
    case TimeSource::none:
      break;
    case TimeSource::pps:
      return utc_end_ns_ ? livox::TimestampType::gps : livox::TimestampType::pps_only;
    case TimeSource::ptp:
      return livox::TimestampType::ptp;
  }
  return livox::TimestampType::since_start;
}

std::int64_t DeviceTime::stamp_ns(std::int64_t time_ns) const {
  switch (type()) {
    case livox::TimestampType::pps_only:
      return since_pulse_ns(time_ns);
    case livox::TimestampType::gps:
      return time_ns + utc_offset_ns_;
    default:
      return time_ns + options_.utc_offset_ns;
  }
}

std::uint32_t DeviceTime::with_sync_bits(std::uint32_t status) const {
  if (options_.source == TimeSource::none) return status;
  livox::Status bits = livox::decode_status(status);
  bits.ptp_ok = options_.source == TimeSource::ptp;
  bits.pps_ok = options_.source == TimeSource::pps;
  bits.time_sync = bits.ptp_ok   ? livox::TimeSync::ptp
                   : utc_end_ns_ ? livox::TimeSync::gps
                   : utc_lapsed_ ? livox::TimeSync::abnormal  // The better source was there, and failed.
                                 : livox::TimeSync::pps;
  return livox::encode_status(bits);
}

}  // namespace rigcal::sim
