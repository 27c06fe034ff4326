#include "apps/packet_recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

#include "apps/lidar_ingest.h"
#include "core/base/parallel.h"
#include "core/io/pcap_reader.h"
#include "core/stops/stop_finder.h"

namespace rigcal {
namespace {

// Points of the stops into cells, several sensors at once: each has its own builder and gets its points in order.
class CellSink final : public PatchSink {
 public:
  CellSink(const std::vector<int>& lidar_of_sensor, const CellOptions& options, LidarRecording& out)
      : lidar_of_sensor_(lidar_of_sensor), options_(options), out_(out), pending_(out.lidar_sensors.size()) {}

  void points(int sensor, int stop, std::span<const Point> points) override {
    const int lidar = lidar_of_sensor_[static_cast<std::size_t>(sensor)];
    if (stop != stop_) begin(stop);
    auto& pending = pending_[static_cast<std::size_t>(lidar)];
    pending.insert(pending.end(), points.begin(), points.end());
    waiting_ += points.size();
    if (waiting_ > 400'000) sum_up();
  }

  void stop_done(const StopRecord& record) override {
    if (stop_ != record.stop.index) begin(record.stop.index);
    sum_up();
    std::vector<PatchCells> patches(builders_.size());
    parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) patches[i] = builders_[i].finish();
    });
    for (PatchCells& patch : patches) {
      patch.stop = static_cast<int>(out_.stops.size());
      points_ += patch.points;
      if (patch.points > 0) out_.patches.push_back(std::move(patch));
    }
    out_.stops.push_back(record.stop);
    records_.push_back(record);
    stop_ = -1;
  }

  [[nodiscard]] const std::vector<StopRecord>& records() const { return records_; }
  [[nodiscard]] std::uint64_t points() const { return points_; }

 private:
  void begin(int stop) {
    stop_ = stop;
    builders_.clear();
    for (std::size_t i = 0; i < pending_.size(); ++i) {
      builders_.emplace_back(static_cast<int>(i), stop, options_);
      pending_[i].clear();
    }
    waiting_ = 0;
  }

  void sum_up() {
    parallel_for(builders_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        builders_[i].add(pending_[i]);
        pending_[i].clear();
      }
    });
    waiting_ = 0;
  }

  const std::vector<int>& lidar_of_sensor_;
  CellOptions options_;
  LidarRecording& out_;
  int stop_ = -1;
  std::vector<CellBuilder> builders_;
  std::vector<std::vector<Point>> pending_;
  std::size_t waiting_ = 0;
  std::uint64_t points_ = 0;
  std::vector<StopRecord> records_;
};

struct Pass {
  LidarRecording lidar;
  std::uint64_t points = 0;
  std::vector<StopRecord> stops;
  StillFigures still;
  bool cut = false;
};

// The gyro's rotations in the base's axes. A unit in another sensor turns about its own axes: its guess carries them
// over.
void take_rotations(const Rig& rig, Pass& pass) {
  pass.lidar.R_previous_this.resize(pass.stops.size());
  for (std::size_t j = 1; j < pass.stops.size(); ++j) {
    const StopRecord& record = pass.stops[j];
    if (!record.rotation_known || record.imu_sensor < 0) continue;
    if (record.imu_sensor == rig.base) {
      pass.lidar.R_previous_this[j] = record.R_previous_this;
      continue;
    }
    const auto& guess = rig.sensors[static_cast<std::size_t>(record.imu_sensor)].initial_T_base_sensor;
    if (guess) pass.lidar.R_previous_this[j] = guess->R * record.R_previous_this * guess->R.transpose();
  }
}

std::string seconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", s);
  return text;
}

Error never_still(const StillFigures& figures, const std::string& path) {
  if (figures.imu_samples == 0) {
    return input_error("no gyro reading in it, so its stops cannot be found", path,
                       "record with the IMU of the AVIA switched on (imu: true in the rig file), or give patches");
  }
  char text[120];
  std::snprintf(text, sizeof text, "the rig never stands still (longest rest %.2f s, gyro noise %.3f deg/s)",
                figures.longest_still_s, to_deg(figures.gyro_noise_rad_s));
  return input_error(text, path, "let it rest for a second or more at each stop");
}

class DumpReader {
 public:
  DumpReader(const Rig& rig, const std::string& path, const CellOptions& cells, const RunContext& context)
      : rig_(rig), path_(path), cells_(cells), context_(context), lidar_of_sensor_(rig.sensors.size(), -1) {
    for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
      if (!rig.sensors[k].is_lidar()) continue;
      lidar_of_sensor_[k] = static_cast<int>(lidar_sensors_.size());
      lidar_sensors_.push_back(static_cast<int>(k));
    }
    std::error_code ec;
    bytes_ = static_cast<double>(std::filesystem::file_size(path, ec));
  }

  Expected<Pass> read() {
    BroadcastCodes codes;
    for (int attempt = 0;; ++attempt) {
      Pass pass;
      pass.lidar.lidar_sensors = lidar_sensors_;
      CellSink sink(lidar_of_sensor_, cells_, pass.lidar);
      StopFinder finder(StopOptions{}, sink);
      LidarIngest ingest(
          rig_, [&](PointBatch& batch) { finder.add_points(batch); },
          [&](const ImuSample& sample) { finder.add_imu(sample); }, codes);
      if (const auto done = feed(ingest, pass); !done) return done.error();
      finder.flush();
      if (ingest.learned_too_late() && attempt == 0) {
        codes = ingest.codes();
        continue;
      }
      const Expected<IngestSummary> summary = ingest.finish();
      if (!summary) {
        Error error = summary.error();
        if (error.where.empty()) error.where = path_;
        return error;
      }
      for (const std::string& warning : summary->warnings) context_.reporter.warn(path_ + ": " + warning);
      if (pass.cut) context_.reporter.warn(cut_);
      warn_of_drops(finder.point_counts());
      pass.points = sink.points();
      pass.stops = sink.records();
      pass.still = finder.figures();
      return pass;
    }
  }

 private:
  Expected<void> feed(LidarIngest& ingest, Pass& pass) {
    Expected<PcapReader> reader = PcapReader::open(path_);
    if (!reader) return reader.error();
    Datagram datagram;
    double read = 0.0;
    for (std::uint64_t count = 0;; ++count) {
      const Expected<bool> more = reader->next(datagram);
      if (!more) return more.error();
      if (!*more) break;
      ingest.add(datagram);
      read += static_cast<double>(datagram.bytes.size()) + 60.0;
      if (count % 4096 == 0) {
        if (context_.cancelled())
          return Error{ErrorKind::cancelled, "stopped while reading, nothing was written", {}, {}};
        context_.reporter.progress("reading", std::min(1.0, read / bytes_));
      }
    }
    pass.cut = reader->truncated();
    cut_ = reader->truncation() + "; what is whole before it is used";
    context_.reporter.progress("reading", 1.0);
    return {};
  }

  void warn_of_drops(const PointCounts& counts) {
    const std::uint64_t overflow = counts.dropped[static_cast<std::size_t>(DropReason::overflow)];
    if (overflow > 0) {
      context_.reporter.warn(path_ + ": " + std::to_string(overflow) +
                             " points left out because one sensor's clock lags the others by seconds");
    }
  }

  const Rig& rig_;
  const std::string& path_;
  CellOptions cells_;
  const RunContext& context_;
  std::vector<int> lidar_of_sensor_;
  std::vector<int> lidar_sensors_;
  double bytes_ = 1.0;
  std::string cut_;
};

}  // namespace

Expected<Recording> read_packets(Rig rig, const std::string& path, const CellOptions& cells,
                                 const RunContext& context) {
  Expected<Pass> pass = DumpReader(rig, path, cells, context).read();
  if (!pass) return pass.error();
  if (pass->stops.empty()) return never_still(pass->still, path);
  if (pass->points == 0) return input_error("no points while the rig stood still", path, "check that sampling was on");
  take_rotations(rig, *pass);
  for (const StopRecord& record : pass->stops) {
    if (!record.rotation_known) {
      context.reporter.warn(path + ": gyro readings are missing before stop " + std::to_string(record.stop.index) +
                            ", its rotation is searched for");
    }
  }
  const double first = static_cast<double>(pass->stops.front().stop.end_ns - pass->stops.front().stop.start_ns) * 1e-9;
  context.reporter.debug(path + ": " + std::to_string(pass->stops.size()) + " stops, the first of " + seconds(first));
  Recording out;
  out.rig = std::move(rig);
  out.lidar = std::move(pass->lidar);
  out.points = pass->points;
  return out;
}

}  // namespace rigcal
