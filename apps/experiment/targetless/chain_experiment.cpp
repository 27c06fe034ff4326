#include "apps/experiment/targetless/chain_experiment.h"

#include <algorithm>
#include <array>

#include "apps/experiment/targetless/motion_based.h"
#include "apps/experiment/targetless/trials.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t chain_stream = 940;
constexpr std::uint64_t motion_stream = 941;
constexpr double guess_deg = 10.0;
constexpr double guess_m = 0.2;
constexpr int icp_iterations = 30;
// Half the length of the figure of eight, in rooms and outdoors; its stops for each of the turntable's.
constexpr double drive_room_m = 1.2;
constexpr double drive_m = 3.0;
constexpr double drive_stops = 1.8;
// A drive is not level to a hair: without that, hand-eye would know nothing of heights.
constexpr double wander_m = 0.05;
constexpr double wander_deg = 1.0;
constexpr const char* middle_name = "mid100_middle";

struct Setting {
  const char* rig;
  const char* scene;
};

constexpr std::array<Setting, 6> settings{{{"MID-100", "courtyard"},
                                           {"MID-100", "room"},
                                           {"MID-100", "sparse"},
                                           {"MID-100", "wet_yard"},
                                           {"AVIA", "courtyard"},
                                           {"AVIA", "room"}}};

Rig rig_of(const std::string& name) {
  Rig rig = sim::nominal_rig();
  if (name == "AVIA") return rig;
  std::erase_if(rig.sensors, [](const Sensor& sensor) { return !sensor.name.starts_with("mid100"); });
  const auto middle = std::find_if(rig.sensors.begin(), rig.sensors.end(),
                                   [](const Sensor& sensor) { return sensor.name == middle_name; });
  rig.base = static_cast<int>(middle - rig.sensors.begin());
  const SE3 T_middle_body = middle->initial_T_base_sensor->inverse();
  for (Sensor& sensor : rig.sensors) sensor.initial_T_base_sensor = T_middle_body * *sensor.initial_T_base_sensor;
  return rig;
}

// Errors of one method over the trials of one setting.
class Chain {
 public:
  Chain(const Setting& setting, const std::string& method) {
    row_.rig = setting.rig;
    row_.scene = setting.scene;
    row_.method = method;
  }

  void add(const sim::LightRig& light, const std::vector<std::optional<SE3>>& found) {
    const auto& sensors = light.rig.sensors;
    const auto middle = static_cast<std::size_t>(
        std::find_if(sensors.begin(), sensors.end(), [](const Sensor& s) { return s.name == middle_name; }) -
        sensors.begin());
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (i == middle || !sensors[i].name.starts_with("mid100")) continue;
      ++row_.pairs;
      if (!found[i] || !found[middle]) continue;
      ++row_.found;
      const SE3 T = found[middle]->inverse() * *found[i];
      const SE3 truth = light.T_base_sensor[middle].inverse() * light.T_base_sensor[i];
      rotations_.push_back(rotation_distance(T.R, truth.R));
      translations_.push_back((T.t - truth.t).norm());
    }
  }

  [[nodiscard]] ChainRow row() const {
    ChainRow out = row_;
    out.rotation_rad = mean_spread(rotations_);
    out.translation_m = mean_spread(translations_);
    return out;
  }

 private:
  ChainRow row_;
  std::vector<double> rotations_;
  std::vector<double> translations_;
};

// The rough motion of each LiDAR itself, as its odometry would have it.
std::vector<std::vector<SE3>> rough_motions(const sim::LightRig& light, const SetOptions& set, std::uint64_t seed) {
  Random random(seed, motion_stream);
  std::vector<std::vector<SE3>> out;
  for (const SE3& E : light.T_base_sensor) {
    std::vector<SE3> poses;
    for (const SE3& G : light.T_G_base) {
      const SE3 T = (light.T_G_base.front() * E).inverse() * (G * E);
      const SE3 rough = rough_pose(T, set, random);
      poses.push_back(poses.empty() ? T : rough);
    }
    out.push_back(std::move(poses));
  }
  return out;
}

Expected<void> try_setting(const Setting& setting, const LidarExperimentOptions& options, const RunContext& context,
                           std::vector<ChainRow>& rows) {
  const Expected<sim::Scene> scene = sim::load_scene(setting.scene);
  if (!scene) return scene.error();
  Chain ours(setting, "rigcal");
  Chain by_icp(setting, "ICP");
  Chain by_motion(setting, "motion");
  for (int k = 0; k < options.trials; ++k) {
    SetOptions turned;
    turned.scene = setting.scene;
    turned.rig = rig_of(setting.rig);
    turned.seed = options.seed + static_cast<std::uint64_t>(k);
    turned.points = options.points;
    turned.stops = options.stops;
    Expected<Ground> ground = make_ground(turned, *scene);
    if (!ground) return ground.error();
    Random random(turned.seed, chain_stream);
    const std::vector<SE3> guess = spoiled(ground->set, guess_deg, guess_m, random);
    const Expected<Trial> trial = try_ours(ground->set, guess, context);
    if (!trial) return trial.error();
    ours.add(ground->set.light, trial->T_base_sensor);
    by_icp.add(ground->set.light, try_icp(*ground, guess, icp_iterations, true, context).T_base_sensor);

    SetOptions driven = turned;
    driven.drive_m = turned.scene == "room" ? drive_room_m : drive_m;
    driven.wander_m = wander_m;
    driven.wander_deg = wander_deg;
    driven.stops = static_cast<int>(drive_stops * options.stops);
    Expected<Ground> drive = make_ground(driven, *scene);
    if (!drive) return drive.error();
    const sim::LightRig& light = drive->set.light;
    by_motion.add(light,
                  place_by_motion(drive->icp, light.rig.base, rough_motions(light, driven, driven.seed), context));
    if (context.cancelled()) return cancelled_error();
  }
  for (const Chain* chain : {&ours, &by_icp, &by_motion}) rows.push_back(chain->row());
  return {};
}

}  // namespace

Expected<std::vector<ChainRow>> try_chain(const LidarExperimentOptions& options, const RunContext& context) {
  std::vector<ChainRow> rows;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    if (context.cancelled()) return cancelled_error();
    const auto& scenes = options.scenes;
    if (!scenes.empty() && std::find(scenes.begin(), scenes.end(), settings[k].scene) == scenes.end()) continue;
    context.reporter.progress("chain", static_cast<double>(k) / static_cast<double>(settings.size()));
    if (const auto done = try_setting(settings[k], options, context, rows); !done) return done.error();
  }
  context.reporter.progress("chain", 1.0);
  return rows;
}

}  // namespace rigcal::targetless
