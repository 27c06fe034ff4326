#include "apps/commands/motion_options.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/commands/option_checks.h"
#include "core/base/text.h"

namespace rigcal {
namespace {

/// Numbers of one option value with commas between them, each within its range; an empty text, or what is wrong.
class NumberList {
 public:
  struct Range {
    double low;
    double high;
  };
  NumberList(std::vector<Range> ranges, std::string example)
      : ranges_(std::move(ranges)), example_(std::move(example)) {}

  [[nodiscard]] std::vector<double> read(const std::string& text) const {
    std::vector<double> numbers;
    for (const std::string& part : CLI::detail::split(text, ',')) {
      double number = 0.0;
      if (numbers.size() == ranges_.size() || !CLI::detail::lexical_cast(part, number)) return {};
      const Range range = ranges_[numbers.size()];
      if (!(number >= range.low && number <= range.high)) return {};
      numbers.push_back(number);
    }
    if (numbers.size() != ranges_.size()) return {};
    return numbers;
  }

  [[nodiscard]] std::string check(const std::string& text) const {
    if (!read(text).empty()) return {};
    return "\"" + text + "\" is not within its bounds: write it as " + example_;
  }

 private:
  std::vector<Range> ranges_;
  std::string example_;
};

// Fits between the furniture of the room.
constexpr double usual_drive_m = 1.2;

template <class Take>
CLI::Option* add_list(CLI::App& command, const std::string& name, const NumberList& list, const std::string& shape,
                      const std::string& text, const Take& take) {
  return command
      .add_option_function<std::vector<std::string>>(
          name,
          [list, take](const std::vector<std::string>& values) {
            for (const std::string& value : values) take(list.read(value));
          },
          text)
      ->check(CLI::Validator([list](const std::string& value) { return list.check(value); }, ""))
      ->expected(1)
      ->take_all()
      ->option_text(shape);
}

}  // namespace

void add_motion_options(CLI::App& command, sim::TurntableOptions& options) {
  command
      .add_option_function<std::string>(
          "--motion",
          [&options](const std::string& motion) {
            if (motion != "turntable") sim::let_wander(0.1, 1.0, options);
            if (motion == "figure8" && options.drive_m == 0.0) options.drive_m = usual_drive_m;
          },
          "turntable (default); vehicle: it turns in place, each stop 0.1 m and 1 degree off; figure8: such a vehicle "
          "drives a figure of eight")
      ->check(CLI::IsMember({"turntable", "vehicle", "figure8"}))
      ->option_text("MOTION");
  command.add_option("--drive", options.drive_m, "Metres, half the length of the figure of eight (default 1.2)")
      ->check(number_range(0.1, 100.0))
      ->needs("--motion")
      ->option_text("M");
  command.add_option("--stops", options.stops, "Stops in a full turn (default 20)")
      ->check(CLI::Range(1, 1000))
      ->option_text("N");
  command.add_option("--dwell", options.dwell_s, "Seconds of each stop (default 2)")
      ->check(number_range(0.1, 600.0))
      ->option_text("S");
  using Numbers = std::vector<double>;
  add_list(command, "--dwell-range", NumberList({{0.1, 600.0}, {0.1, 600.0}}, "SHORTEST,LONGEST in seconds"), "S,S",
           "Stops of unequal length instead, for example 1,30",
           [&options](const Numbers& n) {
             options.dwell_range_s = {{std::min(n[0], n[1]), std::max(n[0], n[1])}};
           })
      ->excludes("--dwell");
  add_list(command, "--step-range", NumberList({{-180.0, 180.0}, {-180.0, 180.0}}, "LEAST,MOST in degrees"), "DEG,DEG",
           "The table turns by unequal steps instead, for example 10,60: no full turn", [&options](const Numbers& n) {
             options.step_range_deg = {{std::min(n[0], n[1]), std::max(n[0], n[1])}};
           });
  command
      .add_option_function<double>(
          "--creep", [&options](double deg) { options.creep_rad_per_s = to_rad(deg); },
          "Degrees a second by which the table turns on at rest")
      ->check(number_range(-10.0, 10.0))
      ->option_text("DEG_S");
  add_list(command, "--vibration", NumberList({{0.0, 5.0}, {0.1, 500.0}}, "DEG,HZ"), "DEG,HZ",
           "The rig trembles all the time: amplitude and frequency", [&options](const Numbers& n) {
             options.vibration = {to_rad(n[0]), n[1]};
           });
  command
      .add_option_function<double>(
          "--overshoot", [&options](double deg) { options.overshoot_rad = to_rad(deg); },
          "Degrees by which each turn goes too far, and back")
      ->check(number_range(0.0, 45.0))
      ->option_text("DEG");
  add_list(command, "--bump", NumberList({{0.0, 999.0}, {0.0, 600.0}, {0.0, 45.0}}, "STOP,SECONDS,DEG"), "STOP,S,DEG",
           "Somebody knocks against the rig in this stop, so long after its start; may be repeated",
           [&options](const Numbers& n) {
             options.bumps.push_back({static_cast<int>(n[0]), n[1], to_rad(n[2])});
           });
}

void check_motion(const CLI::App& command, const sim::TurntableOptions& options, bool with_ends) {
  if (command.count("--drive") > 0 && command.get_option("--motion")->as<std::string>() != "figure8")
    throw CLI::ValidationError("--drive", "only --motion figure8 drives");
  if (options.step_range_deg && options.drive_m > 0.0)
    throw CLI::ValidationError("--step-range", "--motion figure8 turns as its way does");
  for (const sim::Bump& bump : options.bumps) {
    const std::string stop = "stop " + std::to_string(bump.stop);
    if (bump.stop >= options.stops)
      throw CLI::ValidationError("--bump",
                                 "there is no " + stop + ": the last one is " + std::to_string(options.stops - 1));
    double length_s = options.dwell_range_s ? options.dwell_range_s->front() : options.dwell_s;
    if (with_ends && bump.stop == 0) length_s += options.initial_still_s;
    if (with_ends && bump.stop + 1 == options.stops) length_s += options.final_still_s;
    if (bump.time_s >= length_s)
      throw CLI::ValidationError("--bump", stop + (options.dwell_range_s ? " may end after " : " ends after ") +
                                               fixed_text(length_s, 1) + " s: give fewer seconds");
  }
}

}  // namespace rigcal
