#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/pipeline/camera_stage.h"

namespace rigcal {

/// What became of the images of one stop.
struct StopOutcome {
  std::optional<StillImage> image;  ///< Nothing where none could be used.
  std::vector<std::string> complaints;
};

/// Images that were read before anybody asked for them, while a recording still went on, so that its end need not wait
/// for them. Known by the very files that they were made from. From any threads.
class StopImageCache {
 public:
  /// What is read ahead in memory at most; images beyond it are read when they are needed.
  static constexpr std::size_t kMostBytes = std::size_t{512} << 20U;

  [[nodiscard]] bool has(const std::string& camera, std::size_t stop, const std::vector<std::string>& files) const;
  /// Takes it out.
  [[nodiscard]] std::optional<StopOutcome> take(const std::string& camera, std::size_t stop,
                                                const std::vector<std::string>& files);
  /// Instead of what there was for this stop; false where there is no room.
  bool keep(const std::string& camera, std::size_t stop, std::vector<std::string> files, StopOutcome outcome);

 private:
  struct Entry {
    std::vector<std::string> files;
    StopOutcome outcome;
    std::size_t bytes = 0;
  };
  using Key = std::pair<std::string, std::size_t>;

  mutable std::mutex mutex_;
  std::map<Key, Entry> entries_;
  std::size_t bytes_ = 0;
};

}  // namespace rigcal
