#pragma once

#include <cstddef>
#include <cstdint>

namespace rigcal {

/// What is known beforehand of the stamps of a camera.
struct StampNoise {
  double jitter_ns = 500e3;       ///< Standard deviation to begin with; the real one is learnt.
  double least_jitter_ns = 20e3;  ///< Stamps of edges are no better, whatever few frames say.
  double drift_ppm = 200.0;       ///< Standard deviation of the rate of the camera's clock to the session clock's.
  double wander_ppm = 0.05;       ///< By which the rate wanders within a second, as with temperature.
};
/// Frames that have only the stamps of their arrival, on the session clock itself.
inline constexpr StampNoise arrival_noise{5e6, 500e3, 0.0, 0.0};

/// A time with its standard deviation.
struct StampEstimate {
  std::int64_t stamp_ns = 0;
  double error_ns = 0.0;
};

/// The mapping of a camera's clock to session time, learnt from pairs (stamp of a frame, pulse that released it): an
/// offset, which contains the constant delay from pulse to stamp, and a rate that wanders, by a Kalman filter over
/// both. Single bad stamps hardly move it. Constant memory; any values are safe.
class ReleaseLine {
 public:
  ReleaseLine(const StampNoise& noise, std::int64_t device_ns, std::int64_t pulse_ns);

  /// When the pulse must have come that released the frame of that stamp; the error contains the jitter of the stamp.
  [[nodiscard]] StampEstimate at(std::int64_t device_ns) const;
  void add(std::int64_t device_ns, std::int64_t pulse_ns);
  /// The same rate and jitter through another pair: to go through frames a second time.
  [[nodiscard]] ReleaseLine through(std::int64_t device_ns, std::int64_t pulse_ns) const;

  /// Positive: the camera's clock runs fast.
  [[nodiscard]] double drift_ppm() const;
  [[nodiscard]] double jitter_ns() const;
  [[nodiscard]] std::size_t pairs() const { return pairs_; }

 private:
  /// Offset (pulse minus device stamp, from the first pair) and rate with their covariance, at a device time.
  struct State {
    double time = 0.0;
    double offset = 0.0;
    double rate = 0.0;
    double offset_variance = 0.0;
    double covariance = 0.0;
    double rate_variance = 0.0;
  };
  [[nodiscard]] State predicted(double time) const;

  StampNoise noise_;
  std::int64_t first_device_ns_ = 0;
  std::int64_t first_pulse_ns_ = 0;
  State state_;
  double jitter_variance_ = 0.0;
  std::size_t pairs_ = 1;
};

}  // namespace rigcal
