#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/camera/camera.h"

namespace rigcal::camera {

/// The most that a camera may send with an image besides its pixels.
constexpr std::size_t kMostChunkBytes = std::size_t{1} << 20U;

struct AravisOptions {
  /// Where the settings that cameras had are kept until they are put back, so that a crash can be mended; empty: they
  /// are not.
  std::string settings_folder;
  /// GigE: frames are taken past the system's sockets where the user has the privilege for it (CAP_NET_RAW): that costs
  /// less.
  bool packet_socket = true;
  bool resend = true;                         ///< GigE: lost packets are asked for again.
  std::size_t receive_bytes = 8U << 20U;      ///< GigE: of the socket; the system may give less.
  std::int64_t packet_timeout_us = 20'000;    ///< GigE: a packet that is missing so long is asked for,
  std::int64_t frame_retention_us = 200'000;  ///< and a frame given up when nothing came for it so long.
};

/// GigE Vision and USB3 Vision cameras through Aravis 0.8. A GigE camera may also be opened by an IP address that no
/// broadcast reaches. Each camera has threads of Aravis for its stream and its heartbeat; a GigE camera that vanishes
/// is noticed some 6 s later, when its heartbeat is given up, a USB camera at once.
///
/// Packets are sized as large as comes through, by trial, unless a size is asked for. Frames say their exposure where
/// the camera can send it with them. Frame ids are those on the wire: of GigE mostly 16 bits, from 1.
class AravisBackend final : public CameraBackend {
 public:
  explicit AravisBackend(AravisOptions options = {}) : options_(std::move(options)) {}
  [[nodiscard]] std::string_view name() const override { return "aravis"; }
  [[nodiscard]] Expected<std::vector<CameraIdentity>> enumerate() override;
  [[nodiscard]] std::unique_ptr<Camera> make() override;

 private:
  AravisOptions options_;
};

}  // namespace rigcal::camera
