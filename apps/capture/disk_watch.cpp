#include "apps/capture/disk_watch.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace rigcal {
namespace {

constexpr double forgets_in_s = 10.0;  // Of the mean of the rate.

}  // namespace

DiskRoom DiskForecast::add(double now_s, std::uint64_t session_bytes, std::uint64_t free_bytes) {
  if (last_s_ >= 0.0 && now_s > last_s_) {
    const double grown = static_cast<double>(session_bytes - std::min(last_bytes_, session_bytes));
    const double rate = grown / (now_s - last_s_);
    const double share = bytes_per_s_ == 0.0 ? 1.0 : std::min(1.0, (now_s - last_s_) / forgets_in_s);
    bytes_per_s_ += share * (rate - bytes_per_s_);
  }
  last_s_ = now_s;
  last_bytes_ = session_bytes;
  DiskRoom room{free_bytes, bytes_per_s_, std::nullopt};
  if (bytes_per_s_ >= 1.0)
    room.seconds_left = static_cast<double>(free_bytes - std::min(free_bytes, kReserveBytes)) / bytes_per_s_;
  return room;
}

std::optional<std::uint64_t> free_bytes(const std::string& session) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(session, error);
  if (error || space.available == static_cast<std::uintmax_t>(-1)) return std::nullopt;
  return space.available;
}

std::optional<std::string> DiskWatch::look(double now_s, std::uint64_t session_bytes, std::uint64_t free_bytes) {
  if (full_) return std::nullopt;
  room_ = forecast_.add(now_s, session_bytes, free_bytes);
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
