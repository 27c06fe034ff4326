#include "simdata/gige/camera_description.h"

#include <cstdio>
#include <map>

#include "core/base/error.h"
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

}  // namespace

std::string describe_camera(const std::vector<std::string>& pixel_formats) {
  std::map<std::string, std::string, std::less<>> words{{"pixel_formats", format_entries(pixel_formats)},
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
  std::string text;
  std::string_view left = camera_xml;
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

}  // namespace rigcal::sim
