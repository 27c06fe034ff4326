#include "apps/packet_taker.h"

#include <chrono>
#include <utility>

namespace rigcal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t take_wait_ns = 100'000'000;
constexpr std::chrono::seconds publish_period{1};
constexpr std::chrono::milliseconds hand_over_period{100};  // Stops are found in what was handed over.
constexpr int packets_between_looks_at_the_time = 256;

}  // namespace

PacketTaker::PacketTaker(livox::Driver& driver, PacketRecorder recorder, const Rig& rig)
    : driver_(driver),
      recorder_(std::move(recorder)),
      progress_(recorder_.progress()),
      ledger_(LidarIngest::of_headers(rig)) {
  thread_ = std::thread([this] { run(); });
}

PacketTaker::~PacketTaker() {
  driver_.stop();
  finish();
}

void PacketTaker::finish() {
  if (thread_.joinable()) thread_.join();
}

PacketTaker::Figures PacketTaker::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

void PacketTaker::run() {
  auto published = Clock::now();
  auto handed_over = published;
  Expected<void> written;
  while (written) {
    const bool was_running = driver_.is_running();
    Datagram datagram;
    int taken = 0;
    while (written && taken < packets_between_looks_at_the_time && driver_.next(datagram, take_wait_ns)) {
      ++taken;
      written = recorder_.write(datagram);
      ledger_.add(datagram);
    }
    if (taken == 0 && !was_running) break;
    const auto now = Clock::now();
    if (written && now - handed_over >= hand_over_period) {
      handed_over = now;
      written = recorder_.hand_over();
    }
    if (now - published < publish_period) continue;
    published = now;
    if (written) written = recorder_.flush();
    publish({});
  }
  const Expected<void> closed = recorder_.close();
  if (written && !closed) written = closed;
  publish(written ? std::nullopt : std::optional<Error>(written.error()));
  has_ended_ = true;
}

void PacketTaker::publish(std::optional<Error> error) {
  IngestSummary summary = ledger_.summary();
  const std::lock_guard lock(mutex_);
  figures_ = {std::move(summary), recorder_.bytes(), recorder_.datagrams(), recorder_.forgotten_until_ns(),
              std::move(error)};
}

}  // namespace rigcal
