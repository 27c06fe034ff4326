#include "simdata/gige/stream_sender.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/gige_codec/stream_packet.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t longest_burst_ns = 10'000'000;  // Of link time that was slept through.
constexpr std::size_t most_again = 1U << 16U;
constexpr std::uint64_t most_overtakers = 8;

}  // namespace

StreamSender::StreamSender(const StreamFaults& faults, double link_bits_per_s, std::uint64_t seed)
    : faults_(faults), ns_per_byte_(8e9 / link_bits_per_s), random_(seed) {}

void StreamSender::add(const FrameOrder& order, std::vector<std::uint8_t> image, const StreamTarget& target,
                       std::int64_t now_ns) {
  if (deadline_ns() == INT64_MAX) link_free_ns_ = std::max(link_free_ns_, now_ns);
  kept_.push_back({std::make_unique<StreamBlock>(order, std::move(image), target.packet_bytes), target, 0});
  last_target_ = target;
  ++counts_.blocks;
  forget();
}

void StreamSender::forget() {
  std::size_t bytes = 0;
  for (const Kept& kept : kept_) bytes += kept.block->memory_bytes();
  while (kept_.size() > 1 && (kept_.size() > kKeptBlocks || bytes > kKeptBytes)) {
    Kept& oldest = kept_.front();
    bytes -= oldest.block->memory_bytes();
    if (oldest.next < oldest.block->packet_count()) ++counts_.skipped_blocks;
    std::erase_if(held_, [&oldest](const Held& held) { return held.block == oldest.block->id(); });
    if (spare_.size() < 2) spare_.push_back(oldest.block->take_memory());
    kept_.pop_front();
  }
}

std::vector<std::uint8_t> StreamSender::take_memory() {
  if (spare_.empty()) return {};
  std::vector<std::uint8_t> memory = std::move(spare_.back());
  spare_.pop_back();
  return memory;
}

void StreamSender::clear() {
  kept_.clear();
  again_.clear();
  held_.clear();
}

StreamSender::Kept* StreamSender::find(std::uint16_t block) {
  // The latest first: ids come again after the wrap.
  const auto found =
      std::find_if(kept_.rbegin(), kept_.rend(), [block](const Kept& kept) { return kept.block->id() == block; });
  return found == kept_.rend() ? nullptr : &*found;
}

StreamSender::Kept* StreamSender::first_unsent() {
  const auto found =
      std::find_if(kept_.begin(), kept_.end(), [](const Kept& kept) { return kept.next < kept.block->packet_count(); });
  return found == kept_.end() ? nullptr : &*found;
}

void StreamSender::resend(const gige::ResendRequest& request) {
  const Kept* kept = find(request.block);
  if (kept == nullptr) {
    ++counts_.not_there_any_more;
    if (again_.size() < most_again) again_.push_back({request.block, request.first});
    return;
  }
  // What was not sent at all yet will come anyway.
  const std::uint32_t end = std::min({request.last + 1, kept->block->packet_count(), kept->next});
  for (std::uint32_t packet = request.first; packet < end && again_.size() < most_again; ++packet)
    again_.push_back({request.block, packet});
}

void StreamSender::wait_for_link(std::size_t packet_bytes, std::int64_t delay_ns) {
  link_free_ns_ += std::llround(ns_per_byte_ * static_cast<double>(packet_bytes + gige::kEthernetBytes)) + delay_ns;
}

bool StreamSender::put(const Kept& kept, std::uint32_t packet, gige::Status status, std::vector<Outgoing>& out) {
  const StreamBlock::Packet made = kept.block->packet(packet, status);
  const std::size_t bytes = made.header.size() + made.payload.size();
  wait_for_link(bytes + gige::kWireHeaderBytes, kept.target.packet_delay_ns);
  if (happens(faults_.loss)) {
    ++counts_.lost;
    return false;
  }
  ++counts_.packets;
  counts_.bytes += bytes;
  out.push_back({made, kept.target.to});
  return true;
}

void StreamSender::put_first(Kept& kept, std::uint32_t packet, std::vector<Outgoing>& out) {
  if (put(kept, packet, gige::Status::success, out) || kept.is_damaged) return;
  kept.is_damaged = true;
  ++counts_.damaged_blocks;
}

void StreamSender::send_again(std::vector<Outgoing>& out) {
  const Again again = again_.front();
  again_.pop_front();
  const Kept* kept = find(again.block);
  if (kept != nullptr && again.packet < kept->block->packet_count()) {
    ++counts_.resent;
    put(*kept, again.packet, marks_resent_ ? gige::Status::packet_resent : gige::Status::success, out);
    return;
  }
  gige::StreamPacket none;
  none.status = gige::Status::packet_unavailable;
  none.block = again.block;
  none.packet = again.packet;
  wait_for_link(gige::kWireHeaderBytes + gige::kStreamHeaderBytes, 0);
  ++counts_.packets;
  out.push_back({{gige::make_stream_header(none), {}}, last_target_.to});
}

bool StreamSender::send_next(std::vector<Outgoing>& out) {
  Kept* kept = first_unsent();
  if (kept == nullptr) return false;
  const std::uint32_t packet = kept->next++;
  if (happens(faults_.reorder)) {
    ++counts_.reordered;
    held_.push_back({kept->block->id(), packet, 1 + static_cast<int>(random_.below(most_overtakers))});
    return true;
  }
  put_first(*kept, packet, out);
  for (Held& held : held_) --held.overtakers;
  return true;
}

void StreamSender::let_held_go(std::vector<Outgoing>& out, bool all) {
  for (auto it = held_.begin(); it != held_.end();) {
    if (!all && it->overtakers > 0) {
      ++it;
      continue;
    }
    if (Kept* kept = find(it->block)) put_first(*kept, it->packet, out);
    it = held_.erase(it);
  }
}

void StreamSender::take_due(std::int64_t now_ns, std::size_t most, std::vector<Outgoing>& out) {
  out.clear();
  link_free_ns_ = std::max(link_free_ns_, now_ns - longest_burst_ns);
  while (link_free_ns_ <= now_ns && out.size() + most_overtakers < most) {
    if (!again_.empty()) {
      send_again(out);
      continue;
    }
    let_held_go(out, false);
    if (send_next(out)) continue;
    let_held_go(out, true);  // Nothing is left to overtake them.
    break;
  }
}

std::int64_t StreamSender::deadline_ns() const {
  const bool waits = !again_.empty() || !held_.empty() || std::any_of(kept_.begin(), kept_.end(), [](const Kept& kept) {
    return kept.next < kept.block->packet_count();
  });
  return waits ? link_free_ns_ : INT64_MAX;
}

}  // namespace rigcal::sim
