#include "apps/exchange/session_import.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>

#include "apps/exchange/image_files.h"
#include "apps/exchange/patch_export.h"
#include "apps/exchange/session_images.h"
#include "apps/ingest/lidar_ingest.h"
#include "apps/recording/bag_batches.h"
#include "apps/recording/datagram_file.h"
#include "apps/recording/lvx_datagrams.h"
#include "apps/recording/recorded_formats.h"
#include "apps/recording/session_counters.h"
#include "core/base/version.h"
#include "core/io/file_copy.h"
#include "core/io/files_below.h"
#include "core/io/output_file.h"
#include "core/io/patch_folder.h"
#include "core/io/pcapng_writer.h"
#include "core/io/session_folder.h"
#include "core/io/staged_folder.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

struct ImportTask {
  std::string input;
  std::string rig_path;
  std::string rig_text;
  std::string images;  ///< Where the cameras' images lie, if not with the recording.
  Rig rig;
  std::string folder;  ///< Of the session that is being made.
  const RunContext& context;
};

std::string below(const std::string& folder, const char* name) { return (fs::path(folder) / name).string(); }

/// With all that is in it, but for the folder `left_out`.
Expected<void> copy_folder(const fs::path& from, const fs::path& to, const fs::path& left_out) {
  const Expected<std::vector<std::string>> names = files_below(from, left_out);
  if (!names) return names.error();
  for (const std::string& name : *names) {
    const fs::path copy = to / name;
    std::error_code error;
    fs::create_directories(copy.parent_path(), error);
    if (error) return cannot_write(copy.parent_path().string(), error.value());
    if (const Expected<void> copied = copy_file((from / name).string(), copy.string()); !copied) return copied;
  }
  return {};
}

/// The path of what `name` becomes in `to`, where it is in `from`.
Expected<void> move_up(const std::string& from, const std::string& to, const char* name) {
  std::error_code error;
  if (!fs::exists(below(from, name), error)) return {};
  fs::rename(below(from, name), below(to, name), error);
  return error ? Expected<void>(cannot_write(below(to, name), error.value())) : Expected<void>{};
}

/// Returns how many images there are; none where they were not given.
Expected<std::uint64_t> import_images(const ImportTask& task, ImageNumbers numbers, const std::vector<Stop>& stops) {
  if (task.images.empty()) return std::uint64_t{0};
  return copy_images(task.images, numbers, stops, task.rig, task.folder, task.context);
}

/// A session that was cut has no end, as one that a power cut ended. `findings`: what else the session cannot tell of
/// its input any more.
Expected<void> write_record(const ImportTask& task, std::int64_t start_ns, std::int64_t end_ns,
                            SessionCounters counters, const std::string& truncation,
                            const std::vector<std::string>& findings = {}) {
  SessionRecord record;
  record.software = version();
  record.start_ns = start_ns;
  record.counters = std::move(counters);
  const std::string name = fs::path(task.input).filename().string();
  for (const std::string& finding : findings) record.gaps.push_back(name + ": " + finding);
  if (truncation.empty()) {
    record.end_ns = end_ns;
  } else {
    record.gaps.push_back(name + " " + truncation);
    task.context.reporter.warn(task.input + ": " + truncation);
  }
  return write_session_record(task.folder, record);
}

Expected<ImportSummary> import_datagrams(const ImportTask& task) {
  const Expected<std::unique_ptr<DatagramFile>> file = open_datagrams(task.input);
  if (!file) return file.error();
  Expected<PcapngWriter> writer = PcapngWriter::create(session_packets_path(task.folder));
  if (!writer) return writer.error();
  LidarIngest ingest(task.rig, {}, {});
  std::int64_t start_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t end_ns = 0;
  for (Datagram datagram;;) {
    const Expected<bool> more = (*file)->next(datagram);
    if (!more) return more.error();
    if (!*more) break;
    if (const Expected<void> written = writer->write(datagram); !written) return written.error();
    ingest.add(datagram);
    start_ns = std::min(start_ns, datagram.stamp_ns);
    end_ns = std::max(end_ns, datagram.stamp_ns);
    if (writer->datagrams() % 4096 != 0) continue;
    if (task.context.cancelled()) return cancelled_error("stopped", task.input);
    task.context.reporter.progress("importing", (*file)->fraction());
  }
  if (const Expected<void> synced = writer->sync(); !synced) return synced.error();
  if (const Expected<void> closed = writer->close(); !closed) return closed.error();
  // Ahead of what they may be the cause of.
  const std::vector<std::string> findings = (*file)->notes().findings;
  for (const std::string& finding : findings) task.context.reporter.warn(task.input + ": " + finding);
  const IngestSummary summary = ingest.summary();
  if (summary.unfit) {
    Error error = *summary.unfit;
    error.where = task.input;
    if (summary.devices.empty()) return error;
    task.context.reporter.warn("not fit for calibrate: " + error.message());
  }
  for (const std::string& warning : summary.warnings) task.context.reporter.warn(warning);
  const std::string truncation = (*file)->truncation();
  const Expected<void> record =
      write_record(task, start_ns, end_ns, session_counters(task.rig, summary), truncation, findings);
  if (!record) return record.error();
  const Expected<std::uint64_t> images = import_images(task, ImageNumbers::stamps, {});
  if (!images) return images.error();
  return ImportSummary{is_lvx(task.input) ? "lvx" : "dump", truncation.empty(), writer->datagrams(), 0, 0, *images};
}

Expected<ImportSummary> import_bag(const ImportTask& task) {
  StreamSource source;
  source.path = task.input;
  source.file = task.input;
  source.rig_path = task.rig_path;
  source.rig = task.rig;
  source.rig_text = task.rig_text;
  ImageFiles images(below(task.folder, "images"), task.rig);
  if (!task.images.empty()) images.take_none();
  const std::string patches = below(task.folder, "patches");
  const Expected<PatchExport> done = export_patches(source, PatchLayout::patches, patches, task.context, &images);
  if (!done) return done.error();
  // A session holds these beside its patches; the rig file may say otherwise than the one that was given.
  for (const char* name : {"trajectory.tum", "rig.yaml"}) {
    if (const Expected<void> moved = move_up(patches, task.folder, name); !moved) return moved.error();
  }
  std::vector<Stop> stops;
  for (const StopRecord& stop : done->reading.stops) stops.push_back(stop.stop);
  if (const Expected<void> finished = images.finish(stops); !finished) return finished.error();
  for (const std::string& warning : images.warnings()) task.context.reporter.warn(warning);
  const Expected<std::uint64_t> given = import_images(task, ImageNumbers::stamps, stops);
  if (!given) return given.error();
  const Expected<Rig> rig = load_rig(below(task.folder, "rig.yaml"));
  if (!rig) return rig.error();
  if (const auto named = name_formats(task.folder, *rig, images.missing_formats(), task.context.reporter); !named)
    return named.error();
  std::int64_t start_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t end_ns = 0;
  for (const TopicIngest& topic : done->reading.ingest.topics) {
    if (topic.messages == 0) continue;
    start_ns = std::min(start_ns, topic.first_ns);
    end_ns = std::max(end_ns, topic.last_ns);
  }
  const std::string& truncation = done->reading.truncation;
  const Expected<void> record =
      write_record(task, start_ns, end_ns, session_counters(task.rig, done->reading.ingest), truncation);
  if (!record) return record.error();
  return ImportSummary{
      "bag", truncation.empty(), 0, stops.size(), done->reading.points.in_stops, images.images() + *given};
}

/// Every cloud is read before it is copied, so that a damaged one is named now and not by calibrate.
Expected<ImportSummary> import_patches(const ImportTask& task) {
  const Expected<PatchFolder> folder = list_patch_folder(task.input, task.rig);
  if (!folder) return folder.error();
  ImportSummary summary{"patches", true, 0, folder->stops.size(), 0, 0};
  const fs::path out = below(task.folder, "patches");
  double done = 0.0;
  for (const std::vector<PatchFile>& files : folder->patches) {
    for (const PatchFile& file : files) {
      if (task.context.cancelled()) return cancelled_error("stopped", task.input);
      const Expected<PcdSummary> cloud = read_pcd(file.path, [](std::span<const Point>) {});
      if (!cloud) return cloud.error();
      summary.points += cloud->points;
      const fs::path from(file.path);
      const fs::path to = out / from.parent_path().filename();
      std::error_code error;
      fs::create_directories(to, error);
      if (error) return cannot_write(to.string(), error.value());
      const Expected<void> copied = copy_file(from.string(), (to / from.filename()).string());
      if (!copied) return copied.error();
    }
    task.context.reporter.progress("importing", ++done / static_cast<double>(folder->patches.size()));
  }
  std::error_code error;
  if (task.images.empty() && fs::is_directory(fs::path(task.input) / "image", error)) {
    const std::string image = below(task.input, "image");
    if (const Expected<void> copied = copy_folder(image, out / "image", task.folder); !copied) return copied.error();
    summary.images = count_images(image, task.rig, task.context.reporter);
  }
  const Expected<std::uint64_t> images = import_images(task, ImageNumbers::stops, {});
  if (!images) return images.error();
  summary.images += *images;
  if (folder->trajectory) {
    const Expected<void> copied = copy_file(below(task.input, "trajectory.tum"), below(task.folder, "trajectory.tum"));
    if (!copied) return copied.error();
  }
  for (const std::string& reason : reasons_of_unknown(*folder)) task.context.reporter.warn(task.input + ": " + reason);
  if (const Expected<void> record = write_record(task, 0, 0, {}, {}); !record) return record.error();
  return summary;
}

}  // namespace

Expected<ImportSummary> import_session(const RecordingPaths& from, const std::string& out, const RunContext& context) {
  const std::string& input = from.input;
  if (const auto fit = check_images(from); !fit) return fit.error();
  if (const auto there = check_there(input); !there) return there.error();
  std::error_code error;
  const bool folder = fs::is_directory(input, error);
  if (folder && is_session_folder(input)) {
    if (const Expected<SessionFolder> session = open_session(input); !session) return session.error();
    return input_error("is a session already", input, "calibrate it as it is");
  }
  const Expected<std::string> rig_file = folder ? rig_file_of_folder(input, from.rig) : from.rig;
  if (!rig_file) return rig_file.error();
  if (rig_file->empty()) return input_error("a recording needs the rig that made it", input, "add --rig RIG");
  Expected<RigFile> rig = load_rig_file(*rig_file);
  if (!rig) return rig.error();
  Expected<StagedFolder> staged = StagedFolder::create(out);
  if (!staged) return staged.error();
  if (const auto written = replace_file(below(staged->path(), "rig.yaml"), rig->text); !written) return written.error();
  const ImportTask task{input,          *rig_file, std::move(rig->text), from.images, std::move(rig->rig),
                        staged->path(), context};
  Expected<ImportSummary> summary =
      folder ? import_patches(task) : (is_bag(input) ? import_bag(task) : import_datagrams(task));
  if (!summary) return summary;
  warn_of_missing_images(task.rig, task.folder, task.images, context.reporter);
  if (const Expected<void> synced = staged->sync(); !synced) return synced.error();
  if (const Expected<void> done = staged->commit(); !done) return done.error();
  return summary;
}

}  // namespace rigcal
