#include "drivers/camera/aravis/camera_setter.h"

#include <arv.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/text.h"
#include "core/records/pixel_format.h"
#include "drivers/camera/aravis/problem.h"
#include "drivers/camera/camera.h"

namespace rigcal::camera {
namespace {

/// Values of features are compared after they went through a camera's registers of 32 bits.
bool is_near(double a, double b) { return std::abs(a - b) <= 1e-6 * std::max({1.0, std::abs(a), std::abs(b)}); }

}  // namespace

Expected<CameraSetup> CameraSetter::apply(const CameraConfig& config) {
  end_what_was_left();
  const auto steps = [&]() -> Expected<void> {
    if (auto done = leave_triggers(); !done) return done;
    if (auto done = set_format(config.pixel_format); !done) return done;
    if (config.region) {
      if (auto done = set_region(*config.region); !done) return done;
    }
    if (auto done = set_light(config); !done) return done;
    if (config.trigger) {
      lift_rate_limit(config.frame_rate);
    } else if (config.frame_rate) {
      if (auto done = set_rate(*config.frame_rate); !done) return done;
    }
    if (auto done = set_if_there("AcquisitionMode", "Continuous"); !done) return done;
    if (auto done = set_chunks(); !done) return done;
    if (device_.is_gige()) {
      if (auto done = set_packets(config); !done) return done;
    }
    if (!config.strobe.empty()) {
      if (auto done = set_strobe(config.strobe); !done) return done;
    }
    if (config.ptp) {
      if (auto done = set_ptp(); !done) return done;
    }
    return config.trigger ? set_trigger(*config.trigger) : Expected<void>();
  };
  if (const auto done = steps(); !done) return done.error();
  return read_back(config);
}

Expected<void> CameraSetter::set(const std::string& feature, const std::string& value, const Selected& selected) {
  const Expected<std::string> old = device_.get(feature);
  if (!old) return old.error();
  if (*old == value) return {};
  log_.add({selected.selector, selected.entry, feature, *old});
  return device_.set(feature, value);
}

Expected<void> CameraSetter::set_if_there(const std::string& feature, const std::string& value,
                                          const Selected& selected) {
  return device_.has(feature) ? set(feature, value, selected) : Expected<void>();
}

Expected<void> CameraSetter::set_within(const std::string& feature, double value, const std::string& what,
                                        const std::string& unit) {
  const auto [least, most] = device_.range(feature);
  if (value < least - 1e-6 * std::abs(least) || value > most + 1e-6 * std::abs(most)) {
    return refused(what + " of " + fixed_text(value, 2) + " " + unit + " is not possible",
                   "the camera takes " + fixed_text(least, 2) + " to " + fixed_text(most, 2));
  }
  const Expected<double> now = device_.number(feature);
  return now && is_near(*now, value) ? Expected<void>() : set(feature, number_text(std::clamp(value, least, most)));
}

Expected<void> CameraSetter::select(const std::string& selector, const std::string& entry) {
  return set(selector, entry);
}

bool CameraSetter::is_other_than(const std::string& feature, const std::string& value) const {
  if (!device_.has(feature)) return false;
  const Expected<std::string> now = device_.get(feature);
  return now && *now != value;
}

Error CameraSetter::refused(std::string what, std::string mend) const {
  return system_error(std::move(what), device_.identity().id, std::move(mend));
}

/// A program that crashed may have left the camera sending; it takes no sizes then. That it may be told in vain is why
/// nothing is said of errors.
void CameraSetter::end_what_was_left() {
  if (device_.has("AcquisitionStop")) static_cast<void>(device_.execute("AcquisitionStop"));
  if (device_.has("TLParamsLocked")) static_cast<void>(device_.set("TLParamsLocked", "0"));
}

Expected<void> CameraSetter::leave_triggers() {
  if (!device_.has("TriggerMode")) return {};
  const std::vector<std::string> triggers = device_.entries("TriggerSelector");
  if (triggers.empty()) return set("TriggerMode", "Off");
  const Expected<std::string> selected = device_.get("TriggerSelector");
  if (!selected) return selected.error();
  log_.add({{}, {}, "TriggerSelector", *selected});
  for (const std::string& trigger : triggers) {
    if (auto done = device_.set("TriggerSelector", trigger); !done) return done;
    if (auto done = set_if_there("TriggerMode", "Off", {"TriggerSelector", trigger}); !done) return done;
  }
  return device_.set("TriggerSelector", *selected);
}

Expected<void> CameraSetter::set_format(const std::string& wanted) {
  std::vector<std::string> usable;
  for (const std::string& format : device_.entries("PixelFormat")) {
    if (parse_pixel_format(format) && !format.empty()) usable.push_back(format);
  }
  Expected<std::string> now = device_.get("PixelFormat");
  if (!now) return now.error();
  const std::string format = wanted.empty() ? *now : wanted;
  if (std::find(usable.begin(), usable.end(), format) == usable.end()) {
    return refused("the camera has no pixel format " + format + " that rigcal can read", "it has " + list_text(usable));
  }
  return set("PixelFormat", format);
}

Expected<void> CameraSetter::set_region(const Region& region) {
  struct Side {
    const char* size;
    const char* offset;
    int wanted;
    int from;
  };
  for (const Side& side :
       {Side{"Width", "OffsetX", region.width, region.x}, Side{"Height", "OffsetY", region.height, region.y}}) {
    if (auto done = set_if_there(side.offset, "0"); !done) return done;
    const auto [least, most] = device_.range(side.size);
    const std::int64_t step = device_.step(side.size);
    const bool fits = side.wanted >= least && side.from + side.wanted <= most &&
                      (side.wanted - static_cast<std::int64_t>(least)) % step == 0;
    if (!fits) {
      return refused(std::string(side.size) + " " + std::to_string(side.wanted) + " from " + std::to_string(side.from) +
                         " on is not possible",
                     "the camera has " + fixed_text(least, 0) + " to " + fixed_text(most, 0) + " pixels in steps of " +
                         std::to_string(step));
    }
    if (auto done = set(side.size, std::to_string(side.wanted)); !done) return done;
    if (device_.has(side.offset)) {
      if (auto done = set(side.offset, std::to_string(side.from)); !done) return done;
    } else if (side.from != 0) {
      return refused("the camera's images have no offset", "give the part the offset 0");
    }
  }
  return {};
}

Expected<void> CameraSetter::set_light(const CameraConfig& config) {
  if (config.exposure_us) {
    const std::string name = device_.name_of(Purpose::exposure);
    if (name.empty()) return refused("the camera's exposure cannot be set", "leave exposure_us out");
    if (device_.has_entry("ExposureMode", "Timed")) {
      if (auto done = set("ExposureMode", "Timed"); !done) return done;
    }
    if (auto done = set_if_there("ExposureAuto", "Off"); !done) return done;
    if (auto done = set_within(name, *config.exposure_us, "an exposure", "us"); !done) return done;
  }
  if (config.gain) {
    const std::string name = device_.name_of(Purpose::gain);
    if (name.empty()) return refused("the camera's gain cannot be set", "leave gain out");
    if (auto done = set_if_there("GainAuto", "Off"); !done) return done;
    if (auto done = set_within(name, *config.gain, "a gain", "dB or steps"); !done) return done;
  }
  return {};
}

Expected<void> CameraSetter::set_rate(double frame_rate) {
  const std::string name = device_.name_of(Purpose::frame_rate);
  if (name.empty()) return refused("the camera's frame rate cannot be set", "leave frame_rate out");
  for (const auto& [purpose, value] :
       {std::pair{Purpose::frame_rate_auto, "Off"}, std::pair{Purpose::frame_rate_enable, "true"}}) {
    if (auto done = set_if_there(device_.name_of(purpose), value); !done) return done;
  }
  return set_within(name, frame_rate, "a frame rate", "1/s");
}

/// A camera that is triggered exposes when it is told to. With a limit at the rate of its pulses, or lower, it would
/// pass over those that come early by their jitter.
void CameraSetter::lift_rate_limit(std::optional<double> pulse_rate) {
  const std::string enable = device_.name_of(Purpose::frame_rate_enable);
  if (!enable.empty() && set(enable, "false")) return;
  // Without a switch, or with one that is stuck: as fast as it can be.
  const std::string name = device_.name_of(Purpose::frame_rate);
  if (name.empty()) return;
  static_cast<void>(set_if_there(device_.name_of(Purpose::frame_rate_auto), "Off"));
  const double most = device_.range(name).second;
  if (most < std::numeric_limits<double>::max()) static_cast<void>(set(name, number_text(most)));
  const Expected<double> limit = device_.number(name);
  if (limit && pulse_rate && *limit <= *pulse_rate) {
    notes_.push_back("the camera's " + name + " stays at " + fixed_text(*limit, 2) +
                     ", so that pulses that come sooner release no image: let them come less often (frame_rate)");
  }
}

Expected<void> CameraSetter::set_trigger(const TriggerConfig& trigger) {
  const std::vector<std::string> sources = device_.entries("TriggerSource");
  if (std::find(sources.begin(), sources.end(), trigger.source) == sources.end()) {
    return refused("the camera has no trigger source " + trigger.source, "it has " + list_text(sources));
  }
  const bool has_selector = device_.has_entry("TriggerSelector", "FrameStart");
  const Selected frame_start = has_selector ? Selected{"TriggerSelector", "FrameStart"} : Selected{};
  if (has_selector) {
    if (auto done = select("TriggerSelector", "FrameStart"); !done) return done;
  }
  if (auto done = set("TriggerSource", trigger.source, frame_start); !done) return done;
  if (trigger.source != "Software") {
    const char* edge = trigger.on_falling_edge ? "FallingEdge" : "RisingEdge";
    if (auto done = set("TriggerActivation", edge, frame_start); !done) return done;
  }
  if (auto done = set_trigger_delay(trigger.delay_us); !done) return done;
  return set("TriggerMode", "On", frame_start);
}

/// Some cameras take no delay of 0, but have a least one; others have a switch for it.
Expected<void> CameraSetter::set_trigger_delay(double delay_us) {
  const std::string delay = device_.name_of(Purpose::trigger_delay);
  if (delay.empty()) {
    return delay_us > 0.0 ? refused("the camera's trigger has no delay", "give it the delay 0") : Expected<void>();
  }
  if (const std::string enable = device_.name_of(Purpose::trigger_delay_enable); !enable.empty()) {
    if (auto done = set(enable, delay_us > 0.0 ? "true" : "false"); !done) return done;
    if (delay_us <= 0.0) return {};
  }
  const double least_us = device_.range(delay).first;
  if (delay_us <= 0.0 && least_us > 0.0) {
    notes_.push_back("the camera exposes no sooner than " + fixed_text(least_us, 2) + " us after a pulse");
    delay_us = least_us;
  }
  return set_within(delay, delay_us, "a trigger delay", "us");
}

Expected<void> CameraSetter::set_packets(const CameraConfig& config) {
  ArvGvDevice* gige = ARV_GV_DEVICE(arv_camera_get_device(device_.get()));
  // What is set here is to stay when the stream is made.
  arv_gv_device_set_packet_size_adjustment(gige, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  constexpr const char* size = "GevSCPSPacketSize";
  if (config.packet_bytes) {
    if (auto done = set_within(size, *config.packet_bytes, "a packet size", "bytes"); !done) return done;
  } else if (const Expected<std::string> old = device_.get(size); old) {
    log_.add({{}, {}, size, *old});
    Problem problem;
    arv_gv_device_auto_packet_size(gige, problem.put());
    if (!problem.is_none()) {
      static_cast<void>(device_.set(size, *old));
      notes_.push_back("the camera did not send its packets for trial, so that their size stays " + *old + " bytes");
    }
  }
  if (config.packet_delay_ns) {
    const Expected<std::string> old = device_.get("GevSCPD");
    if (!old) return refused("the camera's packets have no delay", "leave packet_delay out");
    log_.add({{}, {}, "GevSCPD", *old});
    Problem problem;
    arv_camera_gv_set_packet_delay(device_.get(), *config.packet_delay_ns, problem.put());
    if (auto done = problem.result("the packet delay cannot be set", device_.identity().id); !done) return done;
  }
  return {};
}

/// Each frame with its exposure, where the camera can do that.
Expected<void> CameraSetter::set_chunks() {
  if (!device_.has("ChunkModeActive") || !device_.has("ChunkSelector")) return {};
  if (auto done = set("ChunkModeActive", "true"); !done) return done;
  for (const std::string_view name : names_of(Purpose::chunk_of_exposure, device_.vendor())) {
    const std::string entry(name);
    if (!device_.has_entry("ChunkSelector", entry)) continue;
    if (auto done = select("ChunkSelector", entry); !done) return done;
    return set("ChunkEnable", "true", {"ChunkSelector", entry});
  }
  return set("ChunkModeActive", "false");
}

Expected<void> CameraSetter::set_strobe(const std::string& line) {
  const std::vector<std::string> lines = device_.entries("LineSelector");
  if (std::find(lines.begin(), lines.end(), line) == lines.end())
    return refused("the camera has no line " + line + " for its strobe", "it has " + list_text(lines));
  if (auto done = select("LineSelector", line); !done) return done;
  const Selected selected{"LineSelector", line};
  const auto first_of = [&](const std::string& feature, Purpose purpose) {
    for (const std::string_view name : names_of(purpose, device_.vendor())) {
      if (device_.has_entry(feature, std::string(name))) return std::string(name);
    }
    return std::string();
  };
  const std::string mode = first_of("LineMode", Purpose::strobe_mode);
  if (mode.empty()) {
    return refused("line " + line + " of the camera gives nothing out",
                   "it can be " + list_text(device_.entries("LineMode")));
  }
  if (auto done = set("LineMode", mode, selected); !done) return done;
  if (const std::string source = first_of("LineSource", Purpose::strobe_source); !source.empty()) {
    if (auto done = set("LineSource", source, selected); !done) return done;
  }
  return set_if_there(device_.name_of(Purpose::strobe_enable), "true", selected);
}

Expected<void> CameraSetter::set_ptp() {
  const std::string name = device_.name_of(Purpose::ptp);
  if (name.empty()) return refused("the camera has no PTP", "leave ptp out");
  return set(name, "true");
}

Expected<CameraSetup> CameraSetter::read_back(const CameraConfig& config) {
  CameraSetup setup;
  const auto format = device_.get("PixelFormat");
  const auto width = device_.number("Width");
  const auto height = device_.number("Height");
  if (!format) return format.error();
  if (!width) return width.error();
  if (!height) return height.error();
  setup.pixel_format = *format;
  setup.width = static_cast<int>(*width);
  setup.height = static_cast<int>(*height);
  const std::optional<PixelFormat> layout = parse_pixel_format(*format);
  if (!layout || setup.width <= 0 || setup.height <= 0)
    return refused("the camera's frames have no size", "take its power away for a moment");
  setup.image_bytes = static_cast<std::size_t>(setup.width) * static_cast<std::size_t>(setup.height) *
                      static_cast<std::size_t>(layout->channels() * layout->stored_bits() / 8);
  const auto value = [&](Purpose purpose) -> std::optional<double> {
    const std::string name = device_.name_of(purpose);
    const Expected<double> number = name.empty() ? Expected<double>(Error{}) : device_.number(name);
    return number ? std::optional(*number) : std::nullopt;
  };
  setup.exposure_us = value(Purpose::exposure);
  setup.exposure_varies = is_other_than("ExposureAuto", "Off") || is_other_than("ExposureMode", "Timed");
  setup.gain = value(Purpose::gain);
  if (!config.trigger) {
    setup.frame_rate = value(Purpose::frame_rate);
  } else {
    const bool has_none = is_other_than(device_.name_of(Purpose::trigger_delay_enable), "true");
    setup.trigger_delay_us = has_none ? 0.0 : value(Purpose::trigger_delay).value_or(0.0);
  }
  if (device_.is_gige()) {
    if (const auto bytes = device_.number("GevSCPSPacketSize"); bytes) setup.packet_bytes = static_cast<int>(*bytes);
  }
  const Expected<std::string> extended =
      device_.has("GevGVSPExtendedIDMode") ? device_.get("GevGVSPExtendedIDMode") : Expected<std::string>("Off");
  setup.frame_ids = device_.is_usb()                ? usb3_block_ids
                    : extended && *extended == "On" ? extended_block_ids
                                                    : gige_block_ids;
  setup.has_device_stamps = true;
  const auto compare = [&](const char* what, std::optional<double> wanted, std::optional<double> got) {
    if (!wanted || !got || std::abs(*wanted - *got) <= 0.01 * *wanted) return;
    notes_.push_back(std::string("the camera made ") + fixed_text(*got, 2) + " of the " + what + " " +
                     fixed_text(*wanted, 2));
  };
  compare("exposure", config.exposure_us, setup.exposure_us);
  compare("frame rate", config.frame_rate, setup.frame_rate);
  setup.notes = std::move(notes_);
  return setup;
}

std::vector<std::string> put_back(Device& device, const std::vector<OldSetting>& settings) {
  std::vector<std::string> trouble;
  for (auto it = settings.rbegin(); it != settings.rend() && device.answers(); ++it) {
    if (!it->selector.empty()) {
      if (const auto selected = device.set(it->selector, it->entry); !selected) {
        trouble.push_back(selected.error().message());
        continue;
      }
    }
    if (const auto done = device.set(it->feature, it->value); !done) trouble.push_back(done.error().message());
  }
  return trouble;
}

}  // namespace rigcal::camera
