#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "apps/recording/recording_progress.h"
#include "apps/recording/stop_pass.h"
#include "core/base/heartbeat.h"

namespace rigcal {

/// What the rig does, as its own recording shows it.
struct LiveStopEvent {
  enum class Kind {
    still,     ///< It came to rest at `stamp_ns`; known some 0.8 s later.
    settled,   ///< The rest is long enough: `stop` goes on, and starts at `stamp_ns`.
    complete,  ///< `stop` is over; `record` tells its interval, and the sink has all of its points.
    moving,    ///< The rest is over, at `stamp_ns`; also one that was no stop.
    anew,      ///< What was told so far is to be forgotten: the recording is read again with what was learned.
  };
  Kind kind = Kind::moving;
  std::int64_t stamp_ns = 0;         ///< Session time.
  int stop = -1;                     ///< Of `settled` and `complete`.
  std::optional<StopRecord> record;  ///< Of `complete`.
};

/// How far the reading is.
struct LiveStopStatus {
  std::int64_t read_until_ns = 0;               ///< Stamp of the last packet that was looked at; 0: none yet.
  int stops = 0;                                ///< Complete ones.
  std::optional<RestNow> rest;                  ///< The one that goes on.
  std::map<int, std::uint64_t> points_in_rest;  ///< By sensor, of the stop that goes on; they lag it by up to 2 s.
  std::optional<Error> failure;                 ///< The reading has ended by this.
};

/// Finds the stops of a session while it is recorded: a thread of low priority reads the packets behind the recorder
/// and puts them through the same code as `calibrate` does later, so that both find the same, to the bit. The capture
/// never waits for it, and what it is too slow for comes later.
///
///   LiveStops stops(source, recorder.progress(), sink);   // the sink is called in the thread of `stops`
///   for (const LiveStopEvent& event : stops.take_events()) ...
///   recorder.close();
///   const Expected<StopReading> all = stops.finish();
class LiveStops {
 public:
  /// `source` is the session that is being recorded. `sink` gets the points of the stops as `read_stops` would give
  /// them, must outlive this, and is called from one thread, not that of the caller; where it takes long, the events
  /// come late.
  LiveStops(StreamSource source, std::shared_ptr<RecordingProgress> progress, StopSink& sink);
  /// Ends at once; the stop that goes on is given up.
  ~LiveStops();
  LiveStops(const LiveStops&) = delete;
  LiveStops& operator=(const LiveStops&) = delete;

  /// Those since the last call, in order. From any thread.
  [[nodiscard]] std::vector<LiveStopEvent> take_events();
  [[nodiscard]] LiveStopStatus status() const;

  [[nodiscard]] const Heartbeat& heartbeat() const;

  /// Waits until the recording has ended and is read to its end; gives what `read_stops` gives for the session (for all
  /// that was recorded, where only the newest packets are kept), and the sink has got the same. Where only the end
  /// shows how it has to be read, it is read once more, from what is kept then, into the same sink, after its
  /// `restart`. To be called once. Errors: as of `read_stops`.
  [[nodiscard]] Expected<StopReading> finish(const RunContext& context);

 private:
  class Reading;
  std::unique_ptr<Reading> reading_;
};

}  // namespace rigcal
