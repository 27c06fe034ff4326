#pragma once

#include <string>
#include <variant>
#include <vector>

namespace rigcal {

/// Where a capture at a turntable stands.
enum class CaptureState {
  idle,
  checking,           ///< Sensors are looked for.
  waiting_for_still,  ///< The rig moves, and no stop that counts is behind it.
  settling,           ///< It rests, not yet long enough for a stop.
  capturing,          ///< A stop: patches fill, cameras are waited for. Also when it is full, until the rig moves.
  moving,             ///< From a stop that counts to the next one.
  ended,              ///< The goal is reached, or it was told to end.
  failed,             ///< It cannot go on; what is recorded stays.
};
[[nodiscard]] const char* to_string(CaptureState state);

/// What a capture is to bring. Times in seconds.
struct CaptureGoal {
  int stops = 0;              ///< Stops that count; 0: until it is told to end.
  double dwell_s = 1.0;       ///< Rest that makes a stop count.
  double check_s = 30.0;      ///< So long sensors are waited for at the start, then it begins without them.
  double frame_s = 3.0;       ///< So much longer than the dwell a camera's image is waited for.
  double table_s = 60.0;      ///< So long a table may take for a step.
  bool turns_itself = false;  ///< The table turns when it is told; otherwise the operator turns it.
};

/// A sensor as a goal sees it.
struct CaptureSensor {
  std::string name;
  bool is_camera = false;
};

/// What happened. Sensors are numbers in the order in which the machine was given them.
namespace happened {
struct Begun {};
struct SensorCame {
  int sensor = 0;
};
struct SensorWent {
  int sensor = 0;
};
/// An image that was exposed in the stop that goes on.
struct ImageCame {
  int sensor = 0;
};
struct RestBegan {};
struct RestSettled {
  int stop = 0;
  double at_s = 0.0;  ///< When, by the machine's clock: what finds stops may be far behind it.
};
/// The stop that goes on is known to have lasted so long.
struct Rested {
  double seconds = 0.0;
};
/// A stop has ended; `RestOver` follows.
struct StopOver {
  int stop = 0;
  double seconds = 0.0;
};
struct RestOver {};
/// The stops are found anew from the start: those told so far do not count.
struct FoundAnew {};
struct TableArrived {};
struct TableFailed {
  std::string why;
};
struct TimePassed {};
struct EndAsked {};
/// Recording cannot go on.
struct RecordingFailed {
  std::string why;
};
}  // namespace happened

using CaptureInput =
    std::variant<happened::Begun, happened::SensorCame, happened::SensorWent, happened::ImageCame, happened::RestBegan,
                 happened::RestSettled, happened::Rested, happened::StopOver, happened::RestOver, happened::FoundAnew,
                 happened::TableArrived, happened::TableFailed, happened::TimePassed, happened::EndAsked,
                 happened::RecordingFailed>;

/// What is to be done now.
enum class CaptureAction {
  turn_table,
  secure,  ///< Bring to the disk what is recorded: a stop is in.
  end,
};

/// How a machine stands, for showing and advice.
struct CaptureProgress {
  CaptureState state = CaptureState::idle;
  int stop = -1;          ///< That goes on, or went on last: numbered from 0, as in events and files.
  int stops = 0;          ///< That count.
  int wanted_stops = 0;   ///< 0: any number.
  int short_stops = 0;    ///< Left before they counted; they are recorded, too.
  double rested_s = 0.0;  ///< Of the stop that goes on.
  double dwell_s = 0.0;
  bool is_full = false;     ///< The stop that goes on counts already.
  bool left_early = false;  ///< The last stop was left before it counted.
  bool turns_itself = false;
  bool table_is_turning = false;
  std::vector<std::string> absent;   ///< Sensors that are not there.
  std::vector<std::string> awaited;  ///< Cameras without an image in the stop that goes on.
  std::string failure;               ///< Why it failed.
};

/// Decides what a capture at a turntable does next: a pure state machine, fed with what happened and when (seconds of
/// any clock that never goes back). Sensors that drop out in any state are gone without until they are back.
///
///   checking --(all sensors came, or check_s passed)--> waiting_for_still --(rest)--> settling --(settled)-->
///   capturing capturing --(full and moved)--> moving --(rest)--> settling ...; left early: waiting_for_still capturing
///   --(the last wanted stop is full)--> ended;  any --(told to end)--> ended, --(trouble)--> failed
///
/// A stop is full when it has lasted the dwell and every camera that is there has an image in it. A table that turns
/// itself is told to once a stop is full, twice at most for a step; a rest does not count before it has arrived, and of
/// a stop that a gap in the data parts only one part does.
class CaptureMachine {
 public:
  CaptureMachine(const CaptureGoal& goal, std::vector<CaptureSensor> sensors);

  /// Returns what is to be done, in order.
  [[nodiscard]] std::vector<CaptureAction> handle(double now_s, const CaptureInput& input);
  [[nodiscard]] CaptureState state() const { return state_; }
  [[nodiscard]] CaptureProgress progress() const;

 private:
  enum class Rest { none, begun, settled };
  struct Seen {
    CaptureSensor sensor;
    bool is_there = false;
    bool has_image = false;  ///< In the stop that goes on.
  };
  using Actions = std::vector<CaptureAction>;

  void on(const happened::Begun&);
  void on(const happened::SensorCame& input);
  void on(const happened::SensorWent& input);
  void on(const happened::ImageCame& input);
  void on(const happened::RestBegan&);
  void on(const happened::RestSettled& input);
  void on(const happened::Rested& input);
  void on(const happened::StopOver& input);
  void on(const happened::RestOver&);
  void on(const happened::FoundAnew&);
  void on(const happened::TableArrived&);
  void on(const happened::TableFailed& input);
  void on(const happened::TimePassed&);
  void on(const happened::EndAsked&);
  void on(const happened::RecordingFailed& input);

  [[nodiscard]] bool is_over() const { return state_ == CaptureState::ended || state_ == CaptureState::failed; }
  [[nodiscard]] bool is_under_way() const;
  [[nodiscard]] bool are_all_there() const;
  [[nodiscard]] bool has_all_images() const;
  void look_at_rest();
  void begin_stop(const happened::RestSettled& input);
  void check_full();
  void count_stop();
  void turn();
  void turn_again_or_fail(const std::string& why);
  void fail(std::string why);
  Seen* seen(int sensor);

  CaptureGoal goal_;
  std::vector<Seen> sensors_;
  CaptureState state_ = CaptureState::idle;
  Rest rest_ = Rest::none;
  int stop_ = -1;               ///< That goes on, or went on last.
  std::size_t place_ = 0;       ///< Of that: how many steps of a table that turns itself were told before it settled.
  std::size_t places_in_ = 0;   ///< Of these places, so many have a stop that counts or have been passed by.
  std::vector<double> told_s_;  ///< When each step was told first.
  int stops_ = 0;
  int short_stops_ = 0;
  double rested_s_ = 0.0;
  bool is_full_ = false;
  bool left_early_ = false;
  bool table_is_turning_ = false;
  int turns_told_ = 0;  ///< Of this step.
  double table_due_s_ = 0.0;
  double now_s_ = 0.0;
  double begun_s_ = 0.0;
  std::string failure_;
  Actions actions_;
};

}  // namespace rigcal
