#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/live_options.h"
#include "apps/commands/motion_options.h"
#include "apps/commands/option_checks.h"
#include "apps/common/json_text.h"
#include "apps/common/tolerance.h"
#include "apps/recording/rig_lidars.h"
#include "core/base/version.h"
#include "core/rig/rig.h"
#include "simdata/live/live_run.h"
#include "simdata/packets/sim_device.h"
#include "simdata/scene/scene_file.h"
#include "simdata/session/session_writer.h"

namespace rigcal {
namespace {

constexpr double most_mount_error_m = 10.0;
constexpr double most_mount_error_rad = pi + 1e-9;

struct SimulateOptions {
  std::string scene;
  std::string rig;
  std::string out;
  bool patches = false;
  std::uint64_t seed = 1;
  sim::TurntableOptions motion;
  int points = 200000;
  int images_per_stop = 1;
  std::string mount_error = "200mm,10deg";
  sim::UnitErrorOptions unit_errors;
  sim::FaultOptions faults;
  sim::PacketPath path;
  double clock_drift_ppm = sim::usual_clock_drift_ppm;
  bool is_live = false;
  sim::LiveOptions live;
};

sim::RunOptions run_options(const SimulateOptions& options, const sim::MountError& mount_error) {
  sim::RunOptions run;
  run.seed = options.seed;
  run.turntable = options.motion;
  run.mount_error = mount_error;
  run.unit_errors = options.unit_errors;
  run.faults = options.faults;
  run.path = options.path;
  run.clock_drift_ppm = options.clock_drift_ppm;
  run.images_per_stop = options.images_per_stop;
  return run;
}

Expected<sim::MountError> mount_error_of(const SimulateOptions& options) {
  const Expected<Tolerance> off = parse_distance(options.mount_error);
  if (!off) return off.error();
  return sim::MountError{off->translation_m, to_deg(off->rotation_rad)};
}

Expected<sim::SessionSummary> simulate(const SimulateOptions& options, const Rig& rig, const sim::Scene& scene,
                                       CommandContext& context) {
  const Expected<sim::MountError> mount_error = mount_error_of(options);
  if (!mount_error) return mount_error.error();
  if (options.patches) {
    sim::LightRigOptions light;
    light.seed = options.seed;
    light.turntable = options.motion;
    light.mount_error = *mount_error;
    light.unit_errors = options.unit_errors;
    light.shots_per_patch = options.points;
    light.with_images = options.images_per_stop > 0;
    return sim::simulate_patches(scene, rig, light, options.out, context.run_context());
  }
  return sim::simulate_session(scene, rig, run_options(options, *mount_error), options.out, context.run_context());
}

std::string summary_text(const SimulateOptions& options, const sim::SessionSummary& summary) {
  char text[256];
  if (options.patches) {
    std::snprintf(text, sizeof text, ": %d stops, %.1f million points, %llu images\n", summary.stops,
                  static_cast<double>(summary.points) * 1e-6, static_cast<unsigned long long>(summary.images));
  } else {
    std::snprintf(text, sizeof text, ": %d stops in %.1f s, %llu datagrams, %.0f MB, %llu images\n", summary.stops,
                  summary.seconds, static_cast<unsigned long long>(summary.datagrams),
                  static_cast<double>(summary.bytes) * 1e-6, static_cast<unsigned long long>(summary.images));
  }
  return options.out + text;
}

std::string summary_json(const SimulateOptions& options, const sim::SessionSummary& summary) {
  nlohmann::ordered_json json{{"rigcal", format_version}, {"command", "simulate"}, {"session", options.out},
                              {"scene", options.scene},   {"seed", options.seed},  {"stops", summary.stops}};
  json["images"] = summary.images;
  if (options.patches) {
    json["points"] = summary.points;
  } else {
    json["seconds"] = summary.seconds;
    json["datagrams"] = summary.datagrams;
    json["bytes"] = summary.bytes;
  }
  return json_text(json);
}

// Its end is a good one whether the run was over or the user stopped it.
Expected<ExitCode> run_live(const SimulateOptions& options, const Rig& rig, const sim::Scene& scene,
                            CommandContext& context) {
  const Expected<sim::MountError> mount_error = mount_error_of(options);
  if (!mount_error) return mount_error.error();
  sim::LiveOptions live = options.live;
  live.run = run_options(options, *mount_error);
  if (!live.table.empty()) live.run.turntable.step_sigma_deg = 0.0;  // No hand turns it.
  const Expected<sim::LiveSummary> summary = sim::serve_live(scene, rig, live, context.run_context());
  if (!summary) return summary.error();
  if (context.json) {
    CommandContext::print(live_summary_json(options.scene, options.seed, *summary));
  } else if (!context.quiet) {
    CommandContext::print(live_summary_text(*summary));
  }
  return ExitCode::good;
}

// Told with the rig file's name, which the simulation does not know.
Expected<void> check_devices(const SimulateOptions& options, const Rig& rig) {
  if (options.patches) return {};
  if (lidar_sensors(rig).empty()) {
    return input_error("has no LiDAR, and nothing else sends packets", options.rig,
                       "add one, or --patches, which writes images by their stops");
  }
  const auto devices = sim::make_devices(rig, options.seed);
  if (devices) return {};
  return Error{devices.error().kind, devices.error().what, options.rig + ": " + devices.error().where,
               devices.error().mend};
}

Expected<ExitCode> run_simulate(const SimulateOptions& options, CommandContext& context) {
  const Expected<sim::Scene> scene = sim::load_scene(options.scene);
  if (!scene) return scene.error();
  const Expected<Rig> rig = load_rig(options.rig);
  if (!rig) return rig.error();
  if (const Expected<void> fit = check_devices(options, *rig); !fit) return fit.error();
  if (options.is_live) return run_live(options, *rig, *scene, context);
  const Expected<sim::SessionSummary> summary = simulate(options, *rig, *scene, context);
  if (!summary) return summary.error();
  if (context.json) {
    CommandContext::print(summary_json(options, *summary));
  } else if (!context.quiet) {
    CommandContext::print(summary_text(options, *summary));
  }
  return ExitCode::good;
}

std::string check_mount_error(const std::string& text) {
  const Expected<Tolerance> off = parse_distance(text);
  if (!off) return off.error().message();
  if (off->translation_m <= most_mount_error_m && off->rotation_rad <= most_mount_error_rad) return {};
  return text + " is more than 10 m or 180 degrees";
}

void add_unit_error_options(CLI::App& command, sim::UnitErrorOptions& errors) {
  command
      .add_option_function<double>(
          "--range-bias", [&errors](double mm) { errors.range_bias_sigma_m = 1e-3 * mm; },
          "Millimetres, 1 sigma between units, by which all ranges of a unit are off (default 0)")
      ->check(number_range(0.0, 1000.0))
      ->option_text("MM");
  command
      .add_option_function<double>(
          "--dark-bias", [&errors](double mm) { errors.dark_bias_m = 1e-3 * mm; },
          "Millimetres by which a black target seems further than a white one (default 0)")
      ->check(number_range(-1000.0, 1000.0))
      ->option_text("MM");
  command
      .add_option_function<double>(
          "--wobble", [&errors](double deg) { errors.wobble_rad = to_rad(deg); },
          "Degrees by which the beam goes round where the sensor thinks it is (default 0)")
      ->check(number_range(0.0, 5.0))
      ->option_text("DEG");
  command
      .add_option("--footprint", errors.footprint_share,
                  "Share of shots whose footprint is sampled twice (default 0.2; 1 is a real sensor, and slower)")
      ->check(number_range(0.0, 1.0))
      ->option_text("SHARE");
}

void add_fault_options(CLI::App& command, CLI::Option& patches, sim::FaultOptions& faults) {
  const auto add = [&](const char* name, double& share, const char* text) {
    command.add_option(name, share, text)->check(number_range(0.0, 0.2))->excludes(&patches)->option_text("SHARE");
  };
  add("--loss", faults.loss, "Share of packets that get lost (default 0)");
  add("--duplicate", faults.duplicate, "Share of packets that come twice (default 0)");
  add("--reorder", faults.reorder, "Share of packets that others overtake (default 0)");
  add("--delay", faults.delay, "Share of packets that come up to 20 ms late (default 0)");
  add("--bit-flips", faults.flip, "Share of packets with a wrong bit (default 0)");
}

void add_timing_options(CLI::App& command, CLI::Option& patches, SimulateOptions& options) {
  command
      .add_option_function<double>(
          "--jitter", [&options](double ms) { options.path.jitter_s = 1e-3 * ms; },
          "Milliseconds that packets are late on average, each by another amount (default 0.05)")
      ->check(number_range(0.0, 100.0))
      ->excludes(&patches)
      ->option_text("MS");
  command
      .add_option("--clock-drift", options.clock_drift_ppm,
                  "Millionths by which the devices' clocks may run fast or slow (default 50)")
      ->check(number_range(0.0, 1000.0))
      ->excludes(&patches)
      ->option_text("PPM");
}

}  // namespace

void add_simulate_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand("simulate", "Simulate a turntable run of a rig, with ground truth");
  command
      ->add_option("SCENE", options->scene,
                   "courtyard, room, sparse, glass_room, wet_yard, or the path of a scene file")
      ->required();
  command->add_option("--rig", options->rig, "Rig file; its extrinsics are where the sensors nearly are")
      ->required()
      ->option_text("RIG");
  CLI::Option* out = command->add_option("--out", options->out, "Session to make; must not exist")
                         ->check(named_path())
                         ->option_text("SESSION");
  CLI::Option* patches = command->add_flag("--patches", options->patches, "Write patches instead of packets");
  command->add_option("--seed", options->seed, "The same seed gives the same run (default 1)")
      ->check(seed_range())
      ->option_text("N");
  add_motion_options(*command, options->motion);
  command
      ->add_option("--points", options->points,
                   "Shots of each patch (default 200000), at most what the sensor fires in a stop")
      ->check(CLI::Range(1, 100'000'000))
      ->needs(patches)
      ->option_text("N");
  command
      ->add_option("--images-per-stop", options->images_per_stop,
                   "Images of each camera with intrinsics in each stop (default 1; with --patches at most 1)")
      ->check(CLI::Range(0, 1000))
      ->option_text("N");
  command
      ->add_option("--mount-error", options->mount_error,
                   "How far the rig file's extrinsics are off (default 200mm,10deg; 0mm,0deg: not at all)")
      ->check(CLI::Validator(check_mount_error, ""))
      ->option_text("MM,DEG");
  add_unit_error_options(*command, options->unit_errors);
  add_fault_options(*command, *patches, options->faults);
  add_timing_options(*command, *patches, *options);
  CLI::Option* live = command->add_flag(
      "--live", options->is_live, "Serve LiDARs and cameras as devices on the network instead of writing a session");
  live->excludes(out)->excludes(patches);
  add_live_options(*command, *live, options->live);
  command->footer("Example:\n  rigcal simulate courtyard --rig config/rigs/turntable.yaml --out session");
  command->callback([options, command, &context] {
    if (options->out.empty() && !options->is_live) throw CLI::RequiredError("--out SESSION or --live");
    if (options->patches && options->images_per_stop > 1)
      throw CLI::ValidationError("--images-per-stop",
                                 "a patch folder has one image of a camera and a stop: give 0 or 1");
    check_motion(*command, options->motion, !options->patches);
    context.run = [options, &context] { return run_simulate(*options, context); };
  });
}

}  // namespace rigcal
