#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/capture_status.h"
#include "apps/live_calibration.h"
#include "apps/web/web_server.h"

namespace rigcal {

/// What the page shows, as JSON. `known` and `view` may be null: nobody calibrates, or nothing is known yet.
[[nodiscard]] std::string web_state(const Rig& rig, const CaptureStatus& status, const LiveEstimates* known,
                                    const LiveView* view, const Requirement& goal);

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
  [[nodiscard]] std::string url() const;

 private:
  class Painter;
  explicit WebView(std::unique_ptr<Painter> painter);
  std::unique_ptr<Painter> painter_;
};

}  // namespace rigcal
