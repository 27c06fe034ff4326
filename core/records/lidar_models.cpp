#include "core/records/lidar_models.h"

namespace rigcal {
namespace {

constexpr std::array<double, 1> one_beam{0.0};
// The published fit to recorded data.
constexpr std::array<double, 6> avia_beams{-2.99, -1.86, -0.62, 0.62, 1.86, 3.04};
// 0.32 degrees apart with the highest first, as packets of real ones show.
constexpr std::array<double, 6> tele15_beams{0.80, 0.48, 0.16, -0.16, -0.48, -0.80};

// Of the prisms, those of the AVIA and the MID-40 are published fits. Of the others no fit is published: they have
// wedges that give the field of view of the data sheet, at the speeds of the MID-40.
constexpr std::array rows{
    LidarFacts{
        .model = LidarModel::livox_avia,
        .word = "livox_avia",
        .name = "Avia",
        .field = {70.4, 77.2, true},  // Where its scan does not repeat.
        .shots_per_s = 240e3,
        .echoes = 3,
        .has_imu = true,
        .min_range_m = 1.0,
        .max_range_m = 450.0,
        .range_at_10_percent_m = 190.0,
        .angle_sigma_deg = 0.02,
        .beam_upright_deg = 0.28,
        .beam_level_deg = 0.03,
        // The published speed of the third prism is 213.1611 Hz: twice the second less the first but for 0.008 Hz. Only
        // where its phase follows that rule too do all prisms ever lean the same way, which gives the published field
        // of view; otherwise it is up to 5 degrees smaller. So the third is geared to the others: with the fitted speed
        // the field would breathe with a period of two minutes.
        .scan = {{{{30.8856, -131.5463}, {29.7735, 40.8032}, {.wedge_deg = 3.1351, .gear = {-1.0, 2.0}}}}, avia_beams},
        .livox = {.type_code = 7,
                  .code_letters = "3JED",
                  .newest_firmware = {11, 9, 0, 0},
                  .reboot = {{11, 6}},
                  .return_mode = {{11, 6}},
                  .parameters = {{11, 6}},
                  .resets_parameters = true,
                  .has_sensitivity = true,
                  .has_scan_choice = true,
                  .has_slot = true}},
    LidarFacts{.model = LidarModel::livox_mid40,  // Also each third of a Mid-100.
               .word = "livox_mid40",
               .name = "Mid-40",
               .field = {38.4, 38.4, true},
               .shots_per_s = 100e3,
               .echoes = 1,
               .min_range_m = 1.0,
               .max_range_m = 260.0,
               .range_at_10_percent_m = 90.0,
               .angle_sigma_deg = 0.03,
               .beam_upright_deg = 0.28,
               .beam_level_deg = 0.03,
               .scan = {{{{18.7481, -121.5657}, {17.9634, 77.7430}}}, one_beam},
               .livox = {.type_code = 1,
                         .code_letters = "0TFD",
                         .newest_firmware = {3, 8, 0, 0},
                         .reboot = {{3, 7}},
                         .fan = {{3, 7}},
                         .suppresses_rain = true}},
    LidarFacts{.model = LidarModel::livox_mid70,
               .word = "livox_mid70",
               .name = "Mid-70",
               .field = {70.4, 70.4, true},
               .shots_per_s = 100e3,
               .echoes = 2,
               .min_range_m = 0.05,
               .max_range_m = 260.0,
               .range_at_10_percent_m = 90.0,
               .angle_sigma_deg = 0.03,
               .beam_upright_deg = 0.28,
               .beam_level_deg = 0.03,
               .scan = {{{{32.65, -121.5657}, {31.2834, 77.7430}}}, one_beam},
               .livox = {.type_code = 6,
                         .code_letters = "3GGD",
                         .newest_firmware = {10, 3, 0, 0},
                         .reboot = {{10, 3}},
                         .return_mode = {{10, 3}},
                         .parameters = {{10, 3}},
                         .resets_parameters = true,
                         .has_slot = true}},
    LidarFacts{.model = LidarModel::livox_horizon,
               .word = "livox_horizon",
               .name = "Horizon",
               .field = {81.7, 25.1, false},
               .shots_per_s = 240e3,
               .echoes = 2,
               .has_imu = true,
               .min_range_m = 0.5,
               .max_range_m = 260.0,
               .range_at_10_percent_m = 90.0,
               .angle_sigma_deg = 0.02,
               .beam_upright_deg = 0.28,
               .beam_level_deg = 0.03,
               // Two equal wedges that turn against each other draw a line, and it lies level where their phases are
               // opposite too; a third one makes a band of it.
               .scan = {{{{28.2, -121.5657}, {.wedge_deg = 28.2, .gear = {-1.0, 0.0}}, {16.3, 77.7430}}}, avia_beams},
               .livox = {.type_code = 3,
                         .code_letters = "1HDD",
                         .newest_firmware = {6, 11, 0, 0},
                         .reboot = {{6, 4}},
                         .fan = {{6, 4}},
                         .return_mode = {{6, 4}},
                         .parameters = {{6, 11}}}},
    LidarFacts{.model = LidarModel::livox_tele15,
               .word = "livox_tele15",
               .name = "Tele-15",
               .field = {14.5, 16.2, true},
               .shots_per_s = 240e3,
               .echoes = 2,
               .has_imu = true,
               .min_range_m = 3.0,
               .max_range_m = 500.0,
               .range_at_10_percent_m = 320.0,
               .angle_sigma_deg = 0.012,
               .beam_upright_deg = 0.12,
               .beam_level_deg = 0.02,
               .scan = {{{{7.235, -121.5657}, {6.9322, 77.7430}}}, tele15_beams},
               .livox = {.type_code = 2,
                         .code_letters = "1PQD",
                         .newest_firmware = {7, 9, 0, 0},
                         .reboot = {{7, 3}},
                         .fan = {{7, 3}},
                         .return_mode = {{7, 3}},
                         .parameters = {{7, 9}},
                         .resets_parameters = true,
                         .has_sensitivity = true}},
    LidarFacts{}};

constexpr bool rows_are_in_order() {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].model != static_cast<LidarModel>(i)) return false;
  }
  return rows.back().model == LidarModel::other;
}
static_assert(rows_are_in_order());

}  // namespace

std::span<const LidarFacts> lidar_models() { return rows; }

const LidarFacts& facts_of(LidarModel model) { return rows[static_cast<std::size_t>(model)]; }

}  // namespace rigcal
