#pragma once

#include <limits>
#include <optional>

#include "core/stops/creep_turn.h"

namespace rigcal {

/// Hands on the stops of a gyro, but ends a stop where the points show that the rig left its place although the gyro
/// saw nothing: creep that looks like a change of bias, or a slow push. What comes after it in that stop is left out;
/// where the rig left within the first half second, what came before it is, and the stop begins there. Verdicts on rest
/// are held back by half a second, in which the points' come in, and the first one by what a stop needs. How far the
/// rig crept in what is left out is put before the turn that follows.
class CreepGuard final : public StillListener {
 public:
  CreepGuard(const StopOptions& options, StillListener& listener) : options_(options), listener_(listener) {}
  CreepGuard(const CreepGuard&) = delete;
  CreepGuard& operator=(const CreepGuard&) = delete;
  ~CreepGuard() override = default;

  void not_still_until(std::int64_t until_ns, DropReason reason) override;
  void still_until(std::int64_t until_ns, int stop) override;
  void stop_ended(const StillStop& stop) override;
  /// Takes what the points say.
  [[nodiscard]] StillListener& points() { return points_; }

 private:
  class Points final : public StillListener {
   public:
    explicit Points(CreepGuard& guard) : guard_(guard) {}
    void not_still_until(std::int64_t, DropReason) override {}
    void still_until(std::int64_t, int) override {}
    void stop_ended(const StillStop& stop) override { guard_.take_rest(stop); }

   private:
    CreepGuard& guard_;
  };
  struct Rest {
    std::int64_t until_ns;
    int stop;
  };
  void take_rest(const StillStop& rest);
  void look_for_cut();
  void cut_beginning(std::int64_t end_ns);
  void finish_rest();

  StopOptions options_;
  StillListener& listener_;
  Points points_{*this};
  std::optional<Stop> left_;  ///< The last rest of the points that ended with a motion.
  std::int64_t begin_ns_ = std::numeric_limits<std::int64_t>::min();  ///< Up to here nobody found a rest.
  std::optional<Rest> rest_;                                          ///< The gyro's stop that goes on.
  std::optional<std::int64_t> start_ns_;                              ///< Where it begins, if later than by the gyro.
  std::optional<std::int64_t> cut_ns_;
  bool handed_on_ = false;  ///< Some of it.
  std::optional<CreepTurn> crept_;
  std::optional<CreepTurn> crept_before_;  ///< In the stop before.
};

}  // namespace rigcal
