#include "apps/web/web_view.h"

#include <sys/resource.h>
#include <unistd.h>

#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "apps/web/page.h"
#include "core/io/image_file.h"
#include "core/io/image_folder.h"
#include "core/io/jpeg_file.h"
#include "core/pipeline/camera_stage.h"
#include "core/report/overlay.h"

namespace rigcal {
namespace {

constexpr int background_niceness = 15;
constexpr double picture_width = 480.0;
constexpr int jpeg_quality = 75;

// The stop in which an image was taken.
std::optional<std::size_t> stop_of(const LiveView& view, std::int64_t stamp_ns) {
  for (std::size_t j = 0; j < view.stops.size(); ++j) {
    const bool is_known = j < view.scene.stop_known.size() && view.scene.stop_known[j];
    if (is_known && view.stops[j].start_ns <= stamp_ns && stamp_ns <= view.stops[j].end_ns) return j;
  }
  return std::nullopt;
}

// The image in grey, small, with what the LiDARs saw from where the camera is thought to be.
std::optional<std::string> paint(const Sensor& camera, const ListedImage& listed, const LiveView* view) {
  Expected<Image> image = read_image(listed.path);
  if (!image || !camera.camera->intrinsics) return std::nullopt;
  SilentReporter silent;
  image->pixel_format = camera.camera->pixel_format;
  const std::vector<CameraView> grey = camera_views({{0, listed.path, std::move(*image)}}, 0, camera.name, {silent});
  if (grey.empty()) return std::nullopt;
  OverlayPoses poses;
  const std::optional<std::size_t> stop = view != nullptr ? stop_of(*view, listed.number) : std::nullopt;
  if (stop && camera.initial_T_base_sensor) {
    poses.guess_T_C_G = (view->scene.T_G_base[*stop] * *camera.initial_T_base_sensor).inverse();
  }
  OverlayWindow window{0, 0, grey[0].grey.width, grey[0].grey.height, picture_width / grey[0].grey.width};
  const CameraScene nothing;
  const Image drawn = draw_edges(grey[0].grey, CameraModel(*camera.camera->intrinsics),
                                 view != nullptr ? view->scene : nothing, poses, camera.name, window);
  const Expected<std::vector<std::uint8_t>> jpeg = encode_jpeg(drawn, jpeg_quality);
  if (!jpeg) return std::nullopt;
  return std::string(jpeg->begin(), jpeg->end());
}

}  // namespace

class WebView::Painter {
 public:
  Painter(std::unique_ptr<WebServer> server, const Rig& rig, std::string session, const LiveCalibration* calibration)
      : server_(std::move(server)), rig_(rig), session_(std::move(session)), calibration_(calibration) {
    thread_ = std::thread([this] { run(); });
  }
  ~Painter() {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  void show(const CaptureStatus& status) {
    {
      const std::lock_guard lock(mutex_);
      next_ = status;
    }
    changed_.notify_all();
  }
  // In the caller's thread: there is little to do, and the program is about to end.
  void show_result(const WebResult& result) {
    std::optional<CaptureStatus> status;
    {
      const std::lock_guard lock(mutex_);
      has_result_ = true;
      status = last_;
    }
    if (!status) return;
    for (CaptureCamera& camera : status->cameras) {
      const auto picture = result.pictures.find(camera.sensor);
      if (picture != result.pictures.end())
        server_->publish_picture(camera.sensor, {picture->second.begin(), picture->second.end()});
    }
    publish(*status, &result);
  }
  [[nodiscard]] std::string url() const { return server_->url(); }

 private:
  void run() {
    static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), background_niceness));
    while (true) {
      std::optional<CaptureStatus> status;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return is_over_ || (next_ && !has_result_); });
        if (is_over_) return;
        status = std::exchange(next_, std::nullopt);
        last_ = status;
      }
      paint_new(*status, view().get());
      publish(*status, nullptr);
    }
  }

  [[nodiscard]] std::shared_ptr<const LiveView> view() const {
    return calibration_ != nullptr ? calibration_->view() : nullptr;
  }
  void publish(const CaptureStatus& status, const WebResult* result) {
    std::optional<LiveEstimates> known;
    if (calibration_ != nullptr) known = calibration_->estimates();
    const std::string state = web_state(rig_, status, known ? &*known : nullptr, view().get(),
                                        calibration_ != nullptr ? calibration_->goal() : Requirement{}, result);
    const std::lock_guard lock(mutex_);
    if (!has_result_ || result != nullptr) server_->publish(state);  // What stands is not overwritten by what was.
  }

  // One camera at a time, so that nobody waits long for the text.
  void paint_new(const CaptureStatus& status, const LiveView* view) {
    for (std::size_t k = 0; k < status.cameras.size(); ++k) {
      // Behind the last one: a camera that always has a new image must not keep the others from being painted.
      const std::size_t at = (next_camera_ + k) % status.cameras.size();
      const CaptureCamera& camera = status.cameras[at];
      const auto key = std::pair{camera.written, view};
      if (camera.written == 0 || painted_[camera.sensor] == key) continue;
      painted_[camera.sensor] = key;
      const int sensor = rig_.find(camera.sensor);
      if (sensor < 0) continue;
      const auto folder = std::filesystem::path(session_) / "images" / camera.sensor;
      const Expected<ImageFolder> listed = list_image_folder(folder.string());
      if (!listed || listed->images.empty()) continue;
      // Of an image in a stop that is solved there is more to see than of the newest.
      const ListedImage* chosen = &listed->images.back();
      for (const ListedImage& image : listed->images) {
        if (view != nullptr && stop_of(*view, image.number)) chosen = &image;
      }
      auto jpeg = paint(rig_.sensors[static_cast<std::size_t>(sensor)], *chosen, view);
      next_camera_ = at + 1;
      const std::lock_guard lock(mutex_);
      if (jpeg && !has_result_) server_->publish_picture(camera.sensor, std::move(*jpeg));
      return;
    }
  }

  std::unique_ptr<WebServer> server_;
  const Rig& rig_;
  std::string session_;
  const LiveCalibration* calibration_;
  std::map<std::string, std::pair<std::uint64_t, const LiveView*>> painted_;
  std::size_t next_camera_ = 0;  // to be painted
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<CaptureStatus> next_;
  std::optional<CaptureStatus> last_;
  bool has_result_ = false;
  bool is_over_ = false;
  std::thread thread_;
};

WebView::WebView(std::unique_ptr<Painter> painter) : painter_(std::move(painter)) {}
WebView::~WebView() = default;

Expected<std::unique_ptr<WebView>> WebView::start(const WebAddress& address, const Rig& rig, const std::string& session,
                                                  const LiveCalibration* calibration) {
  std::string token;
  if (!address.is_loopback()) {
    Expected<std::string> made = make_token();
    if (!made) return made.error();
    token = std::move(*made);
  }
  auto server = WebServer::start(address, std::move(token), web::page_html());
  if (!server) return server.error();
  return std::unique_ptr<WebView>(
      new WebView(std::make_unique<Painter>(std::move(*server), rig, session, calibration)));
}

void WebView::show(const CaptureStatus& status) { painter_->show(status); }
void WebView::show_result(const CalibrationResult& result) { painter_->show_result(web_result(result)); }
std::string WebView::url() const { return painter_->url(); }

}  // namespace rigcal
