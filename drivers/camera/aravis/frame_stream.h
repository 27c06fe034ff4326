#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/error.h"
#include "drivers/camera/aravis/aravis_backend.h"
#include "drivers/camera/aravis/device.h"
#include "drivers/camera/camera_config.h"
#include "drivers/camera/frame.h"
#include "drivers/camera/frame_counter.h"
#include "drivers/net/session_clock.h"

struct _ArvChunkParser;
struct _ArvStream;

namespace rigcal::camera {

/// A running acquisition: Aravis' own thread fills buffers of ours.
class FrameStream {
 public:
  /// Asks for all memory, then lets the camera send.
  [[nodiscard]] static Expected<std::unique_ptr<FrameStream>> start(Device& device, const CameraSetup& setup,
                                                                    std::size_t buffers, const AravisOptions& options);
  /// As `abandon`.
  ~FrameStream();
  FrameStream(const FrameStream&) = delete;
  FrameStream& operator=(const FrameStream&) = delete;

  /// The next frame that came, whole or not; nothing in the time given.
  [[nodiscard]] std::optional<Frame> next(std::int64_t timeout_ns);
  /// The camera is told to stop, and the stream ends. An Error where it does not answer.
  Expected<void> stop(Device& device);
  /// The stream ends; nobody tells the camera.
  void abandon();

  struct Counts {
    std::uint64_t discarded = 0;  ///< Waited when it ended.
    std::uint64_t no_buffer = 0;
    std::uint64_t resent_packets = 0;
  };
  [[nodiscard]] Counts counts() const;

 private:
  class Store;
  FrameStream() = default;
  [[nodiscard]] Frame read(void* buffer);

  std::shared_ptr<Store> store_;
  _ArvStream* stream_ = nullptr;
  _ArvChunkParser* chunks_ = nullptr;
  std::string exposure_chunk_;
  CameraSetup setup_;
  FrameCounter counter_{gige_block_ids};
  net::RealtimeMap realtime_{net::read_clocks()};
  std::int64_t last_came_ns_ = realtime_.latest().monotonic_ns;  ///< The last frame; those that follow came later.
  std::int64_t last_device_ns_ = 0;
  Counts counts_;
  std::uint64_t underruns_ = 0;  ///< Packets that found no buffer, up to the last frame.
};

}  // namespace rigcal::camera
