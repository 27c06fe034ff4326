#include "apps/recording/bag_batches.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

#include "apps/ingest/point_filter.h"
#include "apps/ingest/unit_numbers.h"
#include "apps/recording/bag_topics.h"
#include "apps/recording/cloud_times.h"
#include "apps/recording/imu_queue.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/io/bag_reader.h"

namespace rigcal {
namespace {

constexpr int messages_at_once = 32;  // some milliseconds of work
constexpr std::int64_t lone_cloud_ns = 100'000'000;
constexpr std::int64_t long_untimed_ns = 250'000'000;
constexpr double worthy_loss = 1e-3;
// Standard gravity; a resting unit shows 1 in g and this in m/s^2, so their geometric mean tells them apart.
constexpr double gravity = 9.80665;

struct Topic {
  TopicIngest counts;
  const TopicWish* wish = nullptr;
  DeviceClock clock;
  PointFilter filter;
  const BagConnection* last_sender = nullptr;
  std::uint32_t last_seq = 0;
  CloudTimes times;
  std::optional<PointBatch> first;  ///< A cloud of which the next one tells how long it took.
  UnitNumbers lidar_ids;
  std::optional<double> acceleration_to_g;  ///< Nothing until the first reading.

  std::int64_t session_ns(std::int64_t sent_ns, std::int64_t recorded_ns) {
    const SessionStamp stamp = clock.add(sent_ns == 0 ? recorded_ns : sent_ns, recorded_ns);
    return stamp.stamp_ns;
  }

  void count_lost(const BagConnection* sender, std::uint32_t seq) {
    constexpr std::uint32_t believable = 100'000;  // a larger step is a sender that started anew
    const std::uint32_t step = seq - last_seq;
    if (sender == last_sender && step > 1 && step < believable) counts.lost += step - 1;
    last_sender = sender;
    last_seq = seq;
  }

  void fault(const Error& error) {
    if (++counts.malformed == 1) counts.first_fault = error.what;
  }
};

void warn_of(const TopicIngest& counts, std::vector<std::string>& warnings) {
  if (counts.malformed > 0) {
    warnings.push_back(counts.topic + ": " + std::to_string(counts.malformed) + " of " +
                       std::to_string(counts.messages) +
                       " messages could not be read, the first: " + counts.first_fault);
  }
  if (counts.not_finite > 0) {
    warnings.push_back(counts.topic + ": " + std::to_string(counts.not_finite) +
                       " points with NaN or infinite coordinates left out");
  }
  if (const std::string complaint = counts.intensity.complaint(); !complaint.empty()) {
    warnings.push_back(counts.topic + ": its " + complaint);
  }
  const auto sent = static_cast<double>(counts.messages + counts.lost);
  if (static_cast<double>(counts.lost) > worthy_loss * sent) {
    warnings.push_back(counts.topic + ": " + std::to_string(counts.lost) + " messages were lost on the way to the bag");
  }
  if (counts.clock.jumps > 0) {
    warnings.push_back(counts.topic + ": the clock of its sender jumped " + std::to_string(counts.clock.jumps) +
                       " time(s)");
  }
}

class BagBatches final : public BatchSource {
 public:
  BagBatches(BagReader bag, std::string path, const Rig& rig, BatchSinks sinks)
      : bag_(std::move(bag)),
        path_(std::move(path)),
        rig_(rig),
        wishes_(topic_wishes(rig)),
        sinks_(std::move(sinks)),
        imu_(sinks_.imu) {
    for (const TopicWish& wish : wishes_) {
      if (wish.use == TopicUse::points) imu_.wait_for(wish.sensor);
    }
  }

  /// What is wrong with the topics that are known so far.
  [[nodiscard]] std::optional<Error> topics_error() const {
    std::vector<TopicName> there;
    for (const auto& [number, connection] : bag_.connections()) {
      const bool known = std::any_of(there.begin(), there.end(),
                                     [&](const TopicName& name) { return name.topic == connection.topic; });
      if (!known) there.push_back({connection.topic, connection.type});
    }
    if (std::optional<Error> error = wish_error(rig_, wishes_, there)) return error;
    return absence_error(rig_, wishes_, there);
  }

  Expected<bool> read_some() override {
    BagMessage message;
    for (int i = 0; i < messages_at_once; ++i) {
      const Expected<bool> more = bag_.next(message);
      if (more && !*more) end();
      if (!more || !*more) return more;
      if (const Expected<void> taken = take(message); !taken) return taken.error();
      imu_.hand_on(message.stamp_ns);
    }
    return true;
  }
  [[nodiscard]] double fraction() const override { return bag_.fraction(); }
  [[nodiscard]] std::string truncation() const override { return bag_.truncation(); }
  [[nodiscard]] IngestSummary summary() const override;

 private:
  Expected<void> take(const BagMessage& message);
  Expected<Topic*> topic_of(const BagConnection& connection);
  void add_points(Topic& topic, const BagMessage& message, RosType type);
  void give_first(Topic& topic, std::int64_t span_ns);
  void end();
  void add_imu(Topic& topic, const BagMessage& message);
  void add_image(Topic& topic, const BagMessage& message, RosType type);
  [[nodiscard]] std::optional<Error> shared() const;
  [[nodiscard]] std::optional<Error> unusable() const;

  BagReader bag_;
  std::string path_;
  Rig rig_;
  std::vector<TopicWish> wishes_;
  BatchSinks sinks_;
  ImuQueue imu_;
  std::map<std::string, Topic> topics_;
  std::map<const BagConnection*, Topic*> by_sender_;
  RosCloud cloud_;
  PointBatch batch_;
};

Expected<Topic*> BagBatches::topic_of(const BagConnection& connection) {
  const auto known = by_sender_.find(&connection);
  if (known != by_sender_.end()) return known->second;
  Topic& topic = topics_[connection.topic];
  topic.counts.topic = connection.topic;
  topic.counts.type = connection.type;
  for (const TopicWish& wish : wishes_) {
    if (!is_same_topic(wish.topic, connection.topic)) continue;
    topic.wish = &wish;
    topic.counts.sensor = wish.sensor;
    const RosType type = ros_type(connection.type);
    if (!can_send(wish.use, type) || !is_known_layout(type, connection.md5)) {
      Error error = type_error(rig_, wish, {connection.topic, connection.type}, connection.md5);
      error.where = path_;
      return error;
    }
    const Sensor& sensor = rig_.sensors[static_cast<std::size_t>(wish.sensor)];
    if (wish.use == TopicUse::points) {
      topic.filter = PointFilter(sensor.is_livox(), sensor.lidar->range_m);
    }
  }
  by_sender_[&connection] = &topic;
  return &topic;
}

Expected<void> BagBatches::take(const BagMessage& message) {
  const Expected<Topic*> found = topic_of(*message.connection);
  if (!found) return found.error();
  Topic& topic = **found;
  TopicIngest& counts = topic.counts;
  if (counts.messages++ == 0) counts.first_ns = message.stamp_ns;
  counts.last_ns = std::max(counts.last_ns, message.stamp_ns);
  if (topic.wish == nullptr) return {};
  const RosType type = ros_type(message.connection->type);
  switch (topic.wish->use) {
    case TopicUse::points:
      add_points(topic, message, type);
      break;
    case TopicUse::imu:
      add_imu(topic, message);
      break;
    case TopicUse::images:
      add_image(topic, message, type);
      break;
  }
  return {};
}

void BagBatches::add_points(Topic& topic, const BagMessage& message, RosType type) {
  if (const Expected<void> decoded = decode_cloud(type, message.bytes, cloud_); !decoded) {
    topic.fault(decoded.error());
    return;
  }
  topic.count_lost(message.connection, cloud_.header.seq);
  topic.lidar_ids.add(cloud_.lidar_id);
  topic.counts.not_finite += cloud_.not_finite;
  topic.counts.intensity.add(cloud_.intensity);
  const bool known = topic.times.set(topic.clock, cloud_, message.stamp_ns, batch_);
  if (batch_.undivided) ++topic.counts.untimed;
  batch_.sensor = topic.wish->sensor;
  batch_.points.swap(cloud_.points);
  const PointFilter::LeftOut left_out = topic.filter.apply(batch_.points);
  topic.counts.noise += left_out.noise;
  topic.counts.out_of_range += left_out.out_of_range;
  topic.counts.points += batch_.points.size();
  give_first(topic, topic.times.usual_ns());
  if (!known) {
    topic.first = batch_;
  } else if (sinks_.points) {
    sinks_.points(batch_);
  }
  imu_.seen(topic.wish->sensor, topic.times.end_ns());
}

void BagBatches::give_first(Topic& topic, std::int64_t span_ns) {
  if (!topic.first) return;
  topic.first->shot_interval_ns = static_cast<double>(span_ns);
  topic.first->stamp_ns -= span_ns;
  if (sinks_.points) sinks_.points(*topic.first);
  topic.first.reset();
}

void BagBatches::end() {
  for (auto& [name, topic] : topics_) give_first(topic, lone_cloud_ns);
  imu_.flush();
}

void BagBatches::add_imu(Topic& topic, const BagMessage& message) {
  const Expected<RosImu> imu = decode_imu(message.bytes);
  if (!imu || !imu->has_gyro) {
    topic.fault(imu ? input_error("says that it has no rates") : imu.error());
    return;
  }
  topic.count_lost(message.connection, imu->header.seq);
  const std::int64_t stamp_ns = topic.session_ns(imu->header.stamp_ns, message.stamp_ns);
  const double length = imu->acceleration.norm();
  if (!topic.acceleration_to_g && length > 0.0) {
    topic.acceleration_to_g = length < std::sqrt(gravity) ? 1.0 : 1.0 / gravity;
  }
  ++topic.counts.imu_samples;
  imu_.add({topic.wish->sensor, stamp_ns, imu->gyro_rad_s, imu->acceleration * topic.acceleration_to_g.value_or(1.0)},
           message.stamp_ns);
}

void BagBatches::add_image(Topic& topic, const BagMessage& message, RosType type) {
  const Expected<RosImage> image = decode_image(type, message.bytes);
  if (!image) {
    topic.fault(image.error());
    return;
  }
  topic.count_lost(message.connection, image->header.seq);
  const std::int64_t stamp_ns = topic.session_ns(image->header.stamp_ns, message.stamp_ns);
  if (sinks_.images) sinks_.images({topic.wish->sensor, stamp_ns, type, *image});
}

/// A topic on which several LiDARs take turns.
std::optional<Error> BagBatches::shared() const {
  for (const auto& [name, topic] : topics_) {
    if (!topic.lidar_ids.several()) continue;
    return input_error("the topic " + name + " has the points of several LiDARs (lidar_id " + topic.lidar_ids.text() +
                           "), but " + rig_.sensors[static_cast<std::size_t>(topic.counts.sensor)].name + " is one",
                       {},
                       "record with multi_topic on in the launch file of the Livox driver, or give each id a topic");
  }
  return std::nullopt;
}

/// A LiDAR's topic that is there, but without a point that could be used.
std::optional<Error> BagBatches::unusable() const {
  for (const TopicWish& wish : wishes_) {
    if (wish.use != TopicUse::points) continue;
    const bool any = std::any_of(topics_.begin(), topics_.end(), [&](const auto& entry) {
      return entry.second.wish == &wish && entry.second.counts.points > 0;
    });
    if (any) continue;
    std::string fault;
    for (const auto& [name, topic] : topics_) {
      if (topic.wish == &wish && !topic.counts.first_fault.empty()) fault = ": a message " + topic.counts.first_fault;
    }
    return input_error("the topic " + wish.topic + " has no usable point" + fault, {},
                       "check the sensor, and range in the rig file");
  }
  return std::nullopt;
}

IngestSummary BagBatches::summary() const {
  IngestSummary summary;
  std::map<std::string, TopicIngest> topics;
  for (const auto& [number, connection] : bag_.connections()) {
    TopicIngest& silent = topics[connection.topic];
    silent.topic = connection.topic;
    silent.type = connection.type;
  }
  for (const auto& [name, topic] : topics_) {
    TopicIngest& counts = topics[name] = topic.counts;
    counts.clock = topic.clock.figures();
    warn_of(counts, summary.warnings);
    if (topic.times.recorded_too_early()) {
      summary.warnings.push_back(name + ": its record times are the stamps of its messages, before their last points " +
                                 "were seen (a bag that was written anew?): the points are used at their own times");
    }
    if (2 * counts.untimed > counts.messages && topic.times.usual_ns() > long_untimed_ns) {
      summary.warnings.push_back(name + ": its clouds take " + fixed_text(seconds_of_ns(topic.times.usual_ns()), 1) +
                                 " s and do not say when each point was seen: those in which the rig moved are left "
                                 "out; record clouds with times (CustomMsg), or 5 and more a second");
    }
  }
  for (auto& [name, counts] : topics) summary.topics.push_back(std::move(counts));
  for (const TopicWish& wish : wishes_) {
    const bool there = std::any_of(summary.topics.begin(), summary.topics.end(),
                                   [&](const TopicIngest& counts) { return is_same_topic(counts.topic, wish.topic); });
    if (!there) summary.warnings.push_back("there is no topic " + wish.topic);
  }
  summary.unfit = topics_error();
  if (!summary.unfit) summary.unfit = shared();
  if (!summary.unfit) summary.unfit = unusable();
  return summary;
}

}  // namespace

bool is_bag(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // What a pipe has given it does not give again.
  std::ifstream file(path, std::ios::binary);
  std::string start(9, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == "#ROSBAG V" || start == "#ROSRECOR";
}

Expected<std::unique_ptr<BatchSource>> open_bag_batches(const std::string& path, const Rig& rig, BatchSinks sinks) {
  Expected<BagReader> bag = BagReader::open(path);
  if (!bag) return bag.error();
  const bool indexed = bag->indexed();
  auto batches = std::make_unique<BagBatches>(std::move(*bag), path, rig, std::move(sinks));
  if (std::optional<Error> error = indexed ? batches->topics_error() : std::nullopt) {
    error->where = path;
    return *error;
  }
  return std::unique_ptr<BatchSource>(std::move(batches));
}

}  // namespace rigcal
