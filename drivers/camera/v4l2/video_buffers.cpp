#include "drivers/camera/v4l2/video_buffers.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/base/seconds.h"
#include "drivers/camera/camera_config.h"
#include "drivers/camera/v4l2/video_errors.h"

namespace rigcal::camera {
namespace {

v4l2_buffer description(std::size_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = static_cast<std::uint32_t>(index);
  return buffer;
}

bool is_monotonic(const v4l2_buffer& buffer) {
  return (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
}

}  // namespace

Expected<std::shared_ptr<VideoBuffers>> VideoBuffers::make(std::shared_ptr<const VideoDevice> device, std::size_t count,
                                                           std::string pixel_format) {
  const std::string where = device->path();
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(count);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int code = device->control(VIDIOC_REQBUFS, &request); code != 0)
    return video_error("the camera gives no buffers", where, code);
  if (request.count < kFewestBuffers)
    return system_error("the camera gives only " + std::to_string(request.count) + " buffers", where,
                        "end other programs that use it, or choose smaller images");
  std::shared_ptr<VideoBuffers> made(new VideoBuffers(device, std::move(pixel_format)));
  // The driver may give more than were asked for, or fewer.
  const std::size_t there = std::min<std::size_t>(request.count, count);
  for (std::size_t i = 0; i < there; ++i) {
    v4l2_buffer buffer = description(i);
    if (const int code = device->control(VIDIOC_QUERYBUF, &buffer); code != 0)
      return video_error("a buffer of the camera cannot be asked for", where, code);
    auto* memory = static_cast<std::uint8_t*>(device->map(buffer.length, buffer.m.offset));
    if (memory == nullptr)
      return system_error("a buffer of the camera cannot be mapped", where, "use a machine with more memory");
    made->places_.push_back({memory, buffer.length, false});
    made->stamps_exposure_ =
        is_monotonic(buffer) && (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  }
  return made;
}

VideoBuffers::~VideoBuffers() {
  for (const Place& place : places_) device_->unmap(place.memory, place.bytes);
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  device_->control(VIDIOC_REQBUFS, &none);
  if (at_end_) at_end_();
}

int VideoBuffers::queue(std::size_t buffer) const {
  v4l2_buffer queued = description(buffer);
  return device_->control(VIDIOC_QBUF, &queued);
}

Expected<void> VideoBuffers::start() {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i].is_lent) continue;
    if (const int code = queue(i); code != 0)
      return video_error("a buffer cannot be handed to the camera", device_->path(), code);
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int code = device_->control(VIDIOC_STREAMON, &type); code != 0) {
    device_->control(VIDIOC_STREAMOFF, &type);
    return video_error("the camera does not start", device_->path(), code);
  }
  is_running_ = true;
  return {};
}

std::uint64_t VideoBuffers::stop() {
  std::uint64_t waiting = 0;
  Filled filled;
  while (take(filled) == 0) {
    const std::lock_guard lock(mutex_);
    places_[filled.buffer].is_lent = false;
    --lent_;
    ++waiting;
  }
  const std::lock_guard lock(mutex_);
  is_running_ = false;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device_->control(VIDIOC_STREAMOFF, &type);
  return waiting;
}

int VideoBuffers::take(Filled& filled) {
  v4l2_buffer buffer = description(0);
  if (const int code = device_->control(VIDIOC_DQBUF, &buffer); code != 0) return code;
  const std::lock_guard lock(mutex_);
  if (buffer.index >= places_.size() || places_[buffer.index].is_lent) return -EIO;
  Place& place = places_[buffer.index];
  place.is_lent = true;
  ++lent_;
  filled.buffer = buffer.index;
  filled.bytes = std::min<std::size_t>(buffer.bytesused, place.bytes);
  filled.sequence = buffer.sequence;
  filled.is_damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  filled.stamp_ns = is_monotonic(buffer) ? std::int64_t{buffer.timestamp.tv_sec} * ns_per_second +
                                               std::int64_t{buffer.timestamp.tv_usec} * 1000
                                         : 0;
  return 0;
}

void VideoBuffers::give_back(std::size_t buffer) noexcept {
  const std::lock_guard lock(mutex_);
  places_[buffer].is_lent = false;
  --lent_;
  // Where the device is gone nothing is to be done: the camera notices by itself.
  if (is_running_) static_cast<void>(queue(buffer));
}

ByteView VideoBuffers::bytes(std::size_t buffer, std::size_t size) const {
  const std::lock_guard lock(mutex_);
  return {places_[buffer].memory, std::min(size, places_[buffer].bytes)};
}

bool VideoBuffers::is_dry() const {
  const std::lock_guard lock(mutex_);
  return lent_ == places_.size();
}

std::size_t VideoBuffers::smallest() const {
  const std::lock_guard lock(mutex_);
  std::size_t smallest = SIZE_MAX;
  for (const Place& place : places_) smallest = std::min(smallest, place.bytes);
  return smallest;
}

}  // namespace rigcal::camera
