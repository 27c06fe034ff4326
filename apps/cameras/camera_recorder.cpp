#include "apps/cameras/camera_recorder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "core/base/seconds.h"
#include "core/io/output_file.h"
#include "core/io/png_file.h"
#include "core/records/pixel_format.h"

namespace rigcal {
namespace {

using Kind = camera::Delivery::Kind;

constexpr std::int64_t look_ns = 100'000'000;
constexpr int looks_between_searches = 20;  ///< Of look_ns: 2 s.
constexpr std::size_t spare_buffers = 8;    ///< For frames that are on their way while others wait to be written.
constexpr std::size_t most_events = 10'000;
constexpr std::size_t most_pulses = 4096;  ///< For which the writing thread had no time yet.
std::atomic<bool> has_left{false};
constexpr auto match_period = std::chrono::milliseconds(100);

}  // namespace

Expected<std::shared_ptr<CameraRecorder>> CameraRecorder::start(const RigCamera& wanted, CameraDrivers& drivers,
                                                                const std::string& session,
                                                                const net::ClockReading& session_start) {
  const std::string folder = (std::filesystem::path(session) / "images" / wanted.sensor).string();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return cannot_write(folder, error.value());
  auto table = FrameTable::create((std::filesystem::path(folder) / "frames.csv").string());
  if (!table) return table.error();
  std::shared_ptr<CameraRecorder> recorder(
      new CameraRecorder(wanted, drivers.make(wanted.driver), folder, *std::move(table), session_start));
  recorder->taker_ = std::thread([made = recorder] { made->take(); });
  recorder->writer_ = std::thread([made = recorder.get()] { made->write(); });
  // Not the last owner: the thread that takes the frames is one, as it may have to be left behind.
  return std::shared_ptr<CameraRecorder>(recorder.get(), [recorder](CameraRecorder*) { recorder->finish(); });
}

CameraRecorder::CameraRecorder(RigCamera wanted, std::unique_ptr<camera::Camera> camera, std::string folder,
                               FrameTable table, const net::ClockReading& session_start)
    : wanted_(std::move(wanted)),
      camera_(std::move(camera)),
      folder_(std::move(folder)),
      table_(std::move(table)),
      clock_(session_start),
      taking_("frames of " + wanted_.sensor),
      writing_("images of " + wanted_.sensor),
      waiting_(kMostWaiting) {
  pulses_.reserve(most_pulses);
  taken_pulses_.reserve(most_pulses);
  wanted_.config.buffers = kMostWaiting + spare_buffers;
  status_.sensor = wanted_.sensor;
  status_.state = "searching";
}

bool CameraRecorder::has_left_a_camera() { return has_left; }

void CameraRecorder::stop() {
  is_stopped_ = true;
  const std::lock_guard lock(mutex_);
  if (!stopped_at_) stopped_at_ = SteadyClock::now();
}

void CameraRecorder::finish() {
  stop();
  if (taker_.joinable()) {
    bool is_free = false;
    {
      std::unique_lock lock(mutex_);
      is_free = changed_.wait_until(lock, *stopped_at_ + kMostClosing, [this] { return is_free_; });
      has_ended_ = true;
      changed_.notify_all();
    }
    if (is_free) {
      taker_.join();
    } else {
      has_left = true;
      taker_.detach();  // It keeps this recorder alive.
      tell("the camera does not answer; it is left as it is, and put right at the next start", false);
    }
  }
  if (writer_.joinable()) writer_.join();
}

std::int64_t CameraRecorder::now_ns() const { return clock_.from_monotonic(monotonic_now_ns()); }

void CameraRecorder::tell(std::string text, bool is_gap) {
  const std::int64_t stamp_ns = now_ns();
  const std::lock_guard lock(mutex_);
  if (events_.size() < most_events) events_.push_back({stamp_ns, std::move(text), is_gap});
}

void CameraRecorder::set_state(const char* state) {
  const std::lock_guard lock(mutex_);
  if (!status_.failure) status_.state = state;
}

void CameraRecorder::give_up(const Error& error) {
  {
    const std::lock_guard lock(mutex_);
    if (status_.failure) return;
    status_.failure = error;
    status_.state = "failed";
  }
  tell("its images cannot be written, the rest is recorded without it: " + error.message(), true);
}

bool CameraRecorder::has_failed() const {
  const std::lock_guard lock(mutex_);
  return status_.failure.has_value();
}

void CameraRecorder::publish() {
  const camera::CameraCounters counters = camera_->counters();
  const std::lock_guard lock(mutex_);
  status_.counters = counters;
}

void CameraRecorder::take() {
  if (prepare_camera()) take_frames();
  taking_.rest();
  publish();
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
    changed_.notify_all();
  }
  camera_->close();
  for (const std::string& note : camera_->notes()) tell(note, false);
  set_state("ended");
  const std::lock_guard lock(mutex_);
  is_free_ = true;
  changed_.notify_all();
}

bool CameraRecorder::prepare_camera() {
  while (!is_stopped_) {
    auto setup = prepare(*camera_, wanted_);
    if (setup) {
      if (wanted_.has_pulses) expect_pulses(*setup);
      const auto started = camera_->start();
      if (started) {
        exposure_us_ = setup->exposure_us;
        host_stamp_ = setup->host_stamp;
        {
          const std::lock_guard lock(mutex_);
          status_.pixel_format = setup->pixel_format;
        }
        for (const std::string& note : setup->notes) tell(note, false);
        tell(camera_->identity().model + " at " + camera_->identity().address + " was taken", false);
        set_state(wanted_.config.trigger ? "waits" : "sends");
        return true;
      }
      setup = started.error();
    }
    camera_->close();
    // The same trouble is told once.
    if (setup.error().what != std::exchange(last_trouble_, setup.error().what)) tell(setup.error().message(), true);
    for (int i = 0; i < looks_between_searches && !is_stopped_; ++i)
      std::this_thread::sleep_for(std::chrono::nanoseconds(look_ns));
  }
  return false;
}

// Pulses from before it was set up have released no frame. It may be set up more than once before it starts, while the
// writing thread is at the pulses of the last time: that one takes the new matching when it has done so.
void CameraRecorder::expect_pulses(const camera::CameraSetup& setup) {
  FrameMatcherOptions options;
  options.has_device_stamps = setup.has_device_stamps;
  options.ids = setup.frame_ids;
  const double wanted_us = wanted_.config.trigger ? wanted_.config.trigger->delay_us : 0.0;
  const double delay_us = setup.trigger_delay_us.value_or(wanted_us);
  const auto delay_ns = std::llround(1e3 * delay_us);
  const auto exposure_ns = std::llround(1e3 * setup.exposure_us.value_or(0.0));
  const std::int64_t least_exposure_ns = setup.exposure_varies ? 0 : exposure_ns;
  options.least_lag_ns = delay_ns + least_exposure_ns;
  options.most_lag_ns += delay_ns + exposure_ns;
  options.least_interval_ns = least_exposure_ns;
  const std::lock_guard lock(mutex_);
  pulses_.clear();
  new_matching_.emplace(options, delay_us);
  expects_pulses_ = true;
}

void CameraRecorder::add_edge(const TriggerPulse& pulse, bool is_falling) {
  const std::lock_guard lock(mutex_);
  if (!wanted_.config.trigger || wanted_.config.trigger->on_falling_edge != is_falling) return;
  if (!expects_pulses_) return;
  if (pulses_.size() == most_pulses) {
    has_dropped_pulses_ = true;
    return;
  }
  pulses_.push_back(pulse);
}

void CameraRecorder::take_frames() {
  while (!is_stopped_ && !has_failed()) {
    taking_.beat();
    auto delivery = camera_->next(tell_camera());
    if (!delivery) {
      tell(delivery.error().message(), true);
      return;
    }
    switch (delivery->kind) {
      case Kind::frame:
        queue(std::move(delivery->frame));
        break;
      case Kind::lost:
        tell(delivery->text, true);
        set_state("lost");
        break;
      case Kind::refused:
        tell(delivery->text, true);
        break;
      case Kind::back:
        tell(delivery->text, false);
        set_state("sends");
        device_clock_ = DeviceClock();  // It may have begun at zero again.
        break;
      case Kind::ended:
        return;
      case Kind::nothing:
        break;
    }
    publish();
  }
}

// Triggers a camera that is triggered by software, where it is time. How long to wait for what comes.
std::int64_t CameraRecorder::tell_camera() {
  if (!wanted_.is_told || !are_wanted_) return look_ns;
  const std::int64_t now_ns = monotonic_now_ns();
  if (now_ns >= image_due_ns_) {
    const auto told = camera_->trigger();
    // One that is gone is told of as such; the same trouble is told once.
    if (!told && camera_->state() == camera::CameraState::streaming &&
        told.error().what != std::exchange(last_trouble_, told.error().what))
      tell(told.error().message(), true);
    image_due_ns_ = now_ns + std::llround(1e9 / wanted_.config.frame_rate.value_or(usual_image_rate));
  }
  return std::min(look_ns, image_due_ns_ - now_ns);
}

void CameraRecorder::queue(camera::Frame frame) {
  const camera::FrameFacts& facts = frame.facts();
  FrameRecord record;
  const std::int64_t came_ns = clock_.from_monotonic(facts.host_stamp_ns);
  record.exposure_us = facts.exposure_us ? facts.exposure_us : exposure_us_;
  record.device_stamp = facts.device_stamp_ns;
  // The camera's own clock takes the network's delays out.
  const std::int64_t stamped_ns =
      facts.device_stamp_ns ? device_clock_.add(*facts.device_stamp_ns, came_ns).stamp_ns : came_ns;
  // A frame leaves the camera when its exposure has ended; where its start is stamped, its middle is yet to come.
  const std::int64_t half_ns = std::llround(record.exposure_us.value_or(0.0) * 500.0);
  record.stamp_ns = host_stamp_ == camera::HostStamp::exposure_start ? stamped_ns + half_ns : stamped_ns - half_ns;
  const std::lock_guard lock(mutex_);
  if (!frame.is_whole() || has_ended_ || status_.failure) return;
  status_.state = "sends";
  if (count_ == kMostWaiting) {
    ++status_.dropped_by_queue;
    return;
  }
  Waiting& place = waiting_[(first_ + count_) % kMostWaiting];
  place.sighting = {facts.frame_id, facts.device_stamp_ns, came_ns};
  place.frame = std::move(frame);
  place.record = std::move(record);
  ++count_;
  status_.most_waiting = std::max(status_.most_waiting, count_);
  changed_.notify_all();
}

void CameraRecorder::write() {
  while (true) {
    writing_.beat();
    Waiting next;
    bool has_frame = false;
    bool is_last = false;
    bool is_matching = false;
    bool has_dropped_pulses = false;
    taken_pulses_.clear();
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, match_period, [this] { return count_ > 0 || has_ended_; });
      has_frame = count_ > 0;
      is_last = !has_frame && has_ended_;
      if (has_frame) next = std::move(waiting_[first_]);
      if (new_matching_) {
        matching_.emplace(*std::move(new_matching_));
        new_matching_.reset();
      }
      taken_pulses_.swap(pulses_);
      is_matching = matching_.has_value();
      has_dropped_pulses = std::exchange(has_dropped_pulses_, false);
    }
    if (has_dropped_pulses)
      tell("pulses came while the disk was too slow for its images: some images have no pulse", true);
    for (const TriggerPulse& pulse : taken_pulses_) matching_->add_pulse(pulse);
    Expected<void> done;
    if (has_frame) {
      Expected<FrameRecord> written = write(next);
      next.frame.give_back();
      if (written && is_matching) matching_->add_frame(*std::move(written), next.sighting);
      done = !written ? written.error() : is_matching ? Expected<void>() : table_.add(*written);
    }
    if (is_last && is_matching) matching_->finish();
    if (done && is_matching) done = list_matched();
    if (!done) give_up(done.error());
    const std::lock_guard lock(mutex_);
    if (has_frame) {
      first_ = (first_ + 1) % kMostWaiting;
      --count_;
    }
    if (is_last) break;
  }
  writing_.rest();
  if (const auto closed = table_.close(); !closed) give_up(closed.error());
}

Expected<void> CameraRecorder::list_matched() {
  matching_->advance(now_ns());
  while (const auto record = matching_->next()) {
    if (const auto added = table_.add(*record); !added) return added;
  }
  const std::lock_guard lock(mutex_);
  status_.matching = matching_->ledger();
  status_.clock = matching_->clock();
  return {};
}

Expected<FrameRecord> CameraRecorder::write(const Waiting& waiting) {
  const camera::FrameFacts& facts = waiting.frame.facts();
  const auto format = parse_pixel_format(facts.pixel_format);
  if (!format)
    return system_error("images of the format " + std::string(facts.pixel_format) + " cannot be written", folder_);
  PixelView pixels;
  pixels.width = static_cast<std::uint32_t>(facts.width);
  pixels.height = static_cast<std::uint32_t>(facts.height);
  pixels.channels = format->channels();
  pixels.bits = format->stored_bits();
  pixels.blue_first = format->layout == PixelLayout::bgr;
  pixels.step = facts.row_bytes;
  pixels.data = waiting.frame.pixels();
  std::array<char, 32> name{};
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = status_.written;
  }
  std::snprintf(name.data(), name.size(), "%06llu.png", static_cast<unsigned long long>(number));
  const Expected<std::vector<std::uint8_t>> png = encode_png(pixels);
  if (!png) return png.error();
  Expected<OutputFile> file = OutputFile::create((std::filesystem::path(folder_) / name.data()).string());
  if (!file) return file.error();
  file->write(ByteView(*png));
  if (const auto closed = file->close(); !closed) return closed.error();
  // Only images that are there are in the table, so that a recording that is cut short can be read.
  FrameRecord record = waiting.record;
  record.file = name.data();
  const std::lock_guard lock(mutex_);
  ++status_.written;
  status_.worst_wait_ns = std::max(status_.worst_wait_ns, now_ns() - waiting.sighting.received_ns);
  status_.last_image_ns = record.stamp_ns;
  status_.bytes += png->size();
  return record;
}

CaptureCamera CameraRecorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::vector<CaptureEvent> CameraRecorder::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

}  // namespace rigcal
