#include "apps/capture/packet_recorder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "core/io/session_folder.h"
#include "drivers/livox_codec/discovery.h"

namespace rigcal {
namespace {

constexpr std::size_t most_broadcasts = 64;

}  // namespace

Expected<PacketRecorder> PacketRecorder::create(const std::string& session, std::uint64_t keep_bytes) {
  std::optional<SessionLock> lock = SessionLock::take(session);
  std::string path = session_packets_path(session);
  Expected<PcapngWriter> writer = PcapngWriter::create(path);
  if (!writer) return writer.error();
  const std::uint64_t part_bytes = keep_bytes == 0 ? UINT64_MAX : std::max(keep_bytes, kLeastKept) / kParts;
  return PacketRecorder(std::move(lock), std::move(path), *std::move(writer), part_bytes);
}

Expected<void> PacketRecorder::write(const Datagram& datagram) {
  if (part_bytes_ != UINT64_MAX) {
    if (writer_.bytes() + datagram.bytes.size() >= part_bytes_) {
      if (const auto begun = begin_part(datagram.stamp_ns); !begun) return begun;
    }
    if (!datagram.bytes.empty() && datagram.bytes[0] == 0xAA) remember_broadcast(datagram);
  }
  latest_ns_ = datagram.stamp_ns;
  ++datagrams_;
  return writer_.write(datagram);
}

Expected<void> PacketRecorder::flush() {
  // Writing to a file that was removed goes well, and all of it is gone once the file is closed.
  std::error_code error;
  if (!std::filesystem::exists(path_, error) && !error)
    return system_error("was removed or renamed while packets were recorded into it", path_,
                        "record anew, and let nobody touch a session before its capture has ended");
  return writer_.begin_sync();
}

Expected<void> PacketRecorder::begin_part(std::int64_t now_ns) {
  if (const auto closed = writer_.close(); !closed) return closed;
  const std::lock_guard switching(progress_->switching());
  Part part{session_packets_part_path(path_, ++part_number_), writer_.bytes(), latest_ns_};
  if (std::rename(path_.c_str(), part.path.c_str()) != 0) return cannot_write(part.path, errno);
  earlier_bytes_ += part.bytes;
  earlier_.push_back(std::move(part));
  while (earlier_.size() >= kParts) {
    std::error_code error;
    std::filesystem::remove(earlier_.front().path, error);
    if (error) return cannot_write(earlier_.front().path, error.value());
    earlier_bytes_ -= earlier_.front().bytes;
    forgotten_until_ns_ = earlier_.front().end_ns;
    earlier_.pop_front();
  }
  Expected<PcapngWriter> writer = PcapngWriter::create(path_);
  if (!writer) return writer.error();
  writer_ = *std::move(writer);
  progress_->begin_part();
  for (const auto& [ip, broadcast] : broadcasts_) {
    const auto written = writer_.write({now_ns, broadcast.from, broadcast.to, broadcast.bytes});
    if (!written) return written;
  }
  return {};
}

void PacketRecorder::remember_broadcast(const Datagram& datagram) {
  const auto frame = livox::parse_control_frame(datagram.bytes);
  if (!frame || !livox::is_broadcast(*frame)) return;
  if (broadcasts_.size() >= most_broadcasts && !broadcasts_.contains(datagram.from.ip)) return;
  broadcasts_[datagram.from.ip] = {datagram.from, datagram.to, {datagram.bytes.begin(), datagram.bytes.end()}};
}

Expected<void> PacketRecorder::close() {
  Expected<void> closed = writer_.begin_sync();
  if (closed) closed = writer_.close();
  progress_->end();
  return closed;
}

}  // namespace rigcal
