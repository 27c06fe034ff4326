#pragma once

#include <cstdint>

namespace rigcal {

/// Receive stamps of a recording whose machine may have set its clock back (by NTP, or by hand): from there on what is
/// missing is added to them, so that time goes on. Frames up to a second out of order, as several interfaces give them,
/// are left as they are, and so are single ones that lie farther off: only five in a row that agree are a clock that
/// was set. Two clocks that write into one recording by turns are told apart, and either goes on by its own.
class OnwardTime {
 public:
  /// The stamp as it is to be used. `place`: where in the recording it stands. Any values are safe.
  [[nodiscard]] std::int64_t add(std::int64_t stamp_ns, std::uint64_t place);

  [[nodiscard]] int steps() const { return steps_; }                             ///< Times the clock was set back,
  [[nodiscard]] std::int64_t first_step_ns() const { return first_step_ns_; }    ///< the first time by so much (> 0),
  [[nodiscard]] std::uint64_t first_step_place() const { return first_place_; }  ///< there.

 private:
  [[nodiscard]] bool is_near(std::int64_t time_ns) const;
  void confirm(std::int64_t time_ns);

  bool started_ = false;
  std::int64_t newest_ns_ = 0;  ///< As used.
  std::int64_t added_ns_ = 0;
  std::int64_t other_added_ns_ = 0;  ///< What was added before.
  int strays_ = 0;                   ///< In a row,
  std::int64_t first_stray_ns_ = 0;  ///< the first of them, as it would be used,
  std::int64_t last_stray_ns_ = 0;
  std::uint64_t stray_place_ = 0;
  int steps_ = 0;
  std::int64_t first_step_ns_ = 0;
  std::uint64_t first_place_ = 0;
};

}  // namespace rigcal
