#include "tests/drivers/camera/fake_video_kernel.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>

#include "core/records/pixel_format.h"
#include "drivers/camera/v4l2/video_formats.h"

namespace rigcal::camera {
namespace {

constexpr int twin_descriptor = 999;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::uint32_t pixel_bytes(std::uint32_t fourcc) {
  const auto format = parse_pixel_format(name_of_fourcc(fourcc));
  return static_cast<std::uint32_t>(format->channels() * format->stored_bits() / 8);
}

}  // namespace

FakeVideoKernel::FakeVideoKernel()
    : fourccs{V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_SRGGB8, V4L2_PIX_FMT_SRGGB12, V4L2_PIX_FMT_YUYV},
      stamp_flags{V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF},
      controls{{V4L2_CID_EXPOSURE_AUTO, {0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY}},
               {V4L2_CID_EXPOSURE_ABSOLUTE, {1, 5000, 150}},
               {V4L2_CID_AUTOGAIN, {0, 1, 1}},
               {V4L2_CID_GAIN, {0, 100, 20}}},
      fourcc_(V4L2_PIX_FMT_GREY) {}

void FakeVideoKernel::unplug() {
  const std::lock_guard lock(mutex_);
  is_there_ = false;
  ++generation_;
  is_streaming_ = false;
  queued_.clear();
  filled_.clear();
  // What is mapped stays as long as it is mapped.
  for (auto& buffer : buffers_) orphans_.push_back(std::move(buffer));
  buffers_.clear();
}

void FakeVideoKernel::plug_in(const std::string& where) {
  const std::lock_guard lock(mutex_);
  path = where;
  is_there_ = true;
  fourcc_ = V4L2_PIX_FMT_GREY;
  width_ = 320;
  height_ = 240;
}

std::vector<std::string> FakeVideoKernel::devices() {
  std::vector<std::string> paths;
  if (!twin.empty()) paths.push_back(twin);
  if (is_there_) paths.push_back(path);
  return paths;
}

int FakeVideoKernel::open(const std::string& which) {
  const std::lock_guard lock(mutex_);
  if (!twin.empty() && which == twin) {
    ++open_;
    return twin_descriptor;
  }
  if (!is_there_ || which != path) return -ENOENT;
  if (open_answer != 0) return open_answer;
  ++open_;
  return 1000 + generation_;
}

void FakeVideoKernel::close(int) {
  const std::lock_guard lock(mutex_);
  --open_;
}

int FakeVideoKernel::control(int descriptor, unsigned long request, void* argument) {
  const std::lock_guard lock(mutex_);
  if (descriptor == twin_descriptor && (request == VIDIOC_S_FMT || request == VIDIOC_REQBUFS)) {
    ++twin_refusals;
    return -EBUSY;
  }
  if (descriptor == twin_descriptor) return answer(request, argument);
  if (descriptor != 1000 + generation_) return -ENODEV;
  return answer(request, argument);
}

int FakeVideoKernel::answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& what = *static_cast<v4l2_capability*>(argument);
      std::memcpy(what.card, card.data(), std::min(card.size(), sizeof what.card - 1));
      std::memcpy(what.driver, driver.data(), std::min(driver.size(), sizeof what.driver - 1));
      std::memcpy(what.bus_info, "usb-1.2", 8);
      what.capabilities = V4L2_CAP_DEVICE_CAPS;
      what.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& listed = *static_cast<v4l2_fmtdesc*>(argument);
      if (listed.index >= fourccs.size()) return -EINVAL;
      listed.pixelformat = fourccs[listed.index];
      return 0;
    }
    case VIDIOC_ENUM_FRAMESIZES: {
      auto& listed = *static_cast<v4l2_frmsizeenum*>(argument);
      if (listed.index > 0) return -EINVAL;
      listed.type = V4L2_FRMSIZE_TYPE_STEPWISE;
      listed.stepwise = {16, most_width, 2, 16, most_height, 2};
      return 0;
    }
    case VIDIOC_G_FMT: {
      v4l2_pix_format& now = static_cast<v4l2_format*>(argument)->fmt.pix;
      now.width = width_;
      now.height = height_;
      now.pixelformat = fourcc_;
      now.bytesperline = width_ * pixel_bytes(fourcc_) + padding;
      now.sizeimage = now.bytesperline * height_;
      return 0;
    }
    case VIDIOC_S_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_SELECTION:
    case VIDIOC_S_SELECTION: {
      if (!can_cut) return -ENOTTY;
      auto& part = *static_cast<v4l2_selection*>(argument);
      if (request == VIDIOC_S_SELECTION) {
        left_ = std::min(static_cast<std::uint32_t>(std::max(part.r.left, 0)), most_width - 16);
        top_ = std::min(static_cast<std::uint32_t>(std::max(part.r.top, 0)), most_height - 16);
      }
      part.r.left = static_cast<std::int32_t>(left_);
      part.r.top = static_cast<std::int32_t>(top_);
      return 0;
    }
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      v4l2_captureparm& rate = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      if (request == VIDIOC_S_PARM && rate.timeperframe.numerator > 0)
        rate_ =
            std::clamp(static_cast<double>(rate.timeperframe.denominator) / rate.timeperframe.numerator, 1.0, 100.0);
      rate.capability = can_set_rate ? V4L2_CAP_TIMEPERFRAME : 0;
      rate.timeperframe = {1000, static_cast<std::uint32_t>(rate_ * 1000.0)};
      return 0;
    }
    case VIDIOC_QUERYCTRL: {
      auto& limits = *static_cast<v4l2_queryctrl*>(argument);
      const auto it = controls.find(limits.id);
      if (it == controls.end()) return -EINVAL;
      limits.minimum = it->second.least;
      limits.maximum = it->second.most;
      return 0;
    }
    case VIDIOC_G_CTRL:
    case VIDIOC_S_CTRL: {
      auto& setting = *static_cast<v4l2_control*>(argument);
      const auto it = controls.find(setting.id);
      if (it == controls.end()) return -EINVAL;
      if (request == VIDIOC_G_CTRL) {
        setting.value = it->second.value;
      } else if (setting.value < it->second.least || setting.value > it->second.most) {
        return -ERANGE;
      } else {
        it->second.value = setting.value;
      }
      return 0;
    }
    case VIDIOC_REQBUFS: {
      auto& wanted = *static_cast<v4l2_requestbuffers*>(argument);
      if (is_held || is_streaming_) return -EBUSY;
      wanted.count = std::min(wanted.count, most_buffers);
      buffers_.clear();
      queued_.clear();
      filled_.clear();
      const std::uint32_t bytes = (width_ * pixel_bytes(fourcc_) + padding) * height_;
      for (std::uint32_t i = 0; i < wanted.count; ++i) {
        buffers_.push_back(std::make_unique<Buffer>());
        buffers_.back()->bytes.resize(bytes);
      }
      return 0;
    }
    case VIDIOC_QUERYBUF:
      return describe(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return take(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      is_streaming_ = true;
      sequence_ = 0;
      due_ns_ = now_ns() + static_cast<std::int64_t>(1e9 / rate_);
      return 0;
    case VIDIOC_STREAMOFF:
      is_streaming_ = false;
      breaks_off = false;
      for (const auto& buffer : buffers_) buffer->is_queued = false;
      queued_.clear();
      filled_.clear();
      return 0;
    case VIDIOC_SUBSCRIBE_EVENT:
      return 0;
    case VIDIOC_DQEVENT:
      if (!has_changed) return -ENOENT;
      has_changed = false;
      static_cast<v4l2_event*>(argument)->type = V4L2_EVENT_SOURCE_CHANGE;
      return 0;
    default:
      return -ENOTTY;
  }
}

int FakeVideoKernel::set_format(v4l2_format& format) {
  if (is_held || !buffers_.empty()) return -EBUSY;
  v4l2_pix_format& wanted = format.fmt.pix;
  if (std::find(fourccs.begin(), fourccs.end(), wanted.pixelformat) != fourccs.end()) fourcc_ = wanted.pixelformat;
  width_ = std::clamp(wanted.width & ~1U, 16U, most_width);
  height_ = std::clamp(wanted.height & ~1U, 16U, most_height);
  wanted.field = V4L2_FIELD_NONE;
  return answer(VIDIOC_G_FMT, &format);
}

int FakeVideoKernel::describe(v4l2_buffer& buffer) {
  if (buffer.index >= buffers_.size()) return -EINVAL;
  buffer.length = static_cast<std::uint32_t>(buffers_[buffer.index]->bytes.size());
  buffer.m.offset = buffer.index * 4096;
  buffer.flags = stamp_flags;
  return 0;
}

int FakeVideoKernel::queue(const v4l2_buffer& buffer) {
  if (buffer.index >= buffers_.size() || buffers_[buffer.index]->is_queued) return -EINVAL;
  buffers_[buffer.index]->is_queued = true;
  queued_.push_back(buffer.index);
  return 0;
}

int FakeVideoKernel::take(v4l2_buffer& buffer) {
  if (breaks_off) return -EIO;
  if (!is_streaming_) return -EINVAL;
  if (filled_.empty()) return -EAGAIN;
  buffer.index = static_cast<std::uint32_t>(filled_.front());
  filled_.erase(filled_.begin());
  Buffer& taken = *buffers_[buffer.index];
  taken.is_queued = false;
  buffer.bytesused = taken.used;
  buffer.sequence = taken.sequence;
  buffer.flags = taken.flags | stamp_flags;
  buffer.timestamp.tv_sec = taken.stamp_ns / 1'000'000'000;
  buffer.timestamp.tv_usec = taken.stamp_ns % 1'000'000'000 / 1000;
  return 0;
}

void* FakeVideoKernel::map(int, std::size_t bytes, std::int64_t offset) {
  const std::lock_guard lock(mutex_);
  const auto index = static_cast<std::size_t>(offset / 4096);
  if (index >= buffers_.size() || bytes > buffers_[index]->bytes.size()) return nullptr;
  ++mapped_;
  return buffers_[index]->bytes.data();
}

void FakeVideoKernel::unmap(void*, std::size_t) {
  const std::lock_guard lock(mutex_);
  --mapped_;
}

void FakeVideoKernel::fill_due(std::int64_t time_ns) {
  while (is_streaming_ && due_ns_ <= time_ns) {
    sequence_ += skip;
    skip = 0;
    if (!queued_.empty()) {
      const std::size_t index = queued_.front();
      queued_.erase(queued_.begin());
      Buffer& buffer = *buffers_[index];
      for (std::size_t i = 0; i < buffer.bytes.size(); ++i) buffer.bytes[i] = pixel(sequence_, i);
      buffer.used = static_cast<std::uint32_t>(shortens_next ? buffer.bytes.size() / 2 : buffer.bytes.size());
      buffer.flags = damages_next ? V4L2_BUF_FLAG_ERROR : 0;
      buffer.sequence = sequence_;
      buffer.stamp_ns = due_ns_;
      shortens_next = false;
      damages_next = false;
      filled_.push_back(index);
    }
    ++sequence_;
    due_ns_ += static_cast<std::int64_t>(1e9 / rate_);
  }
}

VideoKernel::Ready FakeVideoKernel::wait(int descriptor, std::int64_t timeout_ns) {
  const std::int64_t deadline_ns = now_ns() + timeout_ns;
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      fill_due(now_ns());
      Ready ready;
      ready.gone = descriptor != 1000 + generation_;
      ready.event = has_changed || ready.gone;
      ready.frame = !filled_.empty();
      ready.error = breaks_off || ready.gone || (is_error_while_dry && queued_.empty() && filled_.empty());
      if (ready.gone || ready.event || ready.frame || ready.error || now_ns() >= deadline_ns) return ready;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace rigcal::camera
