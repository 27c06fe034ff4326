#include "apps/capture/capture_log.h"

#include <algorithm>
#include <utility>

#include "apps/capture/doctor.h"
#include "core/base/utc_text.h"

namespace rigcal {
namespace {

constexpr std::size_t utc_text_size = 23;  // "2026-11-21 21:10:03.512"

// Firewalls let answers through, and points are none.
constexpr const char* never_came =
    "it answers and was told to send, but no packet has come in 2 s: let UDP through the firewall of this machine "
    "(rigcal doctor tells how)";

bool is_gap(const livox::EventContent& content) {
  if (std::holds_alternative<livox::Lost>(content) || std::holds_alternative<livox::AddressConflict>(content))
    return true;
  const auto* ended = std::get_if<livox::RequestEnded>(&content);
  if (ended != nullptr) return !ended->setting.empty() && ended->outcome != livox::Outcome::done;
  const auto* sampling = std::get_if<livox::SamplingChanged>(&content);
  return sampling != nullptr && !sampling->on;
}

// Settings that were taken at once are no news.
bool is_news(const livox::EventContent& content) {
  const auto* ended = std::get_if<livox::RequestEnded>(&content);
  return ended == nullptr || ended->outcome != livox::Outcome::done || !ended->setting.empty();
}

std::string sentence(const livox::EventContent& content) {
  std::string text = livox::event_text(content);
  const auto* status = std::get_if<livox::StatusChanged>(&content);
  if (status == nullptr) return text;
  for (const std::string& word : status_words(status->now)) text += ", " + word;
  return text;
}

// By the time that each sentence begins with; what is told late, as of a stop, comes where it belongs.
void insert_in_order(std::vector<std::string>& sentences, const std::string& dated) {
  const auto is_earlier = [](const std::string& one, const std::string& other) {
    return one.compare(0, utc_text_size, other, 0, utc_text_size) < 0;
  };
  sentences.insert(std::upper_bound(sentences.begin(), sentences.end(), dated, is_earlier), dated);
}

}  // namespace

void CaptureLog::add(const livox::Event& event) {
  if (!is_news(event.content)) return;
  const bool known = event.device < sensors_.size();
  add(event.stamp_ns, known ? sensors_[event.device] : "other devices", sentence(event.content),
      known && !is_over_ && is_gap(event.content));
}

void CaptureLog::compare(std::int64_t now_ns, const std::vector<livox::InterfaceReport>& interfaces) {
  for (const livox::InterfaceReport& report : interfaces) {
    const std::string name = name_of(report.interface);
    livox::ReceiverCounters& last = last_counters_[name];
    const livox::ReceiverCounters& now = report.counters;
    const auto tell = [&](std::uint64_t more, const std::string& why) {
      if (more > 0) add(now_ns, name, std::to_string(more) + " packets were lost, " + why, true);
    };
    tell(now.dropped_by_kernel - last.dropped_by_kernel,
         "because the socket's buffer of " + std::to_string(report.receive_bytes / 1024) + " KiB was full");
    tell(now.dropped_by_queue - last.dropped_by_queue, "because this program or its disk was too slow");
    if (now.errors > last.errors && last.errors == 0) add(now_ns, name, "the system could not receive", false);
    last = now;
  }
}

void CaptureLog::compare(std::int64_t now_ns, const std::vector<livox::DeviceReport>& devices) {
  for (std::size_t i = 0; i < devices.size() && i < sensors_.size(); ++i) {
    const livox::DeviceReport& device = devices[i];
    std::optional<std::int64_t>& since_ns = sampling_since_ns_[i];
    const bool is_sampling = device.link.state == livox::LinkState::sampling;
    if (!is_sampling) since_ns.reset();
    if (is_sampling && !since_ns) since_ns = now_ns;
    const bool is_silent = is_sampling && now_ns - std::max(*since_ns, device.last_packet_ns) > longest_silence_ns;
    if (is_silent == is_silent_[i]) continue;
    is_silent_[i] = is_silent;
    // Whether it still answers is known a second later: then it is lost, or it is not.
    if (is_silent) add(now_ns, sensors_[i], device.packets == 0 ? never_came : "no packet has come for 2 s", true);
    if (!is_silent && is_sampling) add(now_ns, sensors_[i], "packets come again", false);
  }
}

void CaptureLog::add(std::int64_t stamp_ns, const std::string& about, const std::string& what, bool is_gap) {
  const std::string text = about + ": " + what;
  std::string& last = last_[about];
  if (last == what && !is_gap) return;
  last = what;
  const std::string dated = utc_text(stamp_ns) + " " + text;
  const auto keep = [&dated](std::vector<std::string>& list, std::uint64_t& left_out) {
    if (list.size() < kMost) {
      insert_in_order(list, dated);
    } else {
      ++left_out;
    }
  };
  keep(events_, left_out_events_);
  newest_.push_back(dated);
  if (newest_.size() > kNewest) newest_.pop_front();
  if (is_gap) keep(gaps_, left_out_gaps_);
}

std::vector<std::string> CaptureLog::last_events(std::size_t count) const {
  const std::size_t first = newest_.size() - std::min(count, newest_.size());
  return {newest_.begin() + static_cast<std::ptrdiff_t>(first), newest_.end()};
}

std::vector<std::string> CaptureLog::closed(std::vector<std::string> sentences, std::uint64_t left_out) {
  if (left_out > 0) sentences.push_back("and " + std::to_string(left_out) + " more");
  return sentences;
}

}  // namespace rigcal
