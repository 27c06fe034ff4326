#include "simdata/gige/camera_registers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "core/base/error.h"
#include "core/base/seconds.h"
#include "drivers/gige_codec/chunks.h"
#include "drivers/gige_codec/pixel_code.h"
#include "drivers/gige_codec/stream_packet.h"
#include "simdata/gige/camera_description.h"

namespace rigcal::sim {
namespace {

namespace bootstrap = gige::bootstrap;
using Access = RegisterMemory::Access;
using gige::Status;

constexpr std::uint32_t description_address = 0x10000;
constexpr std::uint32_t usual_heartbeat_ms = 3000;
constexpr std::uint32_t usual_packet = 1500;

constexpr std::size_t word_count = static_cast<std::size_t>(kLastSetting) + 1;

}  // namespace

CameraRegisters::CameraRegisters(const VirtualCameraOptions& options)
    : options_(options),
      description_(describe_camera(options.pixel_formats, options.transport, options.least_trigger_delay_us)),
      memory_(description_address + description_.size()) {
  RIGCAL_ASSERT(!options.pixel_formats.empty(), "a camera without a pixel format");
  define_bootstrap();
  define_features();
  sets_[0] = copy_settings();
  sets_[1] = sets_[0];
}

void CameraRegisters::define_bootstrap() {
  const auto identity = gige::encode_identity(options_.identity);
  memory_.define_bytes(bootstrap::kVersion, identity, Access::read);
  memory_.define(bootstrap::kIpConfiguration, options_.identity.ip_configuration, Access::write);
  memory_.define_bytes(bootstrap::kUserName, ByteView(identity).subspan(bootstrap::kUserName), Access::write);
  char url[64];
  std::snprintf(url, sizeof url, "Local:rigcal_virtual_camera.xml;%X;%zX", description_address, description_.size());
  std::vector<std::uint8_t> urls(gige::bootstrap::kUrlBytes);
  std::copy_n(url, std::char_traits<char>::length(url), urls.begin());
  memory_.define_bytes(bootstrap::kFirstUrl, urls, Access::read);
  memory_.define_bytes(bootstrap::kSecondUrl, std::vector<std::uint8_t>(bootstrap::kUrlBytes), Access::read);
  memory_.define(bootstrap::kInterfaces, 1, Access::read);
  for (const auto address : {bootstrap::kPersistentIp, bootstrap::kPersistentMask, bootstrap::kPersistentGateway})
    memory_.define(address, 0, Access::write);
  memory_.define(bootstrap::kLinkSpeed, static_cast<std::uint32_t>(options_.link_bits_per_s / 1e6), Access::read);
  memory_.define(bootstrap::kMessageChannels, 0, Access::read);
  memory_.define(bootstrap::kStreamChannels, 1, Access::read);
  memory_.define(bootstrap::kStreamCapability, 0, Access::read);
  memory_.define(bootstrap::kControlCapability,
                 gige::kCanConcatenate | gige::kCanWriteMemory | (options_.can_resend ? gige::kCanResend : 0U) |
                     gige::kCanSayPending | gige::kHasExtendedStatus | gige::kTellsPrimary | gige::kTellsLinkSpeed |
                     gige::kCanSwitchHeartbeatOff | gige::kHasSerial | gige::kHasUserName,
                 Access::read);
  memory_.define(bootstrap::kHeartbeatTimeout, usual_heartbeat_ms, Access::write);
  memory_.define(bootstrap::kTickFrequencyHigh, 0, Access::read);
  memory_.define(bootstrap::kTickFrequencyLow, kTicksPerSecond, Access::read);
  memory_.define(bootstrap::kTimestampControl, 0, Access::write);
  memory_.define(bootstrap::kTimestampHigh, 0, Access::read);
  memory_.define(bootstrap::kTimestampLow, 0, Access::read);
  memory_.define(bootstrap::kDiscoveryDelay, 0, Access::read);
  memory_.define(bootstrap::kControlConfiguration, 0, Access::write);
  memory_.define(bootstrap::kPendingTimeout, static_cast<std::uint32_t>(std::ceil(1e3 * options_.answer_delay_s)) + 100,
                 Access::read);
  memory_.define(bootstrap::kPrivilege, 0, Access::write);
  memory_.define(bootstrap::kPrimaryPort, 0, Access::read);
  memory_.define(bootstrap::kPrimaryIp, 0, Access::read);
  memory_.define(bootstrap::kStreamPort, 0, Access::write);
  memory_.define(bootstrap::kStreamPacketSize, gige::kDoNotFragment | usual_packet, Access::write);
  memory_.define(bootstrap::kStreamPacketDelay, 0, Access::write);
  memory_.define(bootstrap::kStreamDestination, 0, Access::write);
  memory_.define(bootstrap::kStreamSourcePort, 0, Access::read);
  memory_.define(bootstrap::kStreamChannelCapability, 0, Access::read);
  memory_.define_bytes(description_address,
                       {reinterpret_cast<const std::uint8_t*>(description_.data()), description_.size()}, Access::read);
}

void CameraRegisters::define_features() {
  for (unsigned i = 0; i <= static_cast<unsigned>(kLastFeature); ++i) {
    const auto feature = static_cast<Feature>(i);
    const FeatureInfo& info = info_of(feature);
    for (std::uint32_t index = 0; index < info.count; ++index) {
      const std::uint32_t address = address_of(feature, index);
      memory_.define(address, 0, info.is_writable ? Access::write : Access::read);
      if (info.kind == FeatureInfo::Kind::real) {
        memory_.set_real(address, info.usual);
      } else {
        memory_.set(address, static_cast<std::uint32_t>(info.usual));
      }
    }
  }
  for (const Feature feature : {Feature::width, Feature::width_max})
    set(feature, static_cast<std::uint32_t>(options_.width));
  for (const Feature feature : {Feature::height, Feature::height_max})
    set(feature, static_cast<std::uint32_t>(options_.height));
  set(Feature::pixel_format, gige::pixel_code(options_.pixel_formats.front()).value());
  set_real(Feature::exposure_time, options_.exposure_us);
  set_real(Feature::gain, options_.gain_db);
  set_real(Feature::trigger_delay, options_.least_trigger_delay_us);
  memory_.set(address_of(Feature::line_mode, 1), static_cast<std::uint32_t>(LineMode::strobe));
}

void CameraRegisters::reset() {
  const std::uint32_t set = value(Feature::user_set_default);
  const auto user_name = memory_.view(bootstrap::kUserName, 16);
  const std::vector<std::uint8_t> kept(user_name.begin(), user_name.end());
  define_bootstrap();
  memory_.define_bytes(bootstrap::kUserName, kept, Access::write);
  define_features();
  memory_.set(address_of(Feature::user_set_default), set);
  load_user_set(set);
}

std::optional<CameraRegisters::Place> CameraRegisters::feature_at(std::uint32_t address) {
  if (address < kFirstFeatureAddress || address % 4 != 0) return std::nullopt;
  const std::uint32_t place = (address - kFirstFeatureAddress) / kFeatureStride;
  const std::uint32_t index = (address - kFirstFeatureAddress) % kFeatureStride / 4;
  if (place > static_cast<std::uint32_t>(kLastFeature)) return std::nullopt;
  if (index >= info_of(static_cast<Feature>(place)).count) return std::nullopt;
  return Place{static_cast<Feature>(place), index};
}

bool CameraRegisters::is_allowed(const Place& place, std::uint32_t number) const {
  const FeatureInfo& info = info_of(place.feature);
  const bool is_real = info.kind == FeatureInfo::Kind::real;
  const double real_value = static_cast<double>(std::bit_cast<float>(number));
  const double value_given = is_real ? real_value : static_cast<double>(number);
  const double least = place.feature == Feature::trigger_delay ? options_.least_trigger_delay_us : info.least;
  // Written so that NaN is refused. The limits as floats: they come back as such.
  if (!(value_given >= static_cast<double>(static_cast<float>(least)) &&
        value_given <= (is_real ? static_cast<double>(static_cast<float>(info.most)) : info.most)))
    return false;
  const auto fits = [&](Feature offset, Feature most, std::uint32_t step) {
    return number % step == 0 && std::uint64_t{number} + value(offset) <= value(most);
  };
  switch (place.feature) {
    case Feature::width:
      return fits(Feature::offset_x, Feature::width_max, 8);
    case Feature::height:
      return fits(Feature::offset_y, Feature::height_max, 2);
    case Feature::offset_x:
      return fits(Feature::width, Feature::width_max, 8);
    case Feature::offset_y:
      return fits(Feature::height, Feature::height_max, 2);
    case Feature::pixel_format:
      return std::any_of(options_.pixel_formats.begin(), options_.pixel_formats.end(),
                         [number](const std::string& name) { return gige::pixel_code(name) == number; });
    case Feature::trigger_source:
      return number == 0 || number == 2 || number == kSoftwareTrigger;
    case Feature::line_mode: {
      const bool is_strobe = number == static_cast<std::uint32_t>(LineMode::strobe);
      const bool is_input = number == static_cast<std::uint32_t>(LineMode::input);
      return (is_input && place.index != 1) || (is_strobe && place.index != 0);
    }
    default:
      return true;
  }
}

Status CameraRegisters::write(const Place& place, std::uint32_t number, bool is_acquiring) {
  const FeatureInfo& info = info_of(place.feature);
  if (!info.is_writable || (info.is_locked_while_acquiring && is_acquiring)) return Status::write_protected;
  if (!is_allowed(place, number)) return Status::invalid_parameter;
  if (info.kind != FeatureInfo::Kind::command) memory_.set(address_of(place.feature, place.index), number);
  return Status::success;
}

CameraSettings CameraRegisters::settings() const {
  CameraSettings all;
  all.width = static_cast<int>(value(Feature::width));
  all.height = static_cast<int>(value(Feature::height));
  all.offset_x = static_cast<int>(value(Feature::offset_x));
  all.offset_y = static_cast<int>(value(Feature::offset_y));
  all.pixel_format = value(Feature::pixel_format);
  all.exposure_us = real(Feature::exposure_time);
  all.gain_db = real(Feature::gain);
  all.exposure_auto = static_cast<ExposureAuto>(value(Feature::exposure_auto));
  const auto mode = static_cast<AcquisitionMode>(value(Feature::acquisition_mode));
  if (mode == AcquisitionMode::single_frame) all.frames = 1;
  if (mode == AcquisitionMode::multi_frame) all.frames = value(Feature::acquisition_frame_count);
  all.image_bytes = static_cast<std::size_t>(all.width) * static_cast<std::size_t>(all.height) *
                    (gige::bits_of_pixel(all.pixel_format) / 8);
  all.payload_bytes = all.image_bytes;
  all.has_chunks = value(Feature::chunk_mode) != 0;
  if (all.has_chunks) all.payload_bytes += gige::kChunkTagBytes;
  for (std::uint32_t i = 0; i < kChunks; ++i) {
    all.chunks[i] = all.has_chunks && value(Feature::chunk_enable, i) != 0;
    if (all.chunks[i]) all.payload_bytes += gige::kChunkTagBytes + 8;
  }
  for (std::uint32_t i = 0; i < kLines; ++i) {
    const bool is_output = value(Feature::line_mode, i) == static_cast<std::uint32_t>(LineMode::strobe);
    all.strobes[i] = {is_output && value(Feature::strobe_enable, i) != 0,
                      std::int64_t{value(Feature::strobe_delay, i)} * 1000,
                      std::int64_t{value(Feature::strobe_duration, i)} * 1000};
  }
  ExposureRules& rules = all.rules;
  rules.is_triggered = value(Feature::trigger_mode) != 0;
  rules.source = value(Feature::trigger_source);
  rules.on_falling_edge = value(Feature::trigger_activation) == static_cast<std::uint32_t>(TriggerActivation::falling);
  rules.delay_ns = std::llround(1e3 * real(Feature::trigger_delay));
  rules.exposure_ns = std::llround(1e3 * all.exposure_us);
  rules.shortest_period_ns = std::max(rules.exposure_ns, link_time_ns(all.payload_bytes));
  // As in real cameras, the rate is a limit for triggers, too: what comes sooner is ignored.
  if (value(Feature::frame_rate_enable) != 0)
    rules.shortest_period_ns =
        std::max<std::int64_t>(rules.shortest_period_ns, std::llround(1e9 / real(Feature::frame_rate)));
  rules.period_ns = rules.shortest_period_ns;
  return all;
}

std::int64_t CameraRegisters::link_time_ns(std::size_t payload_bytes) const {
  const std::size_t packet = memory_.value(bootstrap::kStreamPacketSize) & gige::kPacketSizeBits;
  const std::size_t room = packet - gige::kWireHeaderBytes - gige::kStreamHeaderBytes;
  const double packets = std::ceil(static_cast<double>(payload_bytes) / static_cast<double>(room));
  const double bytes =
      static_cast<double>(payload_bytes) + packets * static_cast<double>(packet - room + gige::kEthernetBytes);
  const double delay_s = packets * memory_.value(bootstrap::kStreamPacketDelay) / static_cast<double>(kTicksPerSecond);
  return ns_of_seconds(8.0 * bytes / options_.link_bits_per_s + delay_s);
}

void CameraRegisters::update_computed(double on_s) {
  const CameraSettings now = settings();
  set(Feature::payload_size, static_cast<std::uint32_t>(now.payload_bytes));
  set_real(Feature::resulting_frame_rate, 1e9 / static_cast<double>(now.rules.period_ns));
  set_real(Feature::temperature, 45.0 - 15.0 * std::exp(-on_s / 600.0));  // It warms up.
}

CameraRegisters::Set CameraRegisters::copy_settings() const {
  Set set;
  for (unsigned i = 0; i < word_count; ++i) {
    const auto feature = static_cast<Feature>(i);
    for (std::uint32_t index = 0; index < info_of(feature).count; ++index) set.push_back(value(feature, index));
  }
  return set;
}

Status CameraRegisters::save_user_set() {
  const std::uint32_t set = value(Feature::user_set_selector);
  if (set == 0) return Status::invalid_parameter;  // The factory's is as it is.
  sets_[set] = copy_settings();
  return Status::success;
}

void CameraRegisters::load_user_set(std::uint32_t set) {
  auto word = sets_[set].begin();
  for (unsigned i = 0; i < word_count; ++i) {
    const auto feature = static_cast<Feature>(i);
    for (std::uint32_t index = 0; index < info_of(feature).count; ++index)
      memory_.set(address_of(feature, index), *word++);
  }
}

}  // namespace rigcal::sim
