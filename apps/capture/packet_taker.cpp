#include "apps/capture/packet_taker.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr std::int64_t take_wait_ns = 100'000'000;
constexpr std::chrono::seconds publish_period{1};
constexpr std::chrono::milliseconds hand_over_period{100};  // Stops are found in what was handed over.
constexpr int packets_between_looks_at_the_time = 256;

}  // namespace

PacketTaker::PacketTaker(livox::Driver& driver, PacketRecorder recorder, const Rig& rig)
    : driver_(driver),
      clock_(driver.session_start()),
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
  auto published = SteadyClock::now();
  auto handed_over = published;
  Expected<void> written;
  while (written) {
    heartbeat_.beat();
    const bool was_running = driver_.is_running();
    const auto [taken, now] = take_some(written, handed_over);
    if (taken == 0 && !was_running) break;
    if (now - published < publish_period) continue;
    published = now;
    if (written) written = recorder_.flush();
    publish({});
  }
  const Expected<void> closed = recorder_.close();
  if (written && !closed) written = closed;
  heartbeat_.rest();
  publish(written ? std::nullopt : std::optional<Error>(written.error()));
  has_ended_ = true;
}

// Waits for the first datagram only, so that what came is handed over in time however little comes.
std::pair<int, SteadyClock::time_point> PacketTaker::take_some(Expected<void>& written,
                                                               SteadyClock::time_point& handed_over) {
  Datagram datagram;
  int taken = 0;
  SteadyClock::time_point begun;
  while (written && taken < packets_between_looks_at_the_time &&
         driver_.next(datagram, taken == 0 ? take_wait_ns : 0)) {
    // The oldest of what has waited; a reading of the clock for each would be most of the work.
    if (++taken == 1) {
      begun = SteadyClock::now();
      const std::int64_t now_ns = clock_.from_monotonic(monotonic_now_ns());
      recent_wait_ns_ = std::max(recent_wait_ns_, now_ns - datagram.stamp_ns);
      worst_wait_ns_ = std::max(worst_wait_ns_, recent_wait_ns_);
    }
    written = recorder_.write(datagram);
    ledger_.add(datagram);
  }
  if (written && SteadyClock::now() - handed_over >= hand_over_period) {
    handed_over = SteadyClock::now();
    if (taken == 0) begun = handed_over;
    written = recorder_.hand_over();
  }
  const SteadyClock::time_point now = SteadyClock::now();
  if (begun != SteadyClock::time_point()) {
    const auto took = std::chrono::duration_cast<std::chrono::nanoseconds>(now - begun);
    worst_write_ns_ = std::max<std::int64_t>(worst_write_ns_, took.count());
  }
  return {taken, now};
}

void PacketTaker::publish(std::optional<Error> error) {
  IngestSummary summary = ledger_.summary();
  const std::lock_guard lock(mutex_);
  figures_ = {std::move(summary),    recorder_.bytes(),
              recorder_.datagrams(), recorder_.forgotten_until_ns(),
              worst_wait_ns_,        std::exchange(recent_wait_ns_, 0),
              worst_write_ns_,       std::move(error)};
}

}  // namespace rigcal
