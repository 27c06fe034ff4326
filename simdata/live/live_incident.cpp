#include "simdata/live/live_incident.h"

#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include "core/base/parse_number.h"

namespace rigcal::sim {
namespace {

constexpr const char* incident_forms =
    "write SENSOR,SECONDS,reboot or SENSOR,SECONDS,silence,SECONDS or SENSOR,SECONDS,taken,SECONDS or "
    "SENSOR,SECONDS,status,HEX or SENSOR,SECONDS,clock,SECONDS or SENSOR,SECONDS,refuse,COMMAND";

/// Within +-1e6.
std::optional<double> parse_step(const std::string& text) {
  const auto value = parse_number<double>(text);
  return value && std::abs(*value) <= 1e6 ? value : std::nullopt;
}

std::optional<double> parse_seconds(const std::string& text) {
  const auto value = parse_step(text);
  return value && *value >= 0.0 ? value : std::nullopt;
}

std::optional<std::uint32_t> parse_hex(const std::string& text) {
  const std::size_t start = text.rfind("0x", 0) == 0 ? 2 : 0;
  return parse_number<std::uint32_t>(std::string_view(text).substr(start), 16);
}

Error incident_error(const std::string& text) {
  return input_error("'" + text + "' is no incident", "--incident", incident_forms);
}

// The kind of an incident and its one argument.
bool read_what(const std::string& kind, const std::string& argument, Incident& incident) {
  if (kind == "status") {
    const auto status = parse_hex(argument);
    incident.kind = Incident::Kind::status;
    incident.status = status.value_or(0);
    return status.has_value();
  }
  if (kind == "refuse") {
    const auto command = livox::find_command(argument);
    incident.kind = Incident::Kind::refusal;
    incident.refused = command.value_or(livox::Command::handshake);
    return command.has_value();
  }
  const auto length_s = kind == "clock" ? parse_step(argument) : parse_seconds(argument);
  incident.length_s = length_s.value_or(0.0);
  if (kind == "clock") {
    incident.kind = Incident::Kind::clock_jump;
  } else if (kind == "silence") {
    incident.kind = Incident::Kind::silence;
  } else if (kind == "taken") {
    incident.kind = Incident::Kind::owned_by_other;
  } else {
    return false;
  }
  return length_s.has_value();
}

}  // namespace

Expected<Incident> parse_incident(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  if (parts.size() < 3 || parts.size() > 4 || parts[0].empty()) return incident_error(text);
  const auto time_s = parse_seconds(parts[1]);
  if (!time_s) return incident_error(text);
  Incident incident;
  incident.sensor = parts[0];
  incident.time_s = *time_s;
  if (parts[2] == "reboot" && parts.size() == 3) return incident;
  if (parts.size() != 4) return incident_error(text);
  return read_what(parts[2], parts[3], incident) ? Expected<Incident>(incident) : incident_error(text);
}

}  // namespace rigcal::sim
