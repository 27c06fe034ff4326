#pragma once

#include <array>
#include <cstdint>

#include "core/base/error.h"

/// Cameras behind one interface, whatever they hang on.
namespace rigcal::camera {

/// What is done with a camera: nothing, it is ours, it is set up, frames come. A camera that got lost while it streams
/// is still streaming: it is looked for until it is stopped.
enum class CameraState : std::uint8_t { closed, open, configured, streaming };

enum class CameraCall : std::uint8_t { open, configure, start, next, trigger, stop, close };

constexpr std::array<CameraState, 4> kAllStates{CameraState::closed, CameraState::open, CameraState::configured,
                                                CameraState::streaming};
constexpr std::array<CameraCall, 7> kAllCalls{CameraCall::open, CameraCall::configure, CameraCall::start,
                                              CameraCall::next, CameraCall::trigger,   CameraCall::stop,
                                              CameraCall::close};

/// In words, for messages.
[[nodiscard]] const char* to_string(CameraState state);
[[nodiscard]] const char* to_string(CameraCall call);

/// Which call may be made in which state:
///
///              closed  open  configured  streaming
///   open         x
///   configure            x       x
///   start                        x
///   next                                     x
///   trigger                                  x
///   stop                                     x
///   close        x       x       x           x
[[nodiscard]] bool is_legal(CameraCall call, CameraState state);

/// Nothing, or an Error (kind system) that says what the call needs.
[[nodiscard]] Expected<void> check_call(CameraCall call, CameraState state);

}  // namespace rigcal::camera
