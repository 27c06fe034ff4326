#include "tests/bench/trial_statistics.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>

namespace rigcal {
namespace {

double badness(const Trial& trial) {
  if (!trial.error.compared) return 0.0;  // it says itself that there is nothing
  return std::max(trial.error.translation_m / 0.010, trial.error.rotation_rad / to_rad(0.1));
}

template <class Value>
std::vector<double> sorted(const std::vector<Trial>& trials, const Value& value) {
  std::vector<double> out;
  for (const Trial& trial : trials) {
    if (trial.error.compared) out.push_back(value(trial));
  }
  std::sort(out.begin(), out.end());
  return out;
}

double median(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double mean(const std::vector<double>& values) {
  return values.empty() ? 0.0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double last(const std::vector<double>& values) { return values.empty() ? 0.0 : values.back(); }

}  // namespace

std::string trial_text(const Trial& trial) {
  const SensorError& e = trial.error;
  if (!e.compared) return e.name + " failed";
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s %.4f deg %.2f mm nees %.2f %s %.2f s", e.name.c_str(),
                to_deg(e.rotation_rad), 1e3 * e.translation_m, e.nees_per_dof.value_or(0.0), to_string(e.status),
                trial.wall_s);
  return text.data();
}

std::string summary_text(const std::string& title, const std::vector<Trial>& trials) {
  const auto count = [&](const auto& is) { return static_cast<int>(std::count_if(trials.begin(), trials.end(), is)); };
  const auto mm = sorted(trials, [](const Trial& t) { return 1e3 * t.error.translation_m; });
  const auto deg = sorted(trials, [](const Trial& t) { return to_deg(t.error.rotation_rad); });
  const auto seconds = sorted(trials, [](const Trial& t) { return t.wall_s; });
  const auto nees = sorted(trials, [](const Trial& t) { return t.error.nees_per_dof.value_or(0.0); });
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(),
                "== %s: %zu trials: right %d (flagged of them %d), wrong and flagged %d, wrong and NOT flagged %d; "
                "median %.2f mm %.4f deg, worst %.2f mm %.4f deg; NEES mean %.2f worst %.2f; %.2f s\n",
                title.c_str(), trials.size(), count([](const Trial& t) { return t.is_right(); }),
                count([](const Trial& t) { return t.is_right() && t.flagged; }),
                count([](const Trial& t) { return !t.is_right() && t.flagged; }),
                count([](const Trial& t) { return !t.is_right() && !t.flagged; }), median(mm), median(deg), last(mm),
                last(deg), mean(nees), last(nees), median(seconds));
  return text.data();
}

std::optional<std::size_t> worst_trial(const std::vector<Trial>& trials) {
  const auto worst = std::max_element(trials.begin(), trials.end(),
                                      [](const Trial& a, const Trial& b) { return badness(a) < badness(b); });
  if (worst == trials.end() || !worst->error.compared) return std::nullopt;
  return static_cast<std::size_t>(worst - trials.begin());
}

}  // namespace rigcal
