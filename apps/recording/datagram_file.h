#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/lvx_reader.h"
#include "core/io/pcap_reader.h"
#include "core/records/records.h"

namespace rigcal {

/// What a file tells beside its datagrams; complete at its end.
struct FileNotes {
  std::vector<std::string> findings;   ///< What a user should know, in clauses.
  std::optional<PcapCounters> frames;  ///< Of a packet dump.
  std::vector<LvxDevice> lvx_devices;  ///< Of an .lvx file.
};

/// Datagrams out of a file, in the order in which they were recorded. Another format of datagrams is a class beside the
/// one in datagram_file.cpp and a line in `open_datagrams`; calibrate, inspect, export and import then read it.
class DatagramFile {
 public:
  DatagramFile() = default;
  DatagramFile(const DatagramFile&) = delete;
  DatagramFile& operator=(const DatagramFile&) = delete;
  virtual ~DatagramFile() = default;

  /// The next one; false at the end. `datagram.bytes` lives until the next call. A file that is cut or damaged in the
  /// middle ends there.
  [[nodiscard]] virtual Expected<bool> next(Datagram& datagram) = 0;
  /// Where and why it ended too soon, one clause; empty otherwise.
  [[nodiscard]] virtual std::string truncation() const = 0;
  [[nodiscard]] virtual FileNotes notes() const = 0;
  /// How much of the file is read, 0 .. 1.
  [[nodiscard]] virtual double fraction() const = 0;
};

/// Opens a file by what is in it. Errors: missing, unreadable, of no known kind.
[[nodiscard]] Expected<std::unique_ptr<DatagramFile>> open_datagrams(const std::string& path);

}  // namespace rigcal
