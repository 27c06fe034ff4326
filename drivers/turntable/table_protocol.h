#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rigcal::turntable {

/// Farther from where it was to go, a table has not arrived.
inline constexpr double most_off_deg = 0.1;

/// What a table says.
struct TableNews {
  enum class Kind {
    angle,    ///< Where it is.
    arrived,  ///< It has done what it was told; `angle_deg` is where it is.
    failed,   ///< It refused, or stopped elsewhere; `text` says so.
  };
  Kind kind = Kind::angle;
  double angle_deg = 0.0;
  std::string text;
};

/// A host's talk with a table over a serial line: bytes and time in, bytes and news out; no port, no clock. Any bytes
/// are safe. Times are seconds of a clock that never goes back; angles are degrees as the table counts them.
class TableProtocol {
 public:
  TableProtocol() = default;
  TableProtocol(const TableProtocol&) = delete;
  TableProtocol& operator=(const TableProtocol&) = delete;
  virtual ~TableProtocol() = default;

  /// The line is open, for the first time or again; the table may just have restarted by that.
  virtual void open(double now_s) = 0;
  /// By so many degrees from where it was told to go last. While that goes on it is the same turn, told once more: the
  /// table ends where it was to end, not a step beyond.
  virtual void turn_by(double degrees, double now_s) = 0;
  virtual void receive(std::string_view bytes, double now_s) = 0;
  /// To be called every tenth of a second or so: asks the table where it is.
  virtual void tick(double now_s) = 0;
  /// What is said at the end, to stop a motion that goes on.
  virtual void close() {}

  [[nodiscard]] std::string take_output() { return std::exchange(output_, {}); }
  [[nodiscard]] std::vector<TableNews> take_news() { return std::exchange(news_, {}); }

 protected:
  void say(std::string_view text) { output_ += text; }
  void tell(TableNews news) {
    if (news_.size() < most_news) news_.push_back(std::move(news));
  }

 private:
  static constexpr std::size_t most_news = 1000;
  std::string output_;
  std::vector<TableNews> news_;
};

}  // namespace rigcal::turntable
