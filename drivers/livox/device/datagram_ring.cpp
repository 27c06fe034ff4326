#include "drivers/livox/device/datagram_ring.h"

#include <algorithm>
#include <bit>

namespace rigcal::livox {

DatagramRing::DatagramRing(std::size_t datagrams) : capacity_(std::bit_ceil(std::max<std::size_t>(datagrams, 2))) {}

void DatagramRing::take_memory() { slots_.resize(capacity_); }

bool DatagramRing::push(const Datagram& datagram) {
  if (slots_.empty()) take_memory();
  const std::uint64_t pushed = pushed_.load(std::memory_order_relaxed);
  const std::size_t waiting = pushed - popped_.load(std::memory_order_acquire);
  if (waiting >= capacity_ || datagram.bytes.size() > kLongest) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  Slot& slot = slots_[pushed & (capacity_ - 1)];
  slot.stamp_ns = datagram.stamp_ns;
  slot.from = datagram.from;
  slot.to = datagram.to;
  slot.size = static_cast<std::uint32_t>(datagram.bytes.size());
  std::copy(datagram.bytes.begin(), datagram.bytes.end(), slot.bytes.begin());
  if (waiting + 1 > high_water_.load(std::memory_order_relaxed))
    high_water_.store(waiting + 1, std::memory_order_relaxed);
  pushed_.store(pushed + 1, std::memory_order_release);
  return true;
}

bool DatagramRing::peek(Datagram& datagram) const {
  const std::uint64_t popped = popped_.load(std::memory_order_relaxed);
  if (popped == pushed_.load(std::memory_order_acquire)) return false;
  const Slot& slot = slots_[popped & (capacity_ - 1)];
  datagram = {slot.stamp_ns, slot.from, slot.to, ByteView(slot.bytes).first(slot.size)};
  return true;
}

void DatagramRing::pop() { popped_.fetch_add(1, std::memory_order_release); }

}  // namespace rigcal::livox
