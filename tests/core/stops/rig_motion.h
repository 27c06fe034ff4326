#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/random.h"
#include "core/stops/stop_finder.h"

namespace rigcal {

/// What a rig did, built piece by piece, with its gyro readings and ready-made points: the truth for tests of stops.
class RigMotion {
 public:
  struct Rest {
    double start_s, settled_s, end_s;  ///< Settled: the swing's amplitude has fallen to 0.1 mrad.
    double swing_rad, decay_s;         ///< Amplitude at the start, time constant.
  };

  /// Stands still for that long, a swing of the last turn included.
  void rest(double seconds) {
    const double settled = time_ + (amplitude_ > limit ? tau_ * std::log(amplitude_ / limit) : 0.0);
    rests_.push_back({time_, settled, time_ + seconds, amplitude_, tau_});
    pieces_.push_back({time_, time_ + seconds, 0.0, 0.0, amplitude_, tau_, hz_});
    time_ += seconds;
    amplitude_ = 0.0;
  }
  /// A trapezoid of the rate; the swing that follows sets in when it is over.
  void turn(double angle_deg, double rate_deg_s, double acceleration_deg_s2, double swing_rad = 0.0, double tau_s = 0.1,
            double hz = 4.0) {
    const double rate = std::min(rate_deg_s, std::sqrt(std::abs(angle_deg) * acceleration_deg_s2));
    const double ramp = rate / acceleration_deg_s2;
    const double seconds = std::abs(angle_deg) / rate + ramp;
    const double sign = angle_deg < 0.0 ? -1.0 : 1.0;
    pieces_.push_back({time_, time_ + seconds, sign * to_rad(rate), ramp, 0.0, 1.0, 1.0});
    time_ += seconds;
    amplitude_ = swing_rad;
    tau_ = tau_s;
    hz_ = hz;
  }
  /// A constant rate without ramps.
  void creep(double rate_deg_s, double seconds) {
    pieces_.push_back({time_, time_ + seconds, to_rad(rate_deg_s), 0.0, 0.0, 1.0, 1.0});
    time_ += seconds;
  }

  [[nodiscard]] double length_s() const { return time_; }
  [[nodiscard]] const std::vector<Rest>& rests() const { return rests_; }

  /// Rate of the table and of the swing at that time, rad/s.
  [[nodiscard]] double rate(double t) const {
    for (const Piece& p : pieces_) {
      if (t < p.start || t >= p.end) continue;
      const double s = t - p.start;
      if (p.amplitude > 0.0) {
        const double w = 2.0 * pi * p.hz;
        return p.amplitude * std::exp(-s / p.tau) * (w * std::cos(w * s) - std::sin(w * s) / p.tau);
      }
      if (p.ramp <= 0.0) return p.rate;
      return p.rate * std::min({1.0, s / p.ramp, (p.end - t) / p.ramp});
    }
    return 0.0;
  }

 private:
  static constexpr double limit = 1e-4;
  struct Piece {
    double start, end, rate, ramp, amplitude, tau, hz;
  };
  std::vector<Piece> pieces_;
  std::vector<Rest> rests_;
  double time_ = 0.0;
  double amplitude_ = 0.0;
  double tau_ = 0.1;
  double hz_ = 4.0;
};

/// An inertial unit on that rig.
struct GyroModel {
  double noise_deg_s = 0.05;
  Vector3d bias_deg_s = Vector3d(0.2, -0.3, 0.25);
  double drift_deg_s2 = 0.0;  ///< Of the bias, on every axis.
  Vector3d axis = Vector3d(0.05, -0.08, 1.0).normalized();
  double acceleration_noise_g = 0.002;
  double loss = 0.0;
  double rate_hz = 200.0;
};

constexpr std::int64_t start_of_time_ns = 1'700'000'000'000'000'000;
inline std::int64_t to_stamp(double t) { return start_of_time_ns + static_cast<std::int64_t>(std::llround(1e9 * t)); }
inline double to_seconds(std::int64_t stamp_ns) { return 1e-9 * static_cast<double>(stamp_ns - start_of_time_ns); }

inline std::vector<ImuSample> read_gyro(const RigMotion& motion, const GyroModel& gyro, Random& random) {
  std::vector<ImuSample> samples;
  for (double t = 0.0; t < motion.length_s(); t += 1.0 / gyro.rate_hz) {
    ImuSample sample;
    sample.stamp_ns = to_stamp(t);
    const double drift = to_rad(gyro.drift_deg_s2) * t;
    for (int i = 0; i < 3; ++i) {
      sample.gyro_rad_s[i] = motion.rate(t) * gyro.axis[i] + to_rad(gyro.bias_deg_s[i]) + drift +
                             to_rad(gyro.noise_deg_s) * random.normal();
      sample.acceleration_g[i] = gyro.axis[i] + gyro.acceleration_noise_g * random.normal();
    }
    if (random.uniform() >= gyro.loss) samples.push_back(sample);
  }
  return samples;
}

/// A batch whose points carry their own time: x whole seconds, y the rest.
inline PointBatch timed_batch(int sensor, double t, int shots, double interval_s) {
  PointBatch batch;
  batch.sensor = sensor;
  batch.stamp_ns = to_stamp(t);
  batch.shot_interval_ns = 1e9 * interval_s;
  batch.shots = static_cast<std::uint16_t>(shots);
  for (int i = 0; i < shots; ++i) {
    const double s = t + i * interval_s;
    batch.points.push_back({static_cast<float>(std::floor(s)), static_cast<float>(s - std::floor(s)), 0.0F, 0, 0,
                            static_cast<std::uint16_t>(i)});
  }
  return batch;
}

struct FoundStop {
  StopRecord record;
  std::map<int, std::vector<double>> times_s;  ///< Of each sensor's points.
};

class CollectingListener final : public StillListener {
 public:
  void not_still_until(std::int64_t, DropReason) override {}
  void still_until(std::int64_t, int) override {}
  void stop_ended(const StillStop& stop) override { stops.push_back(stop); }
  std::vector<StillStop> stops;
};

class CollectingSink final : public PatchSink {
 public:
  void points(int sensor, int stop, std::span<const Point> points) override {
    auto& times = open_[stop][sensor];
    for (const Point& p : points) times.push_back(static_cast<double>(p.x) + static_cast<double>(p.y));
  }
  void stop_done(const StopRecord& stop) override {
    stops.push_back({stop, open_[stop.stop.index]});
    open_.erase(stop.stop.index);
  }
  std::vector<FoundStop> stops;
  [[nodiscard]] bool has_points_without_stop() const { return !open_.empty(); }

 private:
  std::map<int, std::map<int, std::vector<double>>> open_;
};

}  // namespace rigcal
