#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace rigcal {

/// The order is that of the rows of `lidar_models`.
enum class LidarModel { livox_avia, livox_mid40, livox_mid70, livox_horizon, livox_tele15, other };

/// Full angles about the forward axis.
struct LidarField {
  double across_deg = 0.0;  ///< 0: not known.
  double upright_deg = 0.0;
  bool is_round = false;
};

/// One rotating wedge that a beam goes through.
struct ScanPrism {
  double wedge_deg = 0.0;        ///< 0: the model has no further prism.
  double turns_per_s = 0.0;      ///< Signed; of one that turns by itself, from a phase by chance.
  std::array<double, 2> gear{};  ///< Else its turns are those of the first two prisms by these.
  [[nodiscard]] constexpr bool is_geared() const { return gear[0] != 0.0 || gear[1] != 0.0; }
};

struct ScanPattern {
  std::array<ScanPrism, 3> prisms{};
  /// Elevations before the prisms, in the order in which they shoot. Empty: not known.
  std::span<const double> beams_deg;
};

/// The first two numbers of a firmware from which on a model can do something.
struct FirmwareSince {
  std::uint8_t major = 0;
  std::uint8_t minor = 0;
};

/// What a model says and can do in Livox's protocol, by the vendor's tables; nothing: it can not.
struct LivoxFacts {
  std::uint8_t type_code = 0;     ///< Its number in broadcasts; 0 is a Hub, which is no LiDAR.
  const char* code_letters = "";  ///< What its broadcast codes begin with.
  std::array<std::uint8_t, 4> newest_firmware{};
  std::optional<FirmwareSince> reboot{};
  std::optional<FirmwareSince> fan{};
  std::optional<FirmwareSince> return_mode{};
  std::optional<FirmwareSince> parameters{};
  bool resets_parameters = false;
  bool has_sensitivity = false;  ///< Parameters that it has: high sensitivity,
  bool has_scan_choice = false;  ///< the scan pattern,
  bool has_slot = false;         ///< and the slot number.
  bool suppresses_rain = false;
};

/// All that is known of a LiDAR model, by data sheets where nothing else is said. As it is made here, it is one of
/// which nothing is known.
struct LidarFacts {
  LidarModel model = LidarModel::other;
  const char* word = "lidar";  ///< The type in a rig file.
  const char* name = "";       ///< As its maker writes it.
  LidarField field{};
  double shots_per_s = 240e3;  ///< Most are as fast.
  int echoes = 1;              ///< Most that it tells of a shot. One with 1 has no return modes and no tags.
  bool has_imu = false;
  double min_range_m = 0.0;
  double max_range_m = 0.0;
  double range_at_10_percent_m = 0.0;  ///< Where half of the shots at a 10 % target return.
  double angle_sigma_deg = 0.0;        ///< Of a direction, a part of the precision that the data sheet promises.
  double beam_upright_deg = 0.0;       ///< Full width of the beam; 0: not known.
  double beam_level_deg = 0.0;
  ScanPattern scan{};
  LivoxFacts livox{};

  [[nodiscard]] constexpr bool is_livox() const { return livox.type_code != 0; }
};

/// One row a model, the last of them `other`.
[[nodiscard]] std::span<const LidarFacts> lidar_models();
/// The row of a model.
[[nodiscard]] const LidarFacts& facts_of(LidarModel model);

}  // namespace rigcal
