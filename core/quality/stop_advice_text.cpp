#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/quality/stop_advice.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

// Less than this is not worth the operator's while.
constexpr double least_gain = 0.05;

std::string bounds_text(const PredictedBounds& bounds) {
  return mm(bounds.translation_m) + " and " + deg(bounds.rotation_rad);
}

std::string place_text(const Vector3d& place) {
  const double azimuth = to_deg(std::atan2(place.y(), place.x()));
  const double elevation = to_deg(std::atan2(place.z(), std::hypot(place.x(), place.y())));
  std::string text = number(place.norm(), 0) + " m away ";
  if (std::abs(azimuth) < 15.0) {
    text += "in front of the base";
  } else if (std::abs(azimuth) > 165.0) {
    text += "behind the base";
  } else {
    text += number(std::abs(azimuth), 0) + " degrees to the " + (azimuth > 0.0 ? "left" : "right") + " of the base's x";
  }
  if (elevation > 15.0) text += ", high up";
  if (elevation < -15.0) text += ", low down";
  return text;
}

std::string facing_text(const SurfaceCandidate& surface) {
  const Vector3d level(surface.place.x(), surface.place.y(), 0.0);
  const double facing = -surface.normal.dot(surface.place.normalized());
  if (facing > 0.95) return "facing the rig";
  const double up = surface.normal.z() + surface.place.normalized().z() * facing;
  if (std::abs(up) > 0.4) return up > 0.0 ? "leaning back so that it faces up" : "leaning over so that it faces down";
  const double left = Vector3d::UnitZ().cross(level).normalized().dot(surface.normal);
  return std::string("turned to the ") + (left > 0.0 ? "left" : "right") + " by 45 degrees, seen from the rig";
}

}  // namespace

std::string advice_text(const StopAdvice& advice, const std::vector<std::string>& names) {
  const TurnCandidate& turn = advice.turns[advice.best_turn];
  std::string text = names[static_cast<std::size_t>(advice.now.lidar)] + " is the least sure (" +
                     bounds_text(advice.now) + ", 95 %): ";
  if (turn.after.of_goal < (1.0 - least_gain) * advice.now.of_goal) {
    const double deg_turn = to_deg(turn.angle_rad);
    text += "turn the table by " + number(deg_turn > 180.0 ? deg_turn - 360.0 : deg_turn, 0) +
            " degrees for the next stop, which would leave the worst at " + bounds_text(turn.after);
  } else {
    text += "no turn alone helps it much";
  }
  if (advice.surface && advice.surface->after.of_goal < (1.0 - least_gain) * advice.now.of_goal) {
    text += "; a flat surface of a square metre " + place_text(advice.surface->place) + ", " +
            facing_text(*advice.surface) + ", would leave it at " + bounds_text(advice.surface->after);
  }
  return text;
}

}  // namespace rigcal
