#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "core/base/random.h"
#include "simdata/gige/stream_block.h"

namespace rigcal::sim {

/// What goes wrong with the packets of a stream. Shares of all of them.
struct StreamFaults {
  double loss = 0.0;
  double reorder = 0.0;  ///< One to eight others overtake the packet.
};

struct StreamCounts {
  std::uint64_t blocks = 0;
  std::uint64_t packets = 0;  ///< Handed out, without those that were lost on purpose.
  std::uint64_t bytes = 0;    ///< Of these, with UDP's payload only.
  std::uint64_t lost = 0;
  std::uint64_t damaged_blocks = 0;  ///< With a packet that was lost when it was sent first.
  std::uint64_t reordered = 0;
  std::uint64_t resent = 0;              ///< Packets that were asked for again, lost ones among them.
  std::uint64_t not_there_any_more = 0;  ///< Asked for again after their block was forgotten.
  std::uint64_t skipped_blocks = 0;      ///< More waited than are kept.
};

/// Cuts blocks into packets and says when each of them leaves, as the link and the packet delay have it; remembers the
/// latest blocks for packets that are asked for again. Pure: no socket, time is given.
class StreamSender {
 public:
  static constexpr std::size_t kKeptBlocks = 12;
  static constexpr std::size_t kKeptBytes = std::size_t{96} << 20U;

  StreamSender(const StreamFaults& faults, double link_bits_per_s, std::uint64_t seed);

  void add(const FrameOrder& order, std::vector<std::uint8_t> image, const StreamTarget& target, std::int64_t now_ns);
  /// Packets once more, where the block is still known; a packet that says that it is not, otherwise.
  void resend(const gige::ResendRequest& request);
  /// Nothing that waits is sent any more.
  void clear();

  struct Outgoing {
    StreamBlock::Packet packet;
    Endpoint to;
  };
  /// Replaces `out` by the packets that are due, at most `most`; their payload lives until anything else is called.
  void take_due(std::int64_t now_ns, std::size_t most, std::vector<Outgoing>& out);
  /// When the next packet is due.
  [[nodiscard]] std::int64_t deadline_ns() const;
  [[nodiscard]] const StreamCounts& counts() const { return counts_; }
  /// Memory of a block that is forgotten, or none.
  [[nodiscard]] std::vector<std::uint8_t> take_memory();
  /// Whether a packet is known as resent on the wire, see gige::kExtendedStatus.
  void mark_resent(bool marks) { marks_resent_ = marks; }

 private:
  struct Kept {
    std::unique_ptr<StreamBlock> block;
    StreamTarget target;
    std::uint32_t next = 0;  ///< Packet to be sent first.
    bool is_damaged = false;
  };
  struct Again {
    std::uint16_t block = 0;
    std::uint32_t packet = 0;
  };
  struct Held {
    std::uint16_t block = 0;
    std::uint32_t packet = 0;
    int overtakers = 0;  ///< That are still to come.
  };

  void forget();
  [[nodiscard]] Kept* find(std::uint16_t block);
  [[nodiscard]] Kept* first_unsent();
  /// False where the packet gets lost.
  bool put(const Kept& kept, std::uint32_t packet, gige::Status status, std::vector<Outgoing>& out);
  void put_first(Kept& kept, std::uint32_t packet, std::vector<Outgoing>& out);
  void send_again(std::vector<Outgoing>& out);
  bool send_next(std::vector<Outgoing>& out);
  void let_held_go(std::vector<Outgoing>& out, bool all);
  void wait_for_link(std::size_t packet_bytes, std::int64_t delay_ns);
  [[nodiscard]] bool happens(double share) { return share > 0.0 && random_.uniform() < share; }

  StreamFaults faults_;
  double ns_per_byte_;
  Random random_;
  std::deque<Kept> kept_;
  std::deque<Again> again_;
  std::vector<Held> held_;
  std::vector<std::vector<std::uint8_t>> spare_;
  StreamTarget last_target_;
  std::int64_t link_free_ns_ = 0;
  bool marks_resent_ = false;
  StreamCounts counts_;
};

}  // namespace rigcal::sim
