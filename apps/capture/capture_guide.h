#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/cameras/capture_event.h"
#include "apps/capture/capture_status.h"
#include "apps/capture/live_stops.h"
#include "apps/capture/table_recorder.h"
#include "core/turntable/capture_machine.h"

namespace rigcal {

/// Brings what happens in a capture to the machine that decides, and does what that wants of the table. Of one thread.
class CaptureGuide {
 public:
  /// `table` is null where it is turned by hand; all must outlive this. `lidars` by device of the driver.
  CaptureGuide(const CaptureGoal& goal, const std::vector<std::string>& lidars, const std::vector<std::string>& cameras,
               LiveStops& stops, TableRecorder* table);

  struct Wish {
    bool end = false;
    bool secure = false;
  };
  /// Takes in what happened since the last call. `now_ns` is session time.
  Wish look(std::int64_t now_ns, const std::vector<livox::DeviceReport>& lidars,
            const std::vector<CaptureCamera>& cameras);
  /// It was told to end, or (`failure`) cannot go on.
  void end(std::int64_t now_ns, const std::string& failure = {});

  /// Whether cameras that can be told are to take images now: a stop goes on and is not full yet. Also where nobody can
  /// tell any more whether the rig stands still: then an image too many is better than none.
  [[nodiscard]] bool wants_images() const;
  [[nodiscard]] CaptureProgress progress() const { return machine_.progress(); }
  [[nodiscard]] const std::vector<Stop>& stops() const { return found_; }
  /// Since the last call: states and stops, in sentences.
  [[nodiscard]] std::vector<CaptureEvent> take_events() { return std::exchange(events_, {}); }

 private:
  void tell(const CaptureInput& input);
  void look_at_sensors(const std::vector<livox::DeviceReport>& lidars, const std::vector<CaptureCamera>& cameras);
  void look_at_stops(const std::vector<CaptureCamera>& cameras);
  void look_at_table();
  void say(std::string text, bool is_gap = false);
  void say_at(std::int64_t stamp_ns, std::string text, bool is_gap);

  CaptureMachine machine_;
  LiveStops& stops_;
  TableRecorder* table_;
  std::vector<std::string> names_;
  std::vector<bool> is_there_;
  std::vector<std::int64_t> last_image_ns_;  ///< By camera, of the last image the machine was told of.
  std::size_t lidars_;
  std::int64_t now_ns_ = 0;
  std::optional<std::int64_t> settled_ns_;  ///< Of the stop that goes on.
  int stop_ = -1;                           ///< That goes on, or went on last.
  int full_stops_ = 0;                      ///< As told last.
  CaptureState told_state_ = CaptureState::idle;
  std::vector<Stop> found_;
  std::vector<CaptureEvent> events_;
  Wish wish_;
};

}  // namespace rigcal
