#pragma once

#include <cstdint>
#include <optional>

namespace rigcal {

/// How a camera numbers its frames.
struct FrameIdRule {
  int bits = 64;            ///< 1 to 64: where the numbers start again.
  bool skips_zero = false;  ///< After the highest number comes 1.
};
inline constexpr FrameIdRule gige_block_ids{16, true};          ///< GigE Vision 1, and 2 without extended ids.
inline constexpr FrameIdRule extended_block_ids{64, true};      ///< GigE Vision 2 with extended ids.
inline constexpr FrameIdRule usb3_block_ids{64, false};         ///< USB3 Vision.
inline constexpr FrameIdRule v4l2_sequence_numbers{32, false};  ///< Video4Linux.

/// How many frames after `before` the camera exposed `after`, by its numbers: 1 for neighbours, also across the wrap; 0
/// for the same, negative for an earlier one. Meaningless where the camera began to count anew.
[[nodiscard]] std::int64_t frame_steps(const FrameIdRule& rule, std::uint64_t before, std::uint64_t after);

/// Whether the numbers of the frames agree with the numbers of the pulses to which time assigns them: a second witness
/// for cameras whose frames have no stamps but those of their arrival.
class IdWitness {
 public:
  explicit IdWitness(const FrameIdRule& rule) : rule_(rule) {}

  /// False where as many frames as pulses have not passed since the last frame that agreed. Three frames in a row that
  /// contradict it in the same way are believed: the camera counts anew, or did not see a pulse.
  [[nodiscard]] bool agrees(std::uint64_t id, std::int64_t pulse);

 private:
  struct Pair {
    std::uint64_t id = 0;
    std::int64_t pulse = 0;
  };
  FrameIdRule rule_;
  std::optional<Pair> last_;
  std::int64_t shift_ = 0;
  int contradictions_ = 0;
};

}  // namespace rigcal
