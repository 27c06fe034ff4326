#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/calibration/live_calibration.h"
#include "apps/capture/capture_status.h"
#include "apps/web/web_server.h"

namespace rigcal {

/// What stands at the end of a capture that calibrates as it goes, as far as the page shows it.
struct WebResult {
  Status status = Status::failed;
  struct Sensor {
    std::string name;
    Status status = Status::failed;
    double translation_bound_m = 0.0;  ///< 95 %; both are 0 for the base and where there is no transform.
    double rotation_bound_rad = 0.0;
  };
  std::vector<Sensor> sensors;
  std::map<std::string, std::vector<std::uint8_t>> pictures;  ///< Of each camera one with edges, JPEG.
};
[[nodiscard]] WebResult web_result(const CalibrationResult& result);

/// What the page shows, as JSON. `known`, `view` and `result` may be null: nobody calibrates, or nothing is known yet.
[[nodiscard]] std::string web_state(const Rig& rig, const CaptureStatus& status, const LiveEstimates* known,
                                    const LiveView* view, const Requirement& goal, const WebResult* result = nullptr);

/// A running capture as a page. Whoever shows it a status does not wait: pictures and text are made in a thread of its
/// own, of low priority.
class WebView {
 public:
  /// `calibration` may be null and must outlive this, as `rig` must. A token is made where others than this machine can
  /// reach the page. Errors: the address cannot be had.
  [[nodiscard]] static Expected<std::unique_ptr<WebView>> start(const WebAddress& address, const Rig& rig,
                                                                const std::string& session,
                                                                const LiveCalibration* calibration);
  ~WebView();
  WebView(const WebView&) = delete;
  WebView& operator=(const WebView&) = delete;

  void show(const CaptureStatus& status);
  /// The numbers stand: cameras with the edges where they belong, and every sensor with its bounds.
  void show_result(const CalibrationResult& result);
  [[nodiscard]] std::string url() const;

 private:
  class Painter;
  explicit WebView(std::unique_ptr<Painter> painter);
  std::unique_ptr<Painter> painter_;
};

}  // namespace rigcal
