#include "drivers/camera/camera_state.h"

#include <string>

namespace rigcal::camera {
namespace {

struct Range {
  CameraState first;
  CameraState last;
};

// The states are in the order in which a camera goes through them, so each call has a range.
constexpr Range range_of(CameraCall call) {
  switch (call) {
    case CameraCall::open:
      return {CameraState::closed, CameraState::closed};
    case CameraCall::configure:
      return {CameraState::open, CameraState::configured};
    case CameraCall::start:
      return {CameraState::configured, CameraState::configured};
    case CameraCall::next:
    case CameraCall::trigger:
    case CameraCall::stop:
      return {CameraState::streaming, CameraState::streaming};
    case CameraCall::close:
      break;
  }
  return {CameraState::closed, CameraState::streaming};
}

// What brings a camera into a state.
const char* way_to(CameraState state) {
  switch (state) {
    case CameraState::closed:
      return "close";
    case CameraState::open:
      return "open";
    case CameraState::configured:
      return "configure";
    case CameraState::streaming:
      break;
  }
  return "start";
}

}  // namespace

const char* to_string(CameraState state) {
  switch (state) {
    case CameraState::closed:
      return "closed";
    case CameraState::open:
      return "open";
    case CameraState::configured:
      return "configured";
    case CameraState::streaming:
      break;
  }
  return "streaming";
}

const char* to_string(CameraCall call) {
  switch (call) {
    case CameraCall::open:
      return "open";
    case CameraCall::configure:
      return "configure";
    case CameraCall::start:
      return "start";
    case CameraCall::next:
      return "next";
    case CameraCall::trigger:
      return "trigger";
    case CameraCall::stop:
      return "stop";
    case CameraCall::close:
      break;
  }
  return "close";
}

bool is_legal(CameraCall call, CameraState state) {
  const Range range = range_of(call);
  return range.first <= state && state <= range.last;
}

Expected<void> check_call(CameraCall call, CameraState state) {
  if (is_legal(call, state)) return {};
  const Range range = range_of(call);
  const bool is_too_late = state > range.last;
  const char* first = is_too_late
                          ? (state == CameraState::streaming && range.last != CameraState::closed ? "stop" : "close")
                          : way_to(range.first);
  return system_error(std::string("'") + to_string(call) + "' was called of a camera that is " + to_string(state), {},
                      std::string("call '") + first + "' first");
}

}  // namespace rigcal::camera
