#include "apps/recording/batch_source.h"

#include <utility>

#include "apps/recording/bag_batches.h"

namespace rigcal {
namespace {

constexpr int datagrams_at_once = 4096;  // some milliseconds of work

class PacketBatches final : public BatchSource {
 public:
  PacketBatches(std::unique_ptr<DatagramFile> file, const Rig& rig, BatchSinks sinks, const BroadcastCodes& codes)
      : file_(std::move(file)), ingest_(rig, std::move(sinks.points), std::move(sinks.imu), codes) {}

  Expected<bool> read_some() override {
    Datagram datagram;
    for (int i = 0; i < datagrams_at_once; ++i) {
      const Expected<bool> more = file_->next(datagram);
      if (!more || !*more) return more;
      ingest_.add(datagram);
    }
    return true;
  }
  [[nodiscard]] double fraction() const override { return file_->fraction(); }
  [[nodiscard]] IngestSummary summary() const override { return ingest_.summary(); }
  [[nodiscard]] std::string truncation() const override { return file_->truncation(); }
  [[nodiscard]] FileNotes notes() const override { return file_->notes(); }
  [[nodiscard]] std::optional<BroadcastCodes> better_codes() const override {
    if (!ingest_.learned_too_late()) return std::nullopt;
    return ingest_.codes();
  }

 private:
  std::unique_ptr<DatagramFile> file_;
  LidarIngest ingest_;
};

}  // namespace

Expected<std::unique_ptr<BatchSource>> open_batches(const std::string& path, const Rig& rig, BatchSinks sinks,
                                                    const BroadcastCodes& codes) {
  if (is_bag(path)) return open_bag_batches(path, rig, std::move(sinks));
  Expected<std::unique_ptr<DatagramFile>> file = open_datagrams(path);
  if (!file) return file.error();
  return make_batches(std::move(*file), rig, std::move(sinks), codes);
}

std::unique_ptr<BatchSource> make_batches(std::unique_ptr<DatagramFile> datagrams, const Rig& rig, BatchSinks sinks,
                                          const BroadcastCodes& codes) {
  return std::make_unique<PacketBatches>(std::move(datagrams), rig, std::move(sinks), codes);
}

}  // namespace rigcal
