#include "simdata/gige/camera_description.h"

#include <cstdio>
#include <functional>
#include <map>

#include "core/base/error.h"
#include "drivers/gige_codec/bootstrap.h"
#include "drivers/gige_codec/pixel_code.h"
#include "simdata/gige/features.h"

namespace rigcal::sim {
namespace {

std::string hex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08X", value);
  return text;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

constexpr const char* transport_features[] = {"GevVersionMajor",
                                              "GevVersionMinor",
                                              "GevDeviceModeIsBigEndian",
                                              "GevCurrentIPAddress",
                                              "GevCurrentSubnetMask",
                                              "GevCurrentDefaultGateway",
                                              "GevHeartbeatTimeout",
                                              "GevTimestampTickFrequency",
                                              "GevTimestampControlLatch",
                                              "GevTimestampControlReset",
                                              "GevTimestampValue",
                                              "GevCCP",
                                              "GevStreamChannelCount",
                                              "GevStreamChannelSelector",
                                              "GevSCPHostPort",
                                              "GevSCPSFireTestPacket",
                                              "GevSCPSDoNotFragment",
                                              "GevSCPSPacketSize",
                                              "GevSCPD",
                                              "GevSCDA",
                                              "GevSCSP"};

std::string name_node(const char* name, unsigned address, unsigned bytes, const char* access) {
  return std::string("  <StringReg Name=\"") + name + "\">\n    <Address>0x" + hex(address) +
         "</Address>\n    <Length>" + std::to_string(bytes) + "</Length>\n    <AccessMode>" + access +
         "</AccessMode>\n    <pPort>Device</pPort>\n  </StringReg>\n";
}

std::string identity_nodes(Transport transport) {
  namespace gige_names = gige::bootstrap;
  using namespace usb3_names;
  if (transport == Transport::usb3)
    return name_node("DeviceVendorName", kManufacturer, kBytes, "RO") +
           name_node("DeviceModelName", kModel, kBytes, "RO") + name_node("DeviceVersion", kVersion, kBytes, "RO") +
           name_node("DeviceManufacturerInfo", kInformation, kBytes, "RO") +
           name_node("DeviceSerialNumber", kSerial, kBytes, "RO") + name_node("DeviceUserID", kUser, kBytes, "RW");
  return name_node("DeviceVendorName", 0x48, 32, "RO") + name_node("DeviceModelName", 0x68, 32, "RO") +
         name_node("DeviceVersion", 0x88, 32, "RO") + name_node("DeviceManufacturerInfo", 0xA8, 48, "RO") +
         name_node("DeviceSerialNumber", 0xD8, 16, "RO") + name_node("DeviceUserID", gige_names::kUserName, 16, "RW");
}

std::string register_node(Feature feature) {
  const FeatureInfo& info = info_of(feature);
  const bool real = info.kind == FeatureInfo::Kind::real;
  const char* access = info.kind == FeatureInfo::Kind::command ? "WO" : info.is_writable ? "RW" : "RO";
  const std::string kind = real ? "FloatReg" : "IntReg";
  std::string text = "  <" + kind + " Name=\"" + std::string(info.name) + "Register\">\n    <Address>0x" +
                     hex(address_of(feature)) + "</Address>\n";
  if (!info.selector.empty()) text += "    <pIndex Offset=\"4\">" + std::string(info.selector) + "Register</pIndex>\n";
  text +=
      "    <Length>4</Length>\n    <AccessMode>" + std::string(access) + "</AccessMode>\n    <pPort>Device</pPort>\n";
  // Registers that the camera writes itself.
  if (!info.is_writable || feature == Feature::exposure_time || feature == Feature::exposure_auto)
    text += "    <Cachable>NoCache</Cachable>\n";
  if (!real) text += "    <Sign>Unsigned</Sign>\n";
  return text + "    <Endianess>BigEndian</Endianess>\n  </" + kind + ">\n";
}

std::string format_entries(const std::vector<std::string>& pixel_formats) {
  std::string text;
  for (const std::string& name : pixel_formats) {
    const auto code = gige::pixel_code(name);
    RIGCAL_ASSERT(code.has_value(), "a pixel format without a number");
    text += "    <EnumEntry Name=\"" + name + "\"><Value>0x" + hex(*code) + "</Value></EnumEntry>\n";
  }
  return text;
}

using Words = std::map<std::string, std::string, std::less<>>;

// The text with what stands between at signs put in.
std::string fill(std::string_view left, const Words& words) {
  std::string text;
  while (true) {
    const std::size_t start = left.find('@');
    text += left.substr(0, start);
    if (start == std::string_view::npos) return text;
    const std::size_t end = left.find('@', start + 1);
    const auto word = words.find(left.substr(start + 1, end - start - 1));
    RIGCAL_ASSERT(end != std::string_view::npos && word != words.end(), "camera.xml names what is not known");
    text += word->second;
    left.remove_prefix(end + 1);
  }
}

}  // namespace

std::string describe_camera(const std::vector<std::string>& pixel_formats, Transport transport,
                            double least_trigger_delay_us) {
  Words words{{"pixel_formats", format_entries(pixel_formats)},
              {"heartbeat.least", number(kShortestHeartbeatMs)},
              {"heartbeat.most", number(kLongestHeartbeatMs)},
              {"packet.least", number(kSmallestPacket)},
              {"packet.most", number(kLargestPacket)},
              {"packet.step", number(kPacketStep)},
              {"packet.delay.most", number(kLongestPacketDelay)},
              {"chunk.FrameID", hex(chunk_id(ChunkKind::frame_id))},
              {"chunk.Timestamp", hex(chunk_id(ChunkKind::timestamp))},
              {"chunk.ExposureTime", hex(chunk_id(ChunkKind::exposure_time))},
              {"chunk.Gain", hex(chunk_id(ChunkKind::gain))}};
  for (unsigned i = 0; i <= static_cast<unsigned>(kLastFeature); ++i) {
    const auto feature = static_cast<Feature>(i);
    const FeatureInfo& info = info_of(feature);
    words["registers"] += register_node(feature);
    words[std::string(info.name) + ".least"] = number(info.least);
    words[std::string(info.name) + ".most"] = number(info.most);
  }
  words["TriggerDelay.least"] = number(least_trigger_delay_us);
  const bool is_gige = transport == Transport::gige;
  words["namespace"] = is_gige ? "GEV" : "U3V";
  words["chunk_category"] = is_gige ? "    <pFeature>ChunkDataControl</pFeature>\n" : "";
  words["identity"] = identity_nodes(transport);
  words["transport_features"];
  for (const char* feature : transport_features)
    if (is_gige) words["transport_features"] += std::string("    <pFeature>") + feature + "</pFeature>\n";
  words["transport"] = is_gige ? fill(transport_xml, words) : "";
  return fill(camera_xml, words);
}

}  // namespace rigcal::sim
