#include "apps/recording/stop_image_cache.h"

namespace rigcal {
namespace {

std::size_t bytes_of(const StopOutcome& outcome) {
  if (!outcome.image) return 0;
  std::size_t bytes = outcome.image->image.bytes.size();
  if (const ImageFeatures* features = outcome.image->features.get()) {
    bytes += features->grey.values.size() * sizeof(float);
    if (features->edges != nullptr) bytes += features->edges->size() * sizeof(ImageEdge);
  }
  return bytes;
}

}  // namespace

bool StopImageCache::has(const std::string& camera, std::size_t stop, const std::vector<std::string>& files) const {
  const std::lock_guard lock(mutex_);
  const auto at = entries_.find({camera, stop});
  return at != entries_.end() && at->second.files == files;
}

std::optional<StopOutcome> StopImageCache::take(const std::string& camera, std::size_t stop,
                                                const std::vector<std::string>& files) {
  const std::lock_guard lock(mutex_);
  const auto at = entries_.find({camera, stop});
  if (at == entries_.end() || at->second.files != files) return std::nullopt;
  StopOutcome outcome = std::move(at->second.outcome);
  bytes_ -= at->second.bytes;
  entries_.erase(at);
  return outcome;
}

bool StopImageCache::keep(const std::string& camera, std::size_t stop, std::vector<std::string> files,
                          StopOutcome outcome) {
  const std::size_t bytes = bytes_of(outcome);
  const std::lock_guard lock(mutex_);
  if (const auto old = entries_.find({camera, stop}); old != entries_.end()) {
    bytes_ -= old->second.bytes;
    entries_.erase(old);
  }
  if (bytes > kMostBytes - bytes_) return false;
  bytes_ += bytes;
  entries_[{camera, stop}] = {std::move(files), std::move(outcome), bytes};
  return true;
}

}  // namespace rigcal
