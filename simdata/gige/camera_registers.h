#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/gige_codec/bootstrap.h"
#include "drivers/gige_codec/status.h"
#include "simdata/gige/camera_description.h"
#include "simdata/gige/exposure_schedule.h"
#include "simdata/gige/features.h"
#include "simdata/gige/register_memory.h"

namespace rigcal::sim {

struct VirtualCameraOptions {
  gige::DeviceIdentity identity;  ///< Names, addresses.
  Transport transport = Transport::gige;
  int width = 1280;  ///< Of the sensor.
  int height = 1024;
  std::vector<std::string> pixel_formats{
      "Mono8"};                 ///< Names that gige::pixel_code knows; the first is set at the start.
  double exposure_us = 5000.0;  ///< As it is set at the start, like the gain.
  double gain_db = 0.0;
  double least_trigger_delay_us = 0.0;  ///< Some take none below their own, which is then set at the start.
  double link_bits_per_s = 1e9;         ///< How fast packets leave, which also bounds the frame rate.
  std::int64_t clock_start_ns = 0;      ///< What its clock reads when it is switched on, of its own time.
  double clock_drift = 0.0;             ///< Seconds that its clock gains in a second.
  double boot_s = 2.0;                  ///< After a reset it is dark for so long.
  bool can_resend = true;
  double answer_delay_s = 0.0;    ///< Its answers come so much later; it says that they are pending.
  std::uint16_t first_block = 1;  ///< Block ids begin with this one.
};

/// What an output line does while the camera exposes.
struct Strobe {
  bool is_on = false;
  std::int64_t delay_ns = 0;     ///< From the exposure's start.
  std::int64_t duration_ns = 0;  ///< 0: as long as the exposure.
};

/// The registers as typed values.
struct CameraSettings {
  int width = 0;
  int height = 0;
  int offset_x = 0;
  int offset_y = 0;
  std::uint32_t pixel_format = 0;
  double exposure_us = 0.0;
  double gain_db = 0.0;
  ExposureAuto exposure_auto = ExposureAuto::off;
  std::uint64_t frames = 0;  ///< After so many the acquisition ends; 0: it goes on.
  ExposureRules rules;
  bool has_chunks = false;
  std::array<bool, kChunks> chunks{};
  std::array<Strobe, kLines> strobes{};
  std::size_t image_bytes = 0;
  std::size_t payload_bytes = 0;  ///< With the chunks.
};

/// What the camera remembers: bootstrap registers, features, user sets, the description. No time, no network.
class CameraRegisters {
 public:
  static constexpr std::uint32_t kTicksPerSecond = 100'000'000;

  explicit CameraRegisters(const VirtualCameraOptions& options);

  /// As after switching on: the user set that is to be loaded then, all channels closed.
  void reset();

  [[nodiscard]] RegisterMemory& memory() { return memory_; }
  [[nodiscard]] const RegisterMemory& memory() const { return memory_; }
  [[nodiscard]] std::uint32_t value(Feature feature, std::uint32_t index = 0) const {
    return memory_.value(address_of(feature, index));
  }
  [[nodiscard]] double real(Feature feature) const { return static_cast<double>(memory_.real(address_of(feature))); }
  void set(Feature feature, std::uint32_t value) { memory_.set(address_of(feature), value); }
  void set_real(Feature feature, double value) { memory_.set_real(address_of(feature), value); }

  /// Which feature lies there, if any, and which of its registers.
  struct Place {
    Feature feature{};
    std::uint32_t index = 0;
  };
  [[nodiscard]] static std::optional<Place> feature_at(std::uint32_t address);

  /// Checks a value for a feature and keeps it. Errors: invalid_parameter out of range, write_protected while
  /// acquiring.
  [[nodiscard]] gige::Status write(const Place& place, std::uint32_t value, bool is_acquiring);

  [[nodiscard]] CameraSettings settings() const;
  /// Brings the registers up to date that follow from others.
  void update_computed(double on_s);

  /// Errors: invalid_parameter for a set that cannot be written.
  [[nodiscard]] gige::Status save_user_set();
  void load_user_set(std::uint32_t set);

 private:
  using Set = std::vector<std::uint32_t>;  ///< The setting registers, in the order of their addresses.
  void define_bootstrap();
  void define_features();
  [[nodiscard]] Set copy_settings() const;
  [[nodiscard]] bool is_allowed(const Place& place, std::uint32_t value) const;
  [[nodiscard]] std::int64_t link_time_ns(std::size_t payload_bytes) const;

  VirtualCameraOptions options_;
  std::string description_;
  RegisterMemory memory_;
  std::array<Set, 2> sets_;  ///< The factory's, and the user's.
};

}  // namespace rigcal::sim
