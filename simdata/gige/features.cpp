#include "simdata/gige/features.h"

#include <array>

namespace rigcal::sim {
namespace {

using Kind = FeatureInfo::Kind;
constexpr double any = 4294967295.0;

// In the order of the enumeration. Exposure and delay are in microseconds, gain in dB.
constexpr std::array<FeatureInfo, static_cast<std::size_t>(kLastFeature) + 1> table{{
    {"Width", Kind::integer, true, true, 1, {}, 32, 65535, 0},
    {"Height", Kind::integer, true, true, 1, {}, 32, 65535, 0},
    {"OffsetX", Kind::integer, true, false, 1, {}, 0, 65535, 0},
    {"OffsetY", Kind::integer, true, false, 1, {}, 0, 65535, 0},
    {"PixelFormat", Kind::integer, true, true, 1, {}, 0, any, 0},
    {"AcquisitionMode", Kind::integer, true, true, 1, {}, 0, 2, 0},
    {"AcquisitionFrameCount", Kind::integer, true, true, 1, {}, 1, 1023, 1},
    {"AcquisitionFrameRate", Kind::real, true, false, 1, {}, 0.1, 1000, 60},
    {"AcquisitionFrameRateEnable", Kind::integer, true, false, 1, {}, 0, 1, 1},
    {"TriggerMode", Kind::integer, true, false, 1, {}, 0, 1, 0},
    {"TriggerSource", Kind::integer, true, false, 1, {}, 0, 7, 0},
    {"TriggerActivation", Kind::integer, true, false, 1, {}, 0, 1, 0},
    {"TriggerDelay", Kind::real, true, false, 1, {}, 0, 16'000'000, 0},
    {"ExposureAuto", Kind::integer, true, false, 1, {}, 0, 2, 0},
    {"ExposureTime", Kind::real, true, false, 1, {}, 15, 10'000'000, 5000},
    {"Gain", Kind::real, true, false, 1, {}, 0, 24, 0},
    {"ChunkModeActive", Kind::integer, true, true, 1, {}, 0, 1, 0},
    {"ChunkEnable", Kind::integer, true, true, kChunks, "ChunkSelector", 0, 1, 0},
    {"LineMode", Kind::integer, true, false, kLines, "LineSelector", 0, 8, 0},
    {"StrobeEnable", Kind::integer, true, false, kLines, "LineSelector", 0, 1, 0},
    {"StrobeLineDuration", Kind::integer, true, false, kLines, "LineSelector", 0, 1'000'000, 0},
    {"StrobeLineDelay", Kind::integer, true, false, kLines, "LineSelector", 0, 1'000'000, 0},
    {"UserSetDefault", Kind::integer, true, false, 1, {}, 0, 1, 0},
    {"WidthMax", Kind::integer, false, false, 1, {}, 0, 0, 0},
    {"HeightMax", Kind::integer, false, false, 1, {}, 0, 0, 0},
    {"PayloadSize", Kind::integer, false, false, 1, {}, 0, 0, 0},
    {"TLParamsLocked", Kind::integer, true, false, 1, {}, 0, 1, 0},
    {"TriggerSelector", Kind::integer, true, false, 1, {}, 0, 0, 0},
    {"ChunkSelector", Kind::integer, true, false, 1, {}, 0, kChunks - 1, 0},
    {"LineSelector", Kind::integer, true, false, 1, {}, 0, kLines - 1, 0},
    {"UserSetSelector", Kind::integer, true, false, 1, {}, 0, 1, 0},
    {"ResultingFrameRate", Kind::real, false, false, 1, {}, 0, 0, 0},
    {"DeviceTemperature", Kind::real, false, false, 1, {}, 0, 0, 0},
    {"AcquisitionStart", Kind::command, true, false, 1, {}, 0, any, 0},
    {"AcquisitionStop", Kind::command, true, false, 1, {}, 0, any, 0},
    {"TriggerSoftware", Kind::command, true, false, 1, {}, 0, any, 0},
    {"UserSetLoad", Kind::command, true, true, 1, {}, 0, any, 0},
    {"UserSetSave", Kind::command, true, false, 1, {}, 0, any, 0},
    {"DeviceReset", Kind::command, true, false, 1, {}, 0, any, 0},
}};

}  // namespace

const FeatureInfo& info_of(Feature feature) { return table[static_cast<std::size_t>(feature)]; }

}  // namespace rigcal::sim
