#include "drivers/camera/v4l2/video_setter.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/records/pixel_format.h"
#include "drivers/camera/camera.h"
#include "drivers/camera/v4l2/video_errors.h"
#include "drivers/camera/v4l2/video_formats.h"

namespace rigcal::camera {
namespace {

/// Drivers that never end a list are not asked for ever; that of `vivid` has a hundred formats.
constexpr int most_listed = 1024;

/// The unit of V4L2_CID_EXPOSURE_ABSOLUTE.
constexpr double exposure_step_us = 100.0;

v4l2_format format_question() {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  return format;
}

v4l2_streamparm rate_question() {
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  return rate;
}

std::optional<double> rate_of(const v4l2_streamparm& rate) {
  const v4l2_fract& period = rate.parm.capture.timeperframe;
  if ((rate.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0 || period.numerator == 0) return std::nullopt;
  return static_cast<double>(period.denominator) / period.numerator;
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

std::string word_of(std::uint32_t fourcc) {
  std::string word;
  for (int shift = 0; shift < 32; shift += 8) word += static_cast<char>((fourcc >> shift) & 0x7FU);
  return word;
}

}  // namespace

Error VideoSetter::refused(std::string what, std::string mend) const {
  return system_error(std::move(what), device_->path(), std::move(mend));
}

Expected<CameraSetup> VideoSetter::apply(const CameraConfig& config) {
  setup_ = {};
  if (config.trigger) return refused("cameras of Video4Linux have no trigger that rigcal knows", "leave trigger out");
  if (config.ptp) return refused("the camera has no PTP", "leave ptp out");
  if (!config.strobe.empty()) return refused("the camera has no strobe", "leave strobe out");
  if (config.packet_bytes || config.packet_delay_ns)
    setup_.notes.push_back("packets are of the network: the camera has none");
  if (auto done = set_format(config); !done) return done.error();
  if (config.frame_rate) {
    if (auto done = set_rate(*config.frame_rate); !done) return done.error();
  }
  if (config.exposure_us) {
    if (auto done = set_exposure(*config.exposure_us); !done) return done.error();
  }
  if (config.gain) {
    if (auto done = set_gain(*config.gain); !done) return done.error();
  }
  v4l2_streamparm rate = rate_question();
  if (device_->control(VIDIOC_G_PARM, &rate) == 0) setup_.frame_rate = rate_of(rate);
  if (const auto exposure = control(V4L2_CID_EXPOSURE_ABSOLUTE)) setup_.exposure_us = *exposure * exposure_step_us;
  setup_.frame_ids = v4l2_sequence_numbers;
  return setup_;
}

void VideoSetter::restore() {
  for (auto it = undo_.rbegin(); it != undo_.rend(); ++it) (*it)();
  undo_.clear();
}

Expected<void> VideoSetter::set_format(const CameraConfig& config) {
  v4l2_format now = format_question();
  if (const int code = device_->control(VIDIOC_G_FMT, &now); code != 0)
    return video_error("the camera does not say what it sends", device_->path(), code);
  std::vector<std::string> usable;
  for (std::uint32_t i = 0; i < most_listed; ++i) {
    v4l2_fmtdesc listed{};
    listed.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    listed.index = i;
    if (device_->control(VIDIOC_ENUM_FMT, &listed) != 0) break;
    const std::string name(name_of_fourcc(listed.pixelformat));
    if (!name.empty() && std::find(usable.begin(), usable.end(), name) == usable.end()) usable.push_back(name);
  }
  std::string name = config.pixel_format;
  if (name.empty()) name = name_of_fourcc(now.fmt.pix.pixelformat);
  if (std::find(usable.begin(), usable.end(), name) == usable.end()) {
    if (name.empty()) name = word_of(now.fmt.pix.pixelformat);
    return refused("the camera has no pixel format " + name + " that rigcal can read", "it has " + list_text(usable));
  }
  if (config.region) {
    if (auto done = set_crop(*config.region); !done) return done;
  }
  v4l2_format wanted = now;
  wanted.fmt.pix.pixelformat = fourcc_of(name);
  wanted.fmt.pix.field = V4L2_FIELD_NONE;
  wanted.fmt.pix.bytesperline = 0;
  wanted.fmt.pix.sizeimage = 0;
  if (config.region) {
    wanted.fmt.pix.width = static_cast<std::uint32_t>(config.region->width);
    wanted.fmt.pix.height = static_cast<std::uint32_t>(config.region->height);
  }
  const v4l2_format asked = wanted;
  undo_.emplace_back([device = device_, now]() mutable { device->control(VIDIOC_S_FMT, &now); });
  if (const int code = device_->control(VIDIOC_S_FMT, &wanted); code != 0)
    return video_error("the camera does not take the pixel format " + name, device_->path(), code);
  const v4l2_pix_format& got = wanted.fmt.pix;
  if (got.pixelformat != asked.fmt.pix.pixelformat)
    return refused("the camera sends " + word_of(got.pixelformat) + " in place of " + name, "choose another format");
  if (config.region && (got.width != asked.fmt.pix.width || got.height != asked.fmt.pix.height)) {
    return refused(
        "the camera has no images of " + size_text(asked.fmt.pix.width, asked.fmt.pix.height) + " pixels in " + name,
        "it has " + sizes_text(got.pixelformat));
  }
  if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY)
    return refused("the camera sends half images, one row of two", "use a camera with a progressive sensor");
  const PixelFormat layout = *parse_pixel_format(name);
  const std::uint64_t packed =
      std::uint64_t{got.width} * static_cast<std::uint64_t>(layout.channels() * layout.stored_bits() / 8);
  row_bytes_ = std::max<std::uint64_t>(got.bytesperline, packed);
  if (got.width == 0 || got.height == 0 || got.width > 65535 || got.height > 65535 || got.bytesperline > 1U << 24U)
    return refused("the camera's images of " + size_text(got.width, got.height) + " have no sane size",
                   "choose another");
  setup_.pixel_format = name;
  setup_.width = static_cast<int>(got.width);
  setup_.height = static_cast<int>(got.height);
  setup_.image_bytes = row_bytes_ * got.height;
  return {};
}

/// Where the part lies; how large it is, is a matter of the format. A driver that cannot cut has only parts from the
/// top left on.
Expected<void> VideoSetter::set_crop(const Region& region) {
  v4l2_selection before{};
  before.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  before.target = V4L2_SEL_TGT_CROP;
  const bool can_cut = device_->control(VIDIOC_G_SELECTION, &before) == 0;
  if (!can_cut) {
    if (region.x == 0 && region.y == 0) return {};
    return refused("the camera's images have no offset", "give the part the offset 0, 0");
  }
  v4l2_selection wanted = before;
  wanted.r = {region.x, region.y, static_cast<std::uint32_t>(region.width), static_cast<std::uint32_t>(region.height)};
  const v4l2_rect asked = wanted.r;
  undo_.emplace_back([device = device_, before]() mutable { device->control(VIDIOC_S_SELECTION, &before); });
  const int code = device_->control(VIDIOC_S_SELECTION, &wanted);
  const bool is_there = code == 0 && wanted.r.left == asked.left && wanted.r.top == asked.top;
  if (is_there || (region.x == 0 && region.y == 0)) return {};
  return refused(
      "the camera has no part of its sensor at " + std::to_string(region.x) + ", " + std::to_string(region.y),
      "give the part the offset 0, 0");
}

Expected<void> VideoSetter::set_rate(double frame_rate) {
  v4l2_streamparm before = rate_question();
  if (device_->control(VIDIOC_G_PARM, &before) != 0 || !rate_of(before))
    return refused("the camera's frame rate cannot be set", "leave frame_rate out");
  v4l2_streamparm wanted = before;
  wanted.parm.capture.timeperframe = {1000,
                                      static_cast<std::uint32_t>(std::lround(std::min(frame_rate, 1e6) * 1000.0))};
  undo_.emplace_back([device = device_, before]() mutable { device->control(VIDIOC_S_PARM, &before); });
  if (const int code = device_->control(VIDIOC_S_PARM, &wanted); code != 0)
    return video_error("the frame rate cannot be set", device_->path(), code);
  const double got = rate_of(wanted).value_or(0.0);
  if (std::abs(got - frame_rate) > 0.01 * frame_rate) {
    setup_.notes.push_back("the camera made " + fixed_text(got, 2) + " of the frame rate " + fixed_text(frame_rate, 2));
  }
  return {};
}

Expected<void> VideoSetter::set_exposure(double exposure_us) {
  if (!control(V4L2_CID_EXPOSURE_ABSOLUTE))
    return refused("the camera's exposure cannot be set", "leave exposure_us out");
  if (control(V4L2_CID_EXPOSURE_AUTO)) {
    if (auto done = set_control(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "the exposure by hand"); !done)
      return done;
  }
  return set_within(V4L2_CID_EXPOSURE_ABSOLUTE, exposure_us, exposure_step_us, "an exposure in us");
}

Expected<void> VideoSetter::set_gain(double gain) {
  const std::uint32_t id = control(V4L2_CID_ANALOGUE_GAIN) ? V4L2_CID_ANALOGUE_GAIN : V4L2_CID_GAIN;
  if (!control(id)) return refused("the camera's gain cannot be set", "leave gain out");
  if (control(V4L2_CID_AUTOGAIN)) {
    if (auto done = set_control(V4L2_CID_AUTOGAIN, 0, "the gain by hand"); !done) return done;
  }
  setup_.gain = gain;
  return set_within(id, gain, 1.0, "a gain");
}

Expected<void> VideoSetter::set_within(std::uint32_t id, double value, double step_unit, const std::string& what) {
  v4l2_queryctrl limits{};
  limits.id = id;
  if (const int code = device_->control(VIDIOC_QUERYCTRL, &limits); code != 0)
    return video_error("the camera does not know " + what, device_->path(), code);
  const double steps = value / step_unit;
  if (steps < limits.minimum - 0.5 || steps > limits.maximum + 0.5) {
    return refused(what + " of " + fixed_text(value, 2) + " is not possible",
                   "the camera takes " + fixed_text(limits.minimum * step_unit, 2) + " to " +
                       fixed_text(limits.maximum * step_unit, 2));
  }
  return set_control(id, static_cast<std::int32_t>(std::lround(steps)), what);
}

Expected<void> VideoSetter::set_control(std::uint32_t id, std::int32_t value, const std::string& what) {
  const std::optional<std::int32_t> before = control(id);
  if (before == value) return {};
  if (before) {
    undo_.emplace_back([device = device_, id, old = *before] {
      v4l2_control setting{id, old};
      device->control(VIDIOC_S_CTRL, &setting);
    });
  }
  v4l2_control setting{id, value};
  if (const int code = device_->control(VIDIOC_S_CTRL, &setting); code != 0)
    return video_error("the camera does not take " + what, device_->path(), code);
  return {};
}

std::optional<std::int32_t> VideoSetter::control(std::uint32_t id) const {
  v4l2_control setting{id, 0};
  if (device_->control(VIDIOC_G_CTRL, &setting) != 0) return std::nullopt;
  return setting.value;
}

std::string VideoSetter::sizes_text(std::uint32_t fourcc) const {
  std::vector<std::string> sizes;
  for (std::uint32_t i = 0; i < most_listed; ++i) {
    v4l2_frmsizeenum listed{};
    listed.index = i;
    listed.pixel_format = fourcc;
    if (device_->control(VIDIOC_ENUM_FRAMESIZES, &listed) != 0) break;
    if (listed.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.push_back(size_text(listed.discrete.width, listed.discrete.height));
      continue;
    }
    const v4l2_frmsize_stepwise& range = listed.stepwise;
    return size_text(range.min_width, range.min_height) + " to " + size_text(range.max_width, range.max_height) +
           " in steps of " + size_text(std::max(range.step_width, 1U), std::max(range.step_height, 1U));
  }
  return sizes.empty() ? "only its own" : list_text(sizes);
}

}  // namespace rigcal::camera
