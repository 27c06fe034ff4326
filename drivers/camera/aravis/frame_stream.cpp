#include "drivers/camera/aravis/frame_stream.h"

#include <arv.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "drivers/camera/aravis/buffer_image.h"
#include "drivers/camera/aravis/problem.h"
#include "drivers/net/session_clock.h"

namespace rigcal::camera {
namespace {

FrameStatus status_of(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return FrameStatus::whole;
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return FrameStatus::wrong_size;
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return FrameStatus::out_of_order;
    default:
      return FrameStatus::incomplete;
  }
}

}  // namespace

/// The memory of all buffers, and what Aravis knows of those that are lent.
class FrameStream::Store final : public FrameStore {
 public:
  Store(std::size_t buffers, std::size_t bytes, std::string pixel_format)
      : pixel_format_(std::move(pixel_format)), bytes_(bytes), memory_(buffers * bytes), lent_(buffers) {}

  void open(ArvStream* stream) {
    for (std::size_t i = 0; i < lent_.size(); ++i) {
      // The buffer's number is its user data: a pointer that is none.
      arv_stream_push_buffer(stream,
                             arv_buffer_new_full(bytes_, memory_.data() + i * bytes_, GSIZE_TO_POINTER(i), nullptr));
    }
    const std::lock_guard lock(mutex_);
    stream_ = stream;
  }
  /// No buffer goes back to the stream from now on.
  void close() {
    const std::lock_guard lock(mutex_);
    stream_ = nullptr;
  }
  std::size_t lend(ArvBuffer* buffer) {
    const std::size_t index = GPOINTER_TO_SIZE(arv_buffer_get_user_data(buffer));
    const std::lock_guard lock(mutex_);
    lent_[index] = buffer;
    return index;
  }
  void give_back(std::size_t index) noexcept override {
    const std::lock_guard lock(mutex_);
    ArvBuffer* buffer = std::exchange(lent_[index], nullptr);
    if (stream_ != nullptr) {
      arv_stream_push_buffer(stream_, buffer);
    } else {
      g_object_unref(buffer);
    }
  }
  [[nodiscard]] const std::string& pixel_format() const { return pixel_format_; }

 private:
  std::string pixel_format_;
  std::size_t bytes_;
  std::vector<std::uint8_t> memory_;
  std::mutex mutex_;
  ArvStream* stream_ = nullptr;
  std::vector<ArvBuffer*> lent_;
};

Expected<std::unique_ptr<FrameStream>> FrameStream::start(Device& device, const CameraSetup& setup, std::size_t buffers,
                                                          const AravisOptions& options) {
  std::unique_ptr<FrameStream> made(new FrameStream);
  made->setup_ = setup;
  made->counter_ = FrameCounter(setup.frame_ids);
  const std::string& who = device.identity().id;
  // Not the asynchronous one: as Debian 12 has it (0.8.26), it keeps a core busy while all buffers are under way,
  // notices late that a camera was unplugged, and does not always come back from the end of a stream.
  if (device.is_usb()) arv_camera_uv_set_usb_mode(device.get(), ARV_UV_USB_MODE_SYNC);
  if (device.is_gige()) {
    arv_camera_gv_set_stream_options(
        device.get(), options.packet_socket ? ARV_GV_STREAM_OPTION_NONE : ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  Problem problem;
  const std::size_t payload = arv_camera_get_payload(device.get(), problem.put());
  if (auto done = problem.result("the camera does not say how large its frames are", who); !done) return done.error();
  if (payload < setup.image_bytes || payload > setup.image_bytes + kMostChunkBytes) {
    return system_error("the camera's frames of " + std::to_string(payload) + " bytes do not fit its images of " +
                            std::to_string(setup.image_bytes),
                        who, "choose another pixel format");
  }
  made->stream_ = arv_camera_create_stream(device.get(), nullptr, nullptr, problem.put());
  if (auto done = problem.result("the camera's stream cannot be opened", who); !done) return done.error();
  if (device.is_gige()) {
    g_object_set(made->stream_, "packet-resend",
                 options.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                 "packet-timeout", static_cast<guint>(options.packet_timeout_us), "frame-retention",
                 static_cast<guint>(options.frame_retention_us), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", static_cast<gint>(options.receive_bytes), nullptr);
  }
  if (device.has("ChunkModeActive")) {
    const Expected<std::string> is_active = device.get("ChunkModeActive");
    const auto names = names_of(Purpose::chunk_exposure, device.vendor());
    if (is_active && *is_active == "true") {
      made->chunks_ = arv_camera_create_chunk_parser(device.get());
      made->exposure_chunk_ = std::string(names[0]);
    }
  }
  made->store_ = std::make_shared<Store>(buffers, payload, setup.pixel_format);
  made->store_->open(made->stream_);
  arv_camera_start_acquisition(device.get(), problem.put());
  if (auto done = problem.result("the camera does not start", who); !done) return done.error();
  return made;
}

FrameStream::~FrameStream() {
  abandon();
  if (chunks_ != nullptr) g_object_unref(chunks_);
}

std::optional<Frame> FrameStream::next(std::int64_t timeout_ns) {
  ArvBuffer* buffer =
      arv_stream_timeout_pop_buffer(stream_, static_cast<guint64>(std::max<std::int64_t>(timeout_ns, 0)) / 1000);
  if (buffer == nullptr) return std::nullopt;
  return read(buffer);
}

Frame FrameStream::read(void* popped) {
  auto* buffer = static_cast<ArvBuffer*>(popped);
  const std::size_t index = store_->lend(buffer);
  FrameFacts facts;
  facts.status = status_of(arv_buffer_get_status(buffer));
  facts.frame_id = arv_buffer_get_frame_id(buffer);
  facts.missing_before = counter_.missing_before(facts.frame_id);
  // Aravis counts every packet that finds no buffer; how many frames that were is told by their ids.
  guint64 underruns = 0;
  arv_stream_get_statistics(stream_, nullptr, nullptr, &underruns);
  if (underruns > underruns_) counts_.no_buffer += facts.missing_before;
  underruns_ = underruns;
  // Aravis stamps with the time of day, when the frame's first packet came; the time of day may be set since.
  const net::ClockReading now = net::read_clocks();
  realtime_.update(now);
  const auto came_ns = static_cast<std::int64_t>(arv_buffer_get_system_timestamp(buffer));
  facts.host_stamp_ns = came_ns > 0 ? realtime_.recent_monotonic(came_ns, now, last_came_ns_) : now.monotonic_ns;
  last_came_ns_ = facts.host_stamp_ns;
  facts.width = setup_.width;
  facts.height = setup_.height;
  facts.row_bytes = setup_.image_bytes / static_cast<std::size_t>(setup_.height);
  facts.pixel_format = store_->pixel_format();
  ByteView pixels;
  // Of a frame that is not whole no field can be trusted but its id.
  if (facts.status == FrameStatus::whole) {
    const auto device_ns = static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer));
    // Cameras that have no clock say zero, or always the same.
    if (device_ns > 0 && device_ns != last_device_ns_) facts.device_stamp_ns = device_ns;
    last_device_ns_ = device_ns;
    std::size_t size = 0;
    const auto* data = image_data(buffer, &size);
    if (data == nullptr || size < setup_.image_bytes || has_padded_rows(buffer) ||
        arv_buffer_get_image_width(buffer) != setup_.width || arv_buffer_get_image_height(buffer) != setup_.height) {
      facts.status = FrameStatus::wrong_size;
    } else {
      pixels = ByteView(data, setup_.image_bytes);
      if (chunks_ != nullptr && arv_buffer_has_chunks(buffer)) {
        Problem problem;
        const double exposure_us =
            arv_chunk_parser_get_float_value(chunks_, buffer, exposure_chunk_.c_str(), problem.put());
        if (problem.is_none()) facts.exposure_us = exposure_us;
      }
    }
  }
  return {facts, pixels, store_, index};
}

Expected<void> FrameStream::stop(Device& device) {
  Problem problem;
  arv_camera_stop_acquisition(device.get(), problem.put());
  device.heard(problem);
  abandon();
  return problem.result("the camera does not stop", device.identity().id);
}

void FrameStream::abandon() {
  if (stream_ == nullptr) return;
  if (store_) store_->close();
  counts_ = counts();
  gint waiting = 0;
  arv_stream_get_n_buffers(stream_, nullptr, &waiting);
  counts_.discarded = static_cast<std::uint64_t>(std::max(waiting, 0));
  g_object_unref(stream_);  // Ends its thread, and drops the buffers that nobody has.
  stream_ = nullptr;
}

FrameStream::Counts FrameStream::counts() const {
  if (stream_ == nullptr) return counts_;
  Counts counts = counts_;
  if (ARV_IS_GV_STREAM(stream_))
    counts.resent_packets = arv_stream_get_info_uint64_by_name(stream_, "n_resent_packets");
  return counts;
}

}  // namespace rigcal::camera
