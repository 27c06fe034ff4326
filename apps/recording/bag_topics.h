#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/ros_messages.h"
#include "core/rig/rig.h"

namespace rigcal {

/// What a sensor of the rig expects of a topic.
enum class TopicUse { points, imu, images };

struct TopicWish {
  std::string topic;  ///< As the rig file has it.
  int sensor = 0;
  TopicUse use = TopicUse::points;
};

struct TopicName {
  std::string topic;
  std::string type;
};

/// All topics that the rig file names, in the order of its sensors.
[[nodiscard]] std::vector<TopicWish> topic_wishes(const Rig& rig);

/// The same topic, with or without the slash in front.
[[nodiscard]] bool is_same_topic(const std::string& a, const std::string& b);

[[nodiscard]] bool can_send(TopicUse use, RosType type);

/// A LiDAR without a topic in the rig file, or two sensors with one.
[[nodiscard]] std::optional<Error> wish_error(const Rig& rig, const std::vector<TopicWish>& wishes,
                                              const std::vector<TopicName>& there);
/// A topic of a LiDAR that is not there; the nearest names are told first. Cameras may be absent.
[[nodiscard]] std::optional<Error> absence_error(const Rig& rig, const std::vector<TopicWish>& wishes,
                                                 const std::vector<TopicName>& there);
/// A topic whose messages are not what the sensor sends.
[[nodiscard]] Error type_error(const Rig& rig, const TopicWish& wish, const TopicName& name, const std::string& md5);

}  // namespace rigcal
