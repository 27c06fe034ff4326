#pragma once

#include <memory>
#include <string>

#include "apps/recording/batch_source.h"

namespace rigcal {

/// Whether a file begins like a ROS bag of any version.
[[nodiscard]] bool is_bag(const std::string& path);

/// A bag as a source of batches. The session clock is the record time; the stamps in the messages are mapped to it, for
/// each topic by a clock of its own, because senders wait differently long before they send. Which topic is which
/// sensor, the rig file says. Errors: no bag; with an index also a topic of a LiDAR that is not in the bag; later a
/// message of a type that its sensor cannot send.
[[nodiscard]] Expected<std::unique_ptr<BatchSource>> open_bag_batches(const std::string& path, const Rig& rig,
                                                                      BatchSinks sinks);

}  // namespace rigcal
