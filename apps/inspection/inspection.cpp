#include "apps/inspection/inspection.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/recording/bag_batches.h"
#include "apps/recording/cloud_flaws.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/io/foreign_file.h"
#include "core/io/image_folder.h"
#include "core/io/patch_folder.h"
#include "core/io/pcd_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

Inspection gap_json(const StreamGap& gap) {
  return {{"start_ns", gap.start_ns}, {"seconds", seconds_of_ns(gap.length_ns)}, {"packets", gap.lost}};
}

Inspection stream_json(const StreamBook& stream, double seconds) {
  const double expected = static_cast<double>(std::max<std::uint64_t>(stream.expected(), 1));
  Inspection gaps = Inspection::array();
  for (const StreamGap& gap : stream.listed_gaps) gaps.push_back(gap_json(gap));
  return {{"packets", stream.received},
          {"packets_per_s", seconds > 0.0 ? static_cast<double>(stream.received) / seconds : 0.0},
          {"expected", stream.expected()},
          {"lost", stream.lost},
          {"lost_share", static_cast<double>(stream.lost) / expected},
          {"duplicates", stream.duplicated},
          {"out_of_order", stream.out_of_order},
          {"damaged", stream.damaged},
          {"too_late", stream.too_late},
          {"restarts", stream.restarts},
          {"gaps", stream.gaps},
          {"longest_gap", gap_json(stream.longest_gap)},
          {"listed_gaps", gaps},
          {"gaps_not_listed", stream.gaps - stream.listed_gaps.size()}};
}

/// What devices and topics have in common; the seconds from the first to the last that was heard.
template <class Source>
double put_source(const Rig& rig, const Source& source, Inspection& json) {
  const double seconds = seconds_of_ns(source.last_ns - source.first_ns);
  if (source.sensor >= 0) json["sensor"] = rig.sensors[static_cast<std::size_t>(source.sensor)].name;
  json["seconds"] = seconds;
  json["malformed"] = source.malformed;
  json["points"] = source.points;
  json["noise"] = source.noise;
  json["out_of_range"] = source.out_of_range;
  json["imu_samples"] = source.imu_samples;
  return seconds;
}

Inspection device_json(const Rig& rig, const DeviceIngest& device) {
  Inspection json{{"ip", to_string(device.ip)}};
  if (!device.broadcast_code.empty()) json["broadcast_code"] = device.broadcast_code;
  const double seconds = put_source(rig, device, json);
  json["shots"] = device.shots;
  json["repeated"] = device.repeated;
  json["point_packets"] = stream_json(device.point_stream, seconds);
  json["imu_packets"] = stream_json(device.imu_stream, seconds);
  if (!device.control_frames.empty()) json["control_frames"] = device.control_frames;
  json["clock"] = {{"drift_ppm", device.clock.drift_ppm},
                   {"jitter_us", 1e-3 * device.clock.jitter_ns},
                   {"max_delay_us", 1e-3 * device.clock.max_delay_ns},
                   {"jumps", device.clock.jumps},
                   {"strays", device.clock.strays}};
  return json;
}

Inspection devices_json(const Rig& rig, const IngestSummary& ingest) {
  Inspection devices = Inspection::array();
  for (const DeviceIngest& device : ingest.devices) devices.push_back(device_json(rig, device));
  return devices;
}

Inspection frames_json(const PcapCounters& frames) {
  return {{"read", frames.frames},
          {"ipv6", frames.ipv6},
          {"not_udp", frames.not_udp},
          {"cut", frames.cut},
          {"other_link", frames.other_link},
          {"malformed", frames.malformed},
          {"fragments", frames.parts.fragments},
          {"put_together", frames.parts.whole},
          {"not_put_together", frames.parts.lost()}};
}

/// The extrinsics that an .lvx file holds, of the devices for which somebody entered some.
Inspection file_extrinsics_json(const std::vector<LvxDevice>& devices) {
  Inspection json = Inspection::array();
  for (const LvxDevice& device : devices) {
    const std::array<float, 3>& angles = device.roll_pitch_yaw_deg;
    const std::array<float, 3>& shift = device.translation_m;
    const auto finite = [](float value) { return std::isfinite(value); };
    const auto set = [](float value) { return value != 0.0F; };
    if (!std::all_of(angles.begin(), angles.end(), finite) || !std::all_of(shift.begin(), shift.end(), finite))
      continue;
    if (std::none_of(angles.begin(), angles.end(), set) && std::none_of(shift.begin(), shift.end(), set)) continue;
    json.push_back({{"broadcast_code", device.broadcast_code},
                    {"in_use", device.has_extrinsics},
                    {"roll_pitch_yaw_deg", angles},
                    {"translation", shift}});
  }
  return json;
}

void add_notes(const FileNotes& notes, Inspection& json) {
  if (notes.frames) json["frames"] = frames_json(*notes.frames);
  if (!notes.lvx_devices.empty()) json["file_extrinsics"] = file_extrinsics_json(notes.lvx_devices);
}

Inspection topic_json(const Rig& rig, const TopicIngest& topic) {
  Inspection json{{"topic", topic.topic}, {"type", topic.type}};
  const double seconds = put_source(rig, topic, json);
  json["messages"] = topic.messages;
  json["messages_per_s"] = seconds > 0.0 ? static_cast<double>(topic.messages - 1) / seconds : 0.0;
  json["lost"] = topic.lost;
  json["not_finite"] = topic.not_finite;
  json["untimed"] = topic.untimed;
  return json;
}

/// What was heard: the devices of datagrams, or the topics of a bag.
void put_sources(const Rig& rig, const StopReading& reading, Inspection& json) {
  const IngestSummary& ingest = reading.ingest;
  if (!ingest.topics.empty()) {
    json["topics"] = Inspection::array();
    for (const TopicIngest& topic : ingest.topics) json["topics"].push_back(topic_json(rig, topic));
    return;
  }
  json["datagrams"] = ingest.datagrams;
  json["not_livox"] = ingest.not_livox;
  add_notes(reading.notes, json);
  json["devices"] = devices_json(rig, ingest);
}

Inspection stop_json(const Rig& rig, const StopRecord& stop) {
  Inspection points = Inspection::object();
  for (const auto& [sensor, count] : stop.points) points[rig.sensors[static_cast<std::size_t>(sensor)].name] = count;
  return {{"stop", stop.stop.index},
          {"start_ns", stop.stop.start_ns},
          {"end_ns", stop.stop.end_ns},
          {"seconds", seconds_of_ns(stop.stop.end_ns - stop.stop.start_ns)},
          {"turned_deg", to_deg(log_so3(stop.R_previous_this).norm())},
          {"turn_known", stop.rotation_known},
          {"ended_by", to_string(stop.end)},
          {"points", points}};
}

Inspection gyro_json(const Rig& rig, const StopReading& summary) {
  Inspection json{{"samples", summary.gyro.imu_samples},
                  {"unusable", summary.gyro.imu_unusable},
                  {"noise_deg_s", to_deg(summary.gyro.gyro_noise_rad_s)},
                  {"longest_rest_s", summary.gyro.longest_still_s},
                  {"brief_rests", summary.gyro.brief_rests},
                  {"longest_brief_rest_s", summary.gyro.longest_brief_rest_s}};
  if (summary.source == StopSource::gyro && !summary.stops.empty()) {
    const StopRecord& last = summary.stops.back();
    json["sensor"] = rig.sensors[static_cast<std::size_t>(last.sensor)].name;
    json["bias_deg_s"] = {to_deg(last.gyro_bias_rad_s.x()), to_deg(last.gyro_bias_rad_s.y()),
                          to_deg(last.gyro_bias_rad_s.z())};
  }
  return json;
}

Inspection view_json(const PointStillFigures& view) {
  return {{"points", view.points},
          {"rests", view.stops},
          {"resolution_deg", to_deg(view.resolution_rad)},
          {"longest_rest_s", view.longest_still_s},
          {"blind_s", view.blind_s}};
}

/// Whether calibrate takes a camera's images from a folder of this name.
bool is_of_camera(const std::string& folder, const Rig& rig) {
  const auto has_images_there = [&](const Sensor& sensor) {
    return sensor.camera && (sensor.name == folder || sensor.folder == folder);
  };
  return std::any_of(rig.sensors.begin(), rig.sensors.end(), has_images_there);
}

std::uint64_t image_files(const std::string& folder) {
  std::error_code error;
  std::uint64_t count = 0;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error))
    count += is_image_name(file->path().filename().string()) ? 1 : 0;
  return count;
}

/// False, with the reason as calibrate gives it, where no image of the folder can be used. None is opened.
bool check_images(const std::string& camera, const std::string& folder, std::vector<std::string>& warnings) {
  const std::string unusable = "the images of " + camera + " cannot be used: ";
  const Expected<ImageFolder> listed = list_image_folder(folder);
  if (!listed) {
    warnings.push_back(unusable + listed.error().message());
    return false;
  }
  if (!listed->torn.empty()) warnings.push_back(listed->torn);
  if (listed->images.empty()) {  // As of a capture that ended before the first: nothing is damaged.
    const std::string hint = hint_of_unknown(folder, *listed);
    warnings.push_back("no image of " + camera + " is there: its folder " + folder + " holds none" +
                       (hint.empty() ? "" : "; " + hint));
    return true;
  }
  std::error_code error;
  const auto is_missing = [&](const ListedImage& image) { return !fs::exists(image.path, error); };
  const auto missing = std::count_if(listed->images.begin(), listed->images.end(), is_missing);
  if (missing == 0) return true;
  const auto first = std::find_if(listed->images.begin(), listed->images.end(), is_missing);
  const std::string what = std::to_string(missing) + " of the " + std::to_string(listed->images.size()) +
                           " images in frames.csv are missing, the first: " + first->path;
  const bool none = missing == static_cast<std::ptrdiff_t>(listed->images.size());
  warnings.push_back(none ? unusable + what : camera + ": " + what);
  return !none;
}

struct FoundImages {
  Inspection json = Inspection::object();  ///< Files by camera.
  bool usable = true;                      ///< False: none of a camera's can be used.
};

/// Of a camera those count that lie in the first of the places, as calibrate looks for them.
FoundImages find_images(const std::vector<fs::path>& places, const Rig& rig, std::vector<std::string>& warnings) {
  std::map<std::string, std::string> folders;
  for (const fs::path& place : places) {
    std::error_code error;
    for (fs::directory_iterator camera(place, error), end; !error && camera != end; camera.increment(error)) {
      if (camera->is_directory(error)) folders.emplace(camera->path().filename().string(), camera->path().string());
    }
  }
  FoundImages found;
  for (const auto& [camera, folder] : folders) {
    found.json[camera] = {{"files", image_files(folder)}};
    if (is_of_camera(camera, rig) && !check_images(camera, folder, warnings)) found.usable = false;
  }
  return found;
}

Expected<Rig> rig_of_folders(const std::string& path) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    if (!entry->is_directory(error)) continue;
    const bool has_clouds = std::any_of(
        fs::directory_iterator(entry->path(), error), fs::directory_iterator(),
        [](const fs::directory_entry& file) { return small_letters(file.path().extension().string()) == ".pcd"; });
    if (has_clouds) names.push_back(entry->path().filename().string());
  }
  // Images alone are of a rig without LiDARs.
  if (names.empty() && !fs::is_directory(fs::path(path) / "image", error)) {
    if (auto foreign = foreign_folder_error(path)) return *std::move(foreign);
    return input_error("holds neither a session, a result nor patches", path,
                       "a patch folder has one folder of .pcd files a sensor");
  }
  std::sort(names.begin(), names.end());
  Rig rig;
  for (const std::string& name : names) {
    Sensor sensor;
    sensor.name = name;
    sensor.lidar.emplace();
    rig.sensors.push_back(std::move(sensor));
  }
  for (fs::directory_iterator entry(fs::path(path) / "image", error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->is_directory(error)) continue;
    Sensor sensor;
    sensor.name = entry->path().filename().string();
    sensor.camera.emplace();
    rig.sensors.push_back(std::move(sensor));
  }
  return rig;
}

}  // namespace

Inspection begin_inspection(const char* kind, const std::string& path) {
  return {{"rigcal", format_version}, {"command", "inspect"}, {"kind", kind}, {"path", path}};
}

Expected<Inspection> inspect_stream(const std::string& path, const RunContext& context) {
  StreamSource source;
  source.path = path;
  source.file = path;
  NoPoints sink;
  const Expected<StopReading> summary = read_stops(source, {}, sink, context);
  if (!summary) return summary.error();
  if (summary->ingest.devices.empty() && summary->ingest.topics.empty()) {
    warn_of_file(source, *summary, context.reporter);
    if (is_bag(path)) return input_error("holds no message", path, "record or copy it again");
    return input_error("holds no Livox packet", path, "record the UDP traffic of the LiDARs, ports 55000 to 65000");
  }
  Inspection json = begin_inspection(is_bag(path) ? "bag" : "dump", path);
  json["complete"] = summary->truncation.empty();
  put_sources(source.rig, *summary, json);
  json["warnings"] = reading_warnings(source, *summary);
  return json;
}

Expected<Inspection> inspect_recording(const StreamSource& source, const RunContext& context) {
  NoPoints sink;
  const StopOptions options;
  const Expected<StopReading> summary = read_stops(source, options, sink, context);
  if (!summary) return summary.error();
  const std::optional<Error> no_lidar = no_lidar_error(source);
  if (!no_lidar && summary->ingest.devices.empty() && summary->ingest.topics.empty()) {
    warn_of_file(source, *summary, context.reporter);
    return *reading_error(source, options, *summary);
  }
  const char* file_kind = is_bag(source.file) ? "bag" : "dump";
  Inspection json = begin_inspection(source.path == source.file ? file_kind : "session", source.path);
  json["complete"] = source.complete && summary->truncation.empty();
  put_sources(source.rig, *summary, json);
  json["stops_from"] = summary->source == StopSource::gyro ? "gyro" : "points";
  if (summary->gyro.imu_samples > 0) json["gyro"] = gyro_json(source.rig, *summary);
  json["view"] = view_json(summary->view);
  json["stops"] = Inspection::array();
  for (const StopRecord& stop : summary->stops) json["stops"].push_back(stop_json(source.rig, stop));
  Inspection dropped = Inspection::object();
  for (std::size_t i = 0; i < drop_reasons; ++i) {
    dropped[to_string(static_cast<DropReason>(i))] = summary->points.dropped[i];
  }
  std::vector<std::string> warnings = reading_warnings(source, *summary);
  if (source.path != source.file) {
    FoundImages images = find_images({fs::path(source.path) / "images"}, source.rig, warnings);
    json["images"] = std::move(images.json);
    if (!images.usable) json["complete"] = false;
  }
  json["points"] = {{"in_stops", summary->points.in_stops}, {"dropped", dropped}};
  if (const std::optional<Error> error = no_lidar ? no_lidar : reading_error(source, options, *summary)) {
    warnings.push_back("not fit for calibrate: " + error->what);
  }
  json["warnings"] = warnings;
  return json;
}

namespace {

/// `trajectory_path` may be empty, as for `list_patch_folder`.
Expected<Inspection> inspect_patch_folder(const std::string& path, const Rig& rig, const std::string& trajectory_path,
                                          const std::vector<fs::path>& image_places, const RunContext& context) {
  const Expected<PatchFolder> folder = list_patch_folder(path, rig, trajectory_path);
  if (!folder) return folder.error();
  std::vector<std::string> warnings;
  std::map<int, Inspection> stops;
  for (const int stop : folder->stops) stops[stop] = {{"stop", stop}, {"points", Inspection::object()}};
  double done = 0.0;
  for (std::size_t i = 0; i < folder->patches.size(); ++i) {
    CloudFlaws flaws;
    for (const PatchFile& file : folder->patches[i]) {
      if (context.cancelled()) return cancelled_error("stopped", path);
      const Expected<PcdSummary> cloud = read_pcd(file.path, [](std::span<const Point>) {});
      if (!cloud) return cloud.error();
      stops[file.stop]["points"][rig.sensors[i].name] = cloud->points;
      flaws.add(*cloud);
      if (cloud->size_missing) warnings.push_back("WIDTH or HEIGHT is 0 in clouds of " + rig.sensors[i].name);
    }
    for (std::string& warning : flaws.warnings(rig.sensors[i].name)) warnings.push_back(std::move(warning));
    context.reporter.progress("reading patches", ++done / static_cast<double>(folder->patches.size()));
  }
  warnings.erase(std::unique(warnings.begin(), warnings.end()), warnings.end());
  for (std::string& reason : reasons_of_unknown(*folder)) warnings.push_back(std::move(reason));
  Inspection json = begin_inspection("patches", path);
  json["trajectory"] = folder->trajectory.has_value();
  json["stops"] = Inspection::array();
  for (auto& [stop, entry] : stops) json["stops"].push_back(std::move(entry));
  FoundImages images = find_images(image_places, rig, warnings);
  if (!images.json.empty()) json["images"] = std::move(images.json);
  if (!images.usable) json["complete"] = false;
  json["warnings"] = warnings;
  return json;
}

}  // namespace

Expected<Inspection> inspect_patches(const std::string& path, const std::string& rig_path, const RunContext& context) {
  const Expected<Rig> rig = rig_path.empty() ? rig_of_folders(path) : load_rig(rig_path);
  if (!rig) return rig.error();
  return inspect_patch_folder(path, *rig, {}, {fs::path(path) / "image"}, context);
}

Expected<Inspection> inspect_patch_session(const SessionFolder& session, const std::string& rig_path,
                                           const RunContext& context) {
  const Expected<Rig> rig = rig_path.empty() ? Expected<Rig>(session.rig) : load_rig(rig_path);
  if (!rig) return rig.error();
  const fs::path folder(session.path);
  const std::vector<fs::path> image_places{folder / "images", folder / "patches" / "image", folder / "image"};
  Expected<Inspection> json = inspect_patch_folder(session.patches, *rig, session.trajectory, image_places, context);
  if (!json) return json;
  (*json)["kind"] = "session";
  (*json)["path"] = session.path;
  // Without a session.json nobody says that it was cut short, and each patch is whole as it is.
  const bool has_end = !session.record || session.record->end_ns;
  (*json)["complete"] = has_end && json->value("complete", true);
  if (has_end) return json;
  (*json)["warnings"].push_back(session.path + " has no end: the recording that it was made from was cut short");
  for (const std::string& gap : session.record->gaps) (*json)["warnings"].push_back(gap);
  return json;
}

}  // namespace rigcal
