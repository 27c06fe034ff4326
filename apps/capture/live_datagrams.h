#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "apps/recording/datagram_file.h"
#include "core/io/pcapng_writer.h"
#include "core/rig/rig.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

/// How the driver is to take the LiDARs of a rig: those with a broadcast code or an address, set up as the rig file
/// says. Errors: there is none.
[[nodiscard]] Expected<livox::DriverOptions> driver_options(const Rig& rig);

/// Live LiDARs as a source of datagrams like a recording; what it hands out is also recorded, in the same order, so
/// that the recording gives the same as what was seen live. It ends when it is told to stop.
class LiveDatagrams final : public DatagramFile {
 public:
  /// The driver, and the recorder where there is one, must outlive this.
  LiveDatagrams(livox::Driver& driver, PcapngWriter* recorder, std::stop_token stop)
      : driver_(driver), recorder_(recorder), stop_(std::move(stop)) {}

  /// Waits for the next datagram. When it is told to stop it frees the devices and hands out what still waits.
  /// Errors: the recording's.
  [[nodiscard]] Expected<bool> next(Datagram& datagram) override;
  [[nodiscard]] std::string truncation() const override { return {}; }
  [[nodiscard]] FileNotes notes() const override;
  [[nodiscard]] double fraction() const override { return 0.0; }

 private:
  livox::Driver& driver_;
  PcapngWriter* recorder_;
  std::stop_token stop_;
};

}  // namespace rigcal
