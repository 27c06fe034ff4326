#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/frame_ids.h"

namespace rigcal::camera {

/// A camera that was found.
struct CameraIdentity {
  std::string id;       ///< One word that names it, for example "Hikrobot-MV-CA013-21UC-00F12345678".
  std::string address;  ///< Where it is: an IP address, a device file, a folder, a place on the USB.
  std::string serial;   ///< May be empty.
  std::string vendor;
  std::string model;
  std::string link;  ///< "GigE Vision", "USB3 Vision", "V4L2" or "images".
};

struct TriggerConfig {
  std::string source;  ///< "Software", or a line in the camera's own words ("Line0").
  bool on_falling_edge = false;
  double delay_us = 0.0;  ///< From the edge to the exposure.
};

/// A part of the sensor; offsets are from its top left.
struct Region {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// What is wanted of a camera. What is not said stays as the camera has it, except the trigger: without one it runs
/// free. What a camera cannot do is an error where it would change the images or their times, a note otherwise.
struct CameraConfig {
  std::string pixel_format;  ///< A name of the GenICam convention, "BayerRG8"; empty: as it is.
  std::optional<Region> region;
  std::optional<double> exposure_us;
  std::optional<double> gain;        ///< In the camera's own unit, mostly dB.
  std::optional<double> frame_rate;  ///< With a trigger it is that of the triggers: the camera sets itself no limit.
  std::optional<TriggerConfig> trigger;
  std::optional<int> packet_bytes;              ///< GigE, with all headers; not said: the largest that comes through.
  std::optional<std::int64_t> packet_delay_ns;  ///< GigE.
  bool ptp = false;
  std::string strobe;        ///< An output line that shows the exposure.
  std::size_t buffers = 16;  ///< Frames that may wait or be lent; 2 to 256.
};
constexpr std::size_t kFewestBuffers = 2;
constexpr std::size_t kMostBuffers = 256;

/// Which moment of a frame the host's stamp is of.
enum class HostStamp : std::uint8_t {
  arrival_start,   ///< The first of it was here; its exposure has ended by then.
  arrival_end,     ///< The last of it was here.
  exposure_start,  ///< Its exposure began.
};

/// How a camera was set up, as it says itself.
struct CameraSetup {
  std::string pixel_format;
  int width = 0;
  int height = 0;
  std::size_t image_bytes = 0;
  std::optional<double> exposure_us;
  bool exposure_varies = false;  ///< The camera chooses it itself, or a pulse's width does: that was the last one.
  std::optional<double> gain;
  std::optional<double> frame_rate;        ///< None where triggers make it.
  std::optional<double> trigger_delay_us;  ///< None without a trigger.
  std::optional<int> packet_bytes;
  FrameIdRule frame_ids;           ///< How its frames are numbered.
  bool has_device_stamps = false;  ///< Its frames may have stamps of its own clock.
  HostStamp host_stamp = HostStamp::arrival_start;
  std::vector<std::string> notes;  ///< What is otherwise than wanted, or was mended; sentences.
};

}  // namespace rigcal::camera
