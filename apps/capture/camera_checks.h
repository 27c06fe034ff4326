#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "apps/cameras/rig_cameras.h"
#include "apps/capture/doctor.h"

namespace rigcal {

/// What was found of a camera of the rig.
struct CameraFinding {
  std::string sensor;
  std::optional<Error> trouble;  ///< Why it could not be taken or set up; the rest is empty then.
  camera::CameraIdentity identity;
  camera::CameraSetup setup;
  camera::CameraCounters counters;
  std::string trigger;  ///< The line whose pulses it waits for; empty: it was asked for frames.
  std::vector<std::string> notes;
};

/// Takes each camera of the rig for as long as some frames need, at most `seconds`.
[[nodiscard]] std::vector<CameraFinding> survey_cameras(const std::vector<RigCamera>& cameras, CameraDrivers& drivers,
                                                        double seconds, const std::stop_token& stop);

/// What is to be said of them, and of the others that are there. Pure, as the rest of the doctor's judgement.
[[nodiscard]] std::vector<Check> check_cameras(const std::vector<CameraFinding>& findings,
                                               const std::vector<camera::CameraIdentity>& there,
                                               const std::vector<net::Interface>& interfaces);

}  // namespace rigcal
