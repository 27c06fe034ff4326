#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/ingest/ingest_summary.h"
#include "core/rig/rig.h"
#include "drivers/livox/device/driver.h"
#include "drivers/net/firewalls.h"
#include "drivers/net/interfaces.h"
#include "drivers/net/port_holders.h"

/// What `rigcal doctor` judges. Pure: what was found comes in, findings come out.
namespace rigcal {

enum class CheckLevel { good, warning, bad };

struct Check {
  CheckLevel level = CheckLevel::good;
  std::string about;  ///< A sensor of the rig, or a part of the machine.
  std::string what;   ///< One clause.
  std::string mend;   ///< Empty where nothing is wrong.
};

/// What a status word of a LiDAR says that a user should know, in words.
[[nodiscard]] std::vector<std::string> status_words(std::uint32_t status);

/// Whether every LiDAR of the rig can be reached, and by which interface.
[[nodiscard]] std::vector<Check> check_network(const Rig& rig, const std::vector<net::Interface>& interfaces);

/// The receive buffer of sockets; `largest`: what the system allows, where it says.
[[nodiscard]] Check check_receive_buffer(std::optional<std::size_t> largest, std::size_t needed);

/// Who waits for the broadcasts of LiDARs, besides this program.
[[nodiscard]] Check check_discovery_port(const std::vector<net::PortHolder>& holders);

/// What may keep LiDARs from a capture that hears no broadcast of them: programs other than the process `own` that have
/// the port `port`; empty where there is none.
[[nodiscard]] std::string rivals_text(std::vector<net::PortHolder> holders, int own, std::uint16_t port);

/// Firewalls that are on; a fault only where a LiDAR is not heard as it should be.
[[nodiscard]] std::vector<Check> check_firewalls(const std::vector<net::Firewall>& firewalls, bool all_is_heard);

/// What was found of the LiDARs in some seconds.
struct LidarFindings {
  std::vector<std::string> sensors;  ///< Names, by device of the driver.
  std::vector<livox::DeviceReport> devices;
  std::vector<livox::Sighting> sightings;
  IngestSummary ingest;
};
[[nodiscard]] std::vector<Check> check_lidars(const Rig& rig, const LidarFindings& findings);

[[nodiscard]] std::string checks_text(const std::vector<Check>& checks);
/// As docs/schema/doctor.json has it.
[[nodiscard]] std::string checks_json(const std::vector<Check>& checks);
[[nodiscard]] CheckLevel worst_of(const std::vector<Check>& checks);

}  // namespace rigcal
