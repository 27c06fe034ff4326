#pragma once

#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "core/io/output_file.h"
#include "core/records/records.h"

namespace rigcal {

/// Writes datagrams as a pcapng file that Wireshark opens: one interface of raw IP with nanosecond stamps, IPv4 and UDP
/// headers rebuilt from the end points (the IP checksum right, the UDP checksum 0 for "none"). No memory is asked for
/// per packet. What was flushed stays readable up to the last complete block whatever happens later.
class PcapngWriter {
 public:
  /// Makes the file, or empties an existing one.
  [[nodiscard]] static Expected<PcapngWriter> create(const std::string& path);

  /// Errors: the disk (kind system); a payload that fits into no UDP datagram or a stamp before 1970 (kind input).
  Expected<void> write(const Datagram& datagram);
  /// Hands everything to the system; `begin_sync` also asks it to write it to the disk, `sync` waits for that.
  Expected<void> flush() { return file_.flush(); }
  Expected<void> begin_sync() { return file_.begin_sync(); }
  Expected<void> sync() { return file_.sync(); }
  Expected<void> close() { return file_.close(); }

  [[nodiscard]] std::uint64_t datagrams() const { return datagrams_; }
  [[nodiscard]] std::uint64_t bytes() const { return file_.size(); }

 private:
  explicit PcapngWriter(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
  std::uint64_t datagrams_ = 0;
};

}  // namespace rigcal
