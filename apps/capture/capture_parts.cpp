#include "apps/capture/capture_parts.h"

#include <filesystem>
#include <utility>

#include "apps/capture/disk_watch.h"
#include "core/base/version.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

// Of a service that is started again and again nothing would be left but empty sessions, and LiDARs that start and
// stop.
Expected<void> check_room(const std::string& session) {
  // The name may end with a slash.
  std::string folder = std::filesystem::path(session + "/").parent_path().parent_path().string();
  if (folder.empty()) folder = ".";
  const auto free = free_bytes(folder);
  if (!free || *free >= DiskForecast::kReserveBytes) return {};
  return system_error(
      "the disk is full but for " + std::to_string(*free >> 20U) + " MiB: nothing can be recorded there", folder,
      "make room or choose another disk");
}

Expected<void> make_session(const std::string& session, const Rig& rig, const livox::Driver& driver) {
  SessionRecord begun;
  begun.software = version();
  begun.start_ns = driver.session_start().realtime_ns;
  return create_session(session, rig, begun);
}

Expected<void> start_cameras(CaptureParts& parts, const Rig& rig, const std::string& session) {
  CameraDrivers drivers(camera_settings_folder());
  for (const RigCamera& wanted : rig_cameras(rig)) {
    auto camera = CameraRecorder::start(wanted, drivers, session, parts.driver->session_start());
    if (!camera) return camera.error();
    parts.cameras.push_back(*std::move(camera));
  }
  return {};
}

Expected<void> start_trigger(CaptureParts& parts, const Rig& rig, const std::string& session, Reporter& reporter) {
  const auto lines = trigger_options(rig);
  if (!lines) return {};
  std::vector<CameraRecorder*> told;
  for (const auto& camera : parts.cameras) told.push_back(camera.get());
  auto started = TriggerRecorder::start(*lines, session, parts.driver->session_start(), std::move(told));
  if (started) {
    parts.trigger = *std::move(started);
    return {};
  }
  if (started.error().kind != ErrorKind::system) return started.error();
  parts.no_trigger = started.error().message();  // The LiDARs, and cameras that run free, are worth recording.
  reporter.warn(parts.no_trigger);
  return {};
}

void start_stops(CaptureParts& parts, const Rig& rig, const CaptureOptions& options) {
  StreamSource source;
  source.path = options.out;
  source.file = session_packets_path(options.out);
  source.rig = rig;
  parts.no_points = std::make_unique<NoPoints>();
  parts.stops = std::make_unique<LiveStops>(std::move(source), parts.recording->progress(),
                                            options.sink != nullptr ? *options.sink : *parts.no_points);
}

}  // namespace

Expected<CaptureParts> CaptureParts::start(const Rig& rig, const livox::DriverOptions& driver_options,
                                           const CaptureOptions& options, Reporter& reporter) {
  std::error_code error;
  if (std::filesystem::exists(options.out, error))  // Before a LiDAR is taken.
    return input_error("exists already, and a session is never overwritten", options.out, "choose another name");
  if (const auto room = check_room(options.out); !room) return room.error();
  CaptureParts parts;
  auto driver = livox::Driver::start(driver_options);
  if (!driver) return driver.error();
  parts.driver = *std::move(driver);
  std::unique_ptr<turntable::Table> turns;  // Before a session is made.
  if (const auto wanted = table_options(rig)) {
    auto started = turntable::Table::start(*wanted, parts.driver->session_start());
    if (!started) return started.error();
    turns = *std::move(started);
  }
  if (const auto made = make_session(options.out, rig, *parts.driver); !made) return made.error();
  auto recorder = PacketRecorder::create(options.out, options.keep_bytes);
  if (!recorder) return recorder.error();
  if (turns) {
    auto made = TableRecorder::create(std::move(turns), options.out);
    if (!made) return made.error();
    parts.table = *std::move(made);
  }
  parts.recording = std::make_unique<PacketTaker>(*parts.driver, *std::move(recorder), rig);
  for (const std::string& note : parts.driver->notes()) reporter.warn(note);
  if (const auto started = start_cameras(parts, rig, options.out); !started) return started.error();
  if (const auto started = start_trigger(parts, rig, options.out, reporter); !started) return started.error();
  start_stops(parts, rig, options);
  parts.keeper = std::make_unique<SessionKeeper>(options.out);
  return parts;
}

void CaptureParts::finish_recording(const DiskPatience& patience) {
  if (trigger != nullptr) {
    const DiskWait wait(patience, "the pulses", nullptr);
    trigger->finish();
  }
  for (const auto& camera : cameras) camera->stop();
  driver->stop();
  {
    const DiskWait wait(patience, "the packets", &recording->heartbeat());
    recording->finish();
  }
  for (const auto& camera : cameras) {
    const DiskWait wait(patience, "the images of " + camera->status().sensor, &camera->writing());
    camera->finish();
  }
  const DiskWait wait(patience, "session.json", nullptr);
  keeper->stop_writing();
}

std::vector<std::string> CaptureParts::camera_names() const {
  std::vector<std::string> names;
  for (const auto& camera : cameras) names.push_back(camera->status().sensor);
  return names;
}

std::vector<const Heartbeat*> CaptureParts::heartbeats() const {
  std::vector<const Heartbeat*> beats{&recording->heartbeat(), &keeper->heartbeat()};
  for (const auto& camera : cameras) beats.insert(beats.end(), {&camera->taking(), &camera->writing()});
  for (const Heartbeat* beat : driver->heartbeats()) beats.push_back(beat);
  if (trigger != nullptr) {
    for (const Heartbeat* beat : trigger->heartbeats()) beats.push_back(beat);
  }
  if (table != nullptr) beats.push_back(&table->heartbeat());
  beats.push_back(&stops->heartbeat());
  return beats;
}

}  // namespace rigcal
