#include "apps/capture/disk_watch.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace rigcal {
namespace {

constexpr double forgets_in_s = 10.0;  // Of the mean of the rate.

double growth(std::uint64_t before, std::uint64_t now) { return static_cast<double>(now - std::min(before, now)); }

}  // namespace

DiskRoom DiskForecast::add(double now_s, const SessionBytes& session, std::uint64_t free_bytes) {
  if (last_s_ >= 0.0 && now_s > last_s_) {
    const double passed_s = now_s - last_s_;
    const bool is_first = packets_per_s_ + images_per_s_ == 0.0;
    const double share = is_first ? 1.0 : std::min(1.0, passed_s / forgets_in_s);
    packets_per_s_ += share * (growth(last_.packets, session.packets) / passed_s - packets_per_s_);
    images_per_s_ += share * (growth(last_.images, session.images) / passed_s - images_per_s_);
  }
  last_s_ = now_s;
  last_ = session;
  const auto room = static_cast<double>(free_bytes - std::min(free_bytes, kReserveBytes));
  return {free_bytes, packets_per_s_ + images_per_s_, seconds_left(session.packets, room)};
}

std::optional<double> DiskForecast::seconds_left(std::uint64_t packets, double room) const {
  const double rate = packets_per_s_ + images_per_s_;
  if (rate < 1.0) return std::nullopt;
  const double all_grow_s = room / rate;
  if (keep_bytes_ == 0) return all_grow_s;
  // Once the packets take all that they may, only images grow.
  const double may_grow = growth(packets, keep_bytes_);
  if (packets_per_s_ * all_grow_s <= may_grow) return all_grow_s;
  if (images_per_s_ < 1.0) return std::nullopt;
  return (room - may_grow) / images_per_s_;
}

std::optional<std::uint64_t> free_bytes(const std::string& session) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(session, error);
  if (error || space.available == static_cast<std::uintmax_t>(-1)) return std::nullopt;
  return space.available;
}

std::optional<std::string> DiskWatch::look(double now_s, const SessionBytes& session, std::uint64_t free_bytes) {
  if (full_) return std::nullopt;
  room_ = forecast_.add(now_s, session, free_bytes);
  const std::string megabytes = std::to_string(free_bytes >> 20U) + " MiB";
  if (free_bytes < DiskForecast::kReserveBytes) {
    full_ = system_error("the disk is full but for " + megabytes + ": the capture was ended, and is whole so far",
                         session_, "make room or choose another disk");
    return std::nullopt;
  }
  if (has_warned_ || !room_->seconds_left || *room_->seconds_left >= kWarningS) return std::nullopt;
  has_warned_ = true;
  return "the disk will be full in about " + std::to_string(std::lround(*room_->seconds_left)) + " s (" + megabytes +
         " free)";
}

}  // namespace rigcal
