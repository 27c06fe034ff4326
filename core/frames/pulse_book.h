#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frames/release_line.h"
#include "core/records/image.h"

namespace rigcal {

/// Which pulse fits a time.
struct PulseChoice {
  enum class Verdict {
    clear,    ///< One pulse, and no other could be it.
    several,  ///< More than one could be it.
    none,
  };
  Verdict verdict = Verdict::none;
  std::size_t index = 0;  ///< Of the nearest pulse, in the book; not where the verdict is none.
};

/// The pulses that may still get a frame, in the order of time. Its memory is asked for once.
class PulseBook {
 public:
  /// 4 s of pulses at 1 kHz.
  static constexpr std::size_t kCapacity = 4096;

  PulseBook() : entries_(kCapacity) {}

  [[nodiscard]] bool is_full() const { return size_ == kCapacity; }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Not where it is full; later than all before.
  void add(const TriggerPulse& pulse);
  /// In the order of time; `index` below `size`.
  [[nodiscard]] const TriggerPulse& pulse(std::size_t index) const { return entry(index).pulse; }
  [[nodiscard]] bool is_taken(std::size_t index) const { return entry(index).is_taken; }
  void take(std::size_t index) { entries_[(first_ + index) % kCapacity].is_taken = true; }
  void drop_first();

  /// Index of the first pulse at or after that time; `size` where there is none.
  [[nodiscard]] std::size_t first_from(std::int64_t stamp_ns) const;
  /// The pulse at that time: within six standard deviations or a millisecond, and so much nearer than the next one
  /// that a stamp would have to be off by five standard deviations to be of that.
  [[nodiscard]] PulseChoice choose(const StampEstimate& estimate) const;
  /// How far a pulse may be from where it is expected.
  [[nodiscard]] static double reach_ns(const StampEstimate& estimate);

 private:
  struct Entry {
    TriggerPulse pulse;
    bool is_taken = false;
  };
  [[nodiscard]] const Entry& entry(std::size_t index) const { return entries_[(first_ + index) % kCapacity]; }

  std::vector<Entry> entries_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace rigcal
