#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace rigcal {

/// The numbers that the messages of one stream have of the LiDAR whose points they are. Where LiDARs take turns in a
/// stream, numbers come back again and again; a driver that starts anew may count anew, and a number may be damaged.
class UnitNumbers {
 public:
  void add(int number) {
    ++messages_;
    if (messages_ > 1 && number != last_ && counts_.contains(number)) ++returns_;
    last_ = number;
    ++counts_[number];
  }
  [[nodiscard]] bool several() const { return returns_ > 1 && returns_ > rare * static_cast<double>(messages_); }
  /// "0, 1"
  [[nodiscard]] std::string text() const {
    std::string text;
    for (const auto& [number, count] : counts_) {
      if (static_cast<double>(count) < rare * static_cast<double>(messages_)) continue;
      text += (text.empty() ? "" : ", ") + std::to_string(number);
    }
    return text;
  }

 private:
  static constexpr double rare = 0.01;
  std::map<int, std::uint64_t> counts_;
  std::uint64_t messages_ = 0;
  std::uint64_t returns_ = 0;
  int last_ = 0;
};

}  // namespace rigcal
