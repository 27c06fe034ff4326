#include "drivers/livox/protocol/events.h"

#include <cstdio>

#include "drivers/livox/protocol/abilities.h"

namespace rigcal::livox {
namespace {

std::string hex(std::uint32_t word) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%08x", word);
  return text;
}

std::string device_text(const Broadcast& broadcast, const Ipv4& ip) {
  return model_name(broadcast.type) + " " + broadcast.broadcast_code + " at " + rigcal::to_string(ip);
}

struct EventText {
  std::string operator()(const Seen& event) const { return "seen: " + device_text(event.broadcast, event.ip); }
  std::string operator()(const Unreachable& event) const {
    return device_text(event.broadcast, event.ip) + " is not in the subnet of the interface that hears it";
  }
  std::string operator()(const HeardElsewhere& event) const {
    return device_text(event.broadcast, event.ip) + " is heard on " + event.interface +
           ", which is not listened on: end and start again, where that is the right interface; `lidar: {interface: "
           "...}` of the rig file names it";
  }
  std::string operator()(const AddressConflict& event) const {
    return "another device has the same address: " + device_text(event.broadcast, event.ip);
  }
  std::string operator()(const HandshakeRefused&) const { return "another host has the device"; }
  std::string operator()(const HandshakeUnanswered&) const { return "the handshake was not answered"; }
  std::string operator()(const Connected& event) const {
    return "connected: " + model_name(event.type) + ", firmware " + firmware_text(event.firmware) + ", at " +
           rigcal::to_string(event.ip);
  }
  std::string operator()(const WorkStateChanged& event) const {
    return std::string("work state: ") + to_string(event.now) + " (was " + to_string(event.before) + ")";
  }
  std::string operator()(const StatusChanged& event) const {
    return "status word " + hex(event.now) + " (was " + hex(event.before) + ")";
  }
  std::string operator()(const SamplingChanged& event) const {
    return event.on ? "sampling started" : "sampling stopped";
  }
  std::string operator()(const RequestEnded& event) const {
    if (!event.setting.empty() && event.outcome == Outcome::done) return "`" + event.setting + "` is in force now";
    if (!event.setting.empty())
      return missing_text(event.setting, event.outcome) + ": " + mend_of_missing(event.outcome);
    return command_name(event.command) + ": " + to_string(event.outcome);
  }
  std::string operator()(const Lost& event) const { return std::string("lost: ") + to_string(event.cause); }
  std::string operator()(const Closed&) const { return "given free"; }
};

}  // namespace

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::switching:
      return "switching";
    case Outcome::refused:
      return "refused";
    case Outcome::unsupported:
      return "not known to the model or its firmware";
    case Outcome::unanswered:
      return "not answered";
    case Outcome::lost:
      return "the device went away";
  }
  return "?";
}

const char* to_string(LossCause cause) {
  switch (cause) {
    case LossCause::silence:
      return "no heartbeat was answered for 3 s";
    case LossCause::let_go:
      return "the device looks for a host again";
    case LossCause::rebooting:
      return "the device reboots";
    case LossCause::disconnected:
      return "disconnected";
  }
  return "?";
}

const char* to_string(WorkState state) {
  switch (state) {
    case WorkState::initialising:
      return "initialising";
    case WorkState::normal:
      return "normal";
    case WorkState::power_saving:
      return "power saving";
    case WorkState::standby:
      return "standby";
    case WorkState::error:
      return "error";
  }
  return "unknown";
}

std::string mend_of_missing(Outcome outcome) {
  switch (outcome) {
    case Outcome::unsupported:
      return "update its firmware, or change that in the rig file";
    case Outcome::unanswered:
      return "it is asked again each second; look at its cable and switch, and let UDP through the firewall";
    default:
      return "restart the device, or change that in the rig file";
  }
}

std::string missing_text(const std::string& setting, Outcome outcome) {
  return "`" + setting + "` is not in force (" + to_string(outcome) + ")";
}

std::string event_text(const EventContent& content) { return std::visit(EventText{}, content); }

}  // namespace rigcal::livox
