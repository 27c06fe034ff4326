#include "apps/recording/bag_topics.h"

#include <algorithm>
#include <string_view>

#include "core/base/edit_distance.h"

namespace rigcal {
namespace {

constexpr std::size_t most_named = 12;

std::string_view bare(std::string_view topic) { return topic.starts_with('/') ? topic.substr(1) : topic; }

const Sensor& sensor_of(const Rig& rig, const TopicWish& wish) {
  return rig.sensors[static_cast<std::size_t>(wish.sensor)];
}

/// "/a (sensor_msgs/Imu), /b (...)", those nearest to `wanted` first.
std::string list_topics(std::vector<TopicName> there, std::string_view wanted) {
  if (there.empty()) return "none";
  if (!wanted.empty() && wanted.size() <= 256) {
    const auto distance = [&](const TopicName& name) { return edit_distance(wanted, name.topic.substr(0, 256)); };
    std::stable_sort(there.begin(), there.end(),
                     [&](const TopicName& a, const TopicName& b) { return distance(a) < distance(b); });
  }
  std::vector<std::string> names;
  for (const TopicName& name : there) names.push_back(name.topic + " (" + name.type + ")");
  return joined_some(names, most_named);
}

const char* wanted_types(TopicUse use) {
  switch (use) {
    case TopicUse::points:
      return "livox_ros_driver/CustomMsg or sensor_msgs/PointCloud2";
    case TopicUse::imu:
      return "sensor_msgs/Imu";
    case TopicUse::images:
      return "sensor_msgs/Image or sensor_msgs/CompressedImage";
  }
  return "";
}

}  // namespace

std::vector<TopicWish> topic_wishes(const Rig& rig) {
  std::vector<TopicWish> wishes;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const int index = static_cast<int>(i);
    const auto& [name, folder, lidar, camera, guess] = rig.sensors[i];
    if (lidar && !lidar->topic.empty()) wishes.push_back({lidar->topic, index, TopicUse::points});
    if (lidar && !lidar->imu_topic.empty()) wishes.push_back({lidar->imu_topic, index, TopicUse::imu});
    if (camera && !camera->topic.empty()) wishes.push_back({camera->topic, index, TopicUse::images});
  }
  return wishes;
}

bool is_same_topic(const std::string& a, const std::string& b) { return bare(a) == bare(b); }

bool can_send(TopicUse use, RosType type) {
  switch (use) {
    case TopicUse::points:
      return type == RosType::livox_points || type == RosType::point_cloud;
    case TopicUse::imu:
      return type == RosType::imu;
    case TopicUse::images:
      return type == RosType::image || type == RosType::compressed_image;
  }
  return false;
}

std::optional<Error> wish_error(const Rig& rig, const std::vector<TopicWish>& wishes,
                                const std::vector<TopicName>& there) {
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.is_lidar() || !sensor.lidar->topic.empty()) continue;
    return input_error(
        "the rig file does not say which topic is " + sensor.name + "; there are " + list_topics(there, sensor.name),
        {}, "give the sensor its topic: in the rig file");
  }
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!is_same_topic(wishes[i].topic, wishes[j].topic)) continue;
      return input_error("the rig file gives the topic " + wishes[i].topic + " to both " +
                             sensor_of(rig, wishes[j]).name + " and " + sensor_of(rig, wishes[i]).name,
                         {}, "give each its own");
    }
  }
  return std::nullopt;
}

std::optional<Error> absence_error(const Rig& rig, const std::vector<TopicWish>& wishes,
                                   const std::vector<TopicName>& there) {
  for (const TopicWish& wish : wishes) {
    const bool is_there = std::any_of(there.begin(), there.end(),
                                      [&](const TopicName& name) { return is_same_topic(name.topic, wish.topic); });
    if (is_there || wish.use == TopicUse::images) continue;
    return input_error("has no topic " + wish.topic + " (" + sensor_of(rig, wish).name + "); there are " +
                           list_topics(there, wish.topic),
                       {}, "correct the topic in the rig file, or take the sensor out of it");
  }
  return std::nullopt;
}

Error type_error(const Rig& rig, const TopicWish& wish, const TopicName& name, const std::string& md5) {
  const bool right_name = can_send(wish.use, ros_type(name.type));
  const std::string found = right_name ? name.type + " in another version (md5sum " + md5 + ")" : name.type;
  return input_error("the topic " + name.topic + " of " + sensor_of(rig, wish).name + " carries " + found + ", not " +
                         wanted_types(wish.use),
                     {}, right_name ? "convert the bag with rosbag fix" : "correct the topic in the rig file");
}

}  // namespace rigcal
