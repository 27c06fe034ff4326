#include "core/quality/recording_faults.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/text.h"

namespace rigcal {
namespace {

constexpr double worthy_loss = 1e-3;  // a packet in a thousand costs no accuracy; more hints at the machine or network
constexpr double worthy_gap_ms = 100.0;      // as long as a motion that nobody sees
constexpr double most_drift_ppm = 200.0;     // quartzes are within 100
constexpr double most_told_ppm = 500.0;      // by core/clocks
constexpr double most_delay_us = 200'000.0;  // longer than the margins of stops

std::uint64_t count(const std::map<std::string, std::uint64_t>& counters, const std::string& name) {
  const auto found = counters.find(name);
  return found == counters.end() ? 0 : found->second;
}

// 17 %, 3.1 %, 0.12 %
std::string percent(double share) {
  const double value = 100.0 * share;
  return fixed_text(value, value >= 9.95 ? 0 : value >= 0.995 ? 1 : 2) + " %";
}

std::string times(std::uint64_t number) {
  return number == 1 ? "once" : number == 2 ? "twice" : std::to_string(number) + " times";
}

std::string loss_of(const std::map<std::string, std::uint64_t>& counters, const std::string& stream) {
  const std::uint64_t lost = count(counters, stream + "_lost");
  const auto expected = static_cast<double>(std::max<std::uint64_t>(count(counters, stream + "_expected"), 1));
  const auto longest_ms = static_cast<double>(count(counters, stream + "_longest_gap_ms"));
  const double share = static_cast<double>(lost) / expected;
  if (share < worthy_loss && longest_ms < worthy_gap_ms) return {};
  const std::uint64_t gaps = count(counters, stream + "_gaps");
  std::string text = percent(share) + " of its " + (stream == "imu" ? "IMU" : stream) + " packets are lost (" +
                     std::to_string(lost) + " in " + counted(gaps, "gap");
  if (longest_ms >= worthy_gap_ms) text += ", the longest " + fixed_text(1e-3 * longest_ms, 1) + " s";
  return text + ")";
}

void add_losses(const PacketCounters& packets, std::vector<RecordingFault>& faults) {
  for (const auto& [sensor, counters] : packets) {
    std::string text = loss_of(counters, "point");
    if (const std::string imu = loss_of(counters, "imu"); !imu.empty()) text += (text.empty() ? "" : ", ") + imu;
    if (!text.empty())
      faults.push_back({sensor, RecordingFault::Kind::loss,
                        text + "; check cable and switch, and the receive buffer (rigcal doctor)"});
  }
}

void add_clock_faults(const ClockReport& clock, std::vector<RecordingFault>& faults) {
  const auto add = [&](const std::string& what) {
    faults.push_back({clock.sensor, RecordingFault::Kind::clock, what});
  };
  if (clock.jumps > 0) {
    add("its clock jumped " + times(clock.jumps) +
        ": it was set, or the device started anew; check its power and what sets its clock (PTP, GPS)");
  }
  if (std::abs(clock.drift_ppm) > most_drift_ppm) {
    // What is faster is not told apart.
    const bool or_more = std::abs(clock.drift_ppm) > 0.99 * most_told_ppm;
    add(std::string("its clock runs ") + (clock.drift_ppm > 0.0 ? "fast" : "slow") + " by " +
        fixed_text(std::abs(clock.drift_ppm), 0) + " ppm" + (or_more ? " or more" : "") +
        ", as no sound one does: its points are placed by when its packets came; have the device checked");
  }
  if (clock.strays > 0) {
    add(std::to_string(clock.strays) + (clock.strays == 1 ? " packet has" : " packets have") +
        " a senseless time stamp and " + (clock.strays == 1 ? "was" : "were") + " left out; check its cable");
  }
  if (clock.max_delay_us > most_delay_us) {
    add("packets of it came up to " + fixed_text(1e-6 * clock.max_delay_us, 2) +
        " s late; check what else the network and the recording machine had to do");
  }
}

}  // namespace

std::string to_string(const RecordingFault& fault) { return fault.sensor + ": " + fault.what; }

std::string faults_in_brief(const std::vector<RecordingFault>& faults) {
  std::string out;
  for (const auto& [kind, words] :
       {std::pair{RecordingFault::Kind::loss, "packets lost"}, std::pair{RecordingFault::Kind::clock, "clock"}}) {
    std::string names;
    std::string last;
    for (const RecordingFault& fault : faults) {
      if (fault.kind != kind || fault.sensor == last) continue;
      names += (names.empty() ? "" : ", ") + fault.sensor;
      last = fault.sensor;
    }
    if (!names.empty()) out += (out.empty() ? "" : "; ") + std::string(words) + " (" + names + ")";
  }
  return out;
}

std::vector<RecordingFault> recording_faults(const PacketCounters& packets, const std::vector<ClockReport>& clocks) {
  std::vector<RecordingFault> faults;
  add_losses(packets, faults);
  for (const ClockReport& clock : clocks) add_clock_faults(clock, faults);
  std::stable_sort(faults.begin(), faults.end(),
                   [](const RecordingFault& a, const RecordingFault& b) { return a.sensor < b.sensor; });
  return faults;
}

}  // namespace rigcal
