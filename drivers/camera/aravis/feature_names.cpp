#include "drivers/camera/aravis/feature_names.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/text.h"

namespace rigcal::camera {
namespace {

// Columns as in Vendor. Sources: Standard Features Naming Convention 2.7; the feature lists of Hikrobot's MV-CA series,
// of Basler's ace (its GigE models keep the names of SFNC 1: "...Abs", "...Raw") and of FLIR's Blackfly.
struct Row {
  Purpose purpose;
  std::array<std::string_view, 4> names;
};
constexpr std::array<Row, static_cast<std::size_t>(kLastPurpose) + 1> table{{
    {Purpose::exposure, {"ExposureTime", "ExposureTime", "ExposureTimeAbs", "ExposureTime"}},
    {Purpose::gain, {"Gain", "Gain", "GainRaw", "Gain"}},
    {Purpose::frame_rate,
     {"AcquisitionFrameRate", "AcquisitionFrameRate", "AcquisitionFrameRateAbs", "AcquisitionFrameRate"}},
    {Purpose::frame_rate_enable,
     {"AcquisitionFrameRateEnable", "AcquisitionFrameRateEnable", "AcquisitionFrameRateEnable",
      "AcquisitionFrameRateEnabled"}},
    {Purpose::frame_rate_auto, {"", "", "", "AcquisitionFrameRateAuto"}},
    {Purpose::trigger_delay, {"TriggerDelay", "TriggerDelay", "TriggerDelayAbs", "TriggerDelay"}},
    {Purpose::trigger_delay_enable, {"", "", "", "TriggerDelayEnabled"}},
    {Purpose::ptp, {"PtpEnable", "GevIEEE1588", "GevIEEE1588", "GevIEEE1588"}},
    {Purpose::strobe_mode, {"Output", "Strobe", "Output", "Output"}},
    {Purpose::strobe_source, {"ExposureActive", "ExposureStartActive", "ExposureActive", "ExposureActive"}},
    {Purpose::strobe_enable, {"", "StrobeEnable", "", ""}},
    {Purpose::chunk_of_exposure, {"ExposureTime", "Exposure", "ExposureTime", "ExposureTime"}},
    {Purpose::chunk_exposure, {"ChunkExposureTime", "ChunkExposureTime", "ChunkExposureTime", "ChunkExposureTime"}},
}};

}  // namespace

Vendor vendor_of(std::string_view vendor_name) {
  const std::string name = small_letters(vendor_name);
  const auto has = [&](std::string_view word) { return name.find(word) != std::string::npos; };
  if (has("hik")) return Vendor::hikrobot;
  if (has("basler")) return Vendor::basler;
  if (has("flir") || has("point grey") || has("teledyne")) return Vendor::flir;
  return Vendor::generic;
}

std::vector<std::string_view> names_of(Purpose purpose, Vendor vendor) {
  const auto& row = table[static_cast<std::size_t>(purpose)].names;
  std::vector<std::string_view> names;
  const auto add = [&](std::string_view name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  add(row[static_cast<std::size_t>(vendor)]);
  for (const std::string_view name : row) add(name);
  return names;
}

}  // namespace rigcal::camera
