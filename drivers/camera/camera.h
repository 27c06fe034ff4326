#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "drivers/camera/camera_config.h"
#include "drivers/camera/camera_state.h"
#include "drivers/camera/frame.h"

namespace rigcal::camera {

/// What became of a camera's frames since it was made; every frame that is known of is in exactly one of the first
/// three.
struct CameraCounters {
  std::array<std::uint64_t, kFrameStatuses> frames{};  ///< Handed out, by their status.
  std::uint64_t missing = 0;         ///< Never came, by the ids of those that did. Includes `no_buffer` where the
                                     ///< camera goes on counting.
  std::uint64_t discarded = 0;       ///< Whole, but nobody asked for them before the camera was stopped.
  std::uint64_t no_buffer = 0;       ///< Came while all buffers were waiting or lent.
  std::uint64_t resent_packets = 0;  ///< GigE: asked for again, and came.
  std::uint64_t losses = 0;          ///< How often the camera got lost.
  std::uint64_t returns = 0;         ///< How often it came back.

  [[nodiscard]] std::uint64_t whole() const { return frames[0]; }
  [[nodiscard]] std::uint64_t damaged() const;
};

/// What `Camera::next` brings.
struct Delivery {
  enum class Kind : std::uint8_t {
    frame,    ///< Whole or not: see its status.
    nothing,  ///< In the time given.
    lost,     ///< The camera is gone, `text` says how it was noticed; `next` looks for it from now on.
    refused,  ///< It is there again, but cannot be had: `text` says why, each reason once until it is back.
    back,     ///< It is there again, set up as before, and sends.
    ended,    ///< A folder has no more images.
  };
  Kind kind = Kind::nothing;
  Frame frame;
  std::string text;
};

/// A camera. The calls are made from one thread at a time, in the states in which they are legal (camera_state.h):
/// others are errors and change nothing. Frames may be given back from any thread. Nothing is allocated for a frame.
///
/// For those who write a back end: the public calls check the state, those with `do_` do the work. A camera that got
/// lost is looked for by `next`, with `do_start` after `do_let_go`; until it is back, `do_next` and `do_trigger` are
/// not called.
class Camera {
 public:
  virtual ~Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// Takes the camera with this id, serial number or address. Errors (kind system): absent (the message says which are
  /// there), held by another program, no permission.
  Expected<void> open(const std::string& name);
  /// Sets the camera up; may be called again. Errors: what the camera cannot do (the message says what it can). After
  /// an error it is open, with an unknown part of the settings made.
  [[nodiscard]] Expected<CameraSetup> configure(const CameraConfig& config);
  /// Frames come from now on; counters of frames go on.
  Expected<void> start();
  /// The next frame or event, waited for at most that long. While a camera is lost, a look for it may take longer.
  /// Errors: trouble that does not pass, for example a folder that cannot be read any more.
  [[nodiscard]] Expected<Delivery> next(std::int64_t timeout_ns);
  /// One exposure, where the trigger's source is "Software".
  Expected<void> trigger();
  /// No frames come any more; what waits is discarded, what is lent stays whole. Back to `configured`, also with an
  /// error (the camera is gone).
  Expected<void> stop();
  /// Gives the camera free, with the settings that it had when it was opened; where it takes none while a frame is
  /// lent, once the last is given back. Never fails: what cannot be restored is in `notes`.
  void close();

  [[nodiscard]] CameraState state() const { return state_; }
  /// Who it is; of the last one while it is closed.
  [[nodiscard]] const CameraIdentity& identity() const { return identity_; }
  [[nodiscard]] virtual CameraCounters counters() const { return counters_; }
  /// What was mended or could not be, since it was made; sentences.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 protected:
  /// `search_pause_ns`: from one try to have a lost camera again to the next.
  explicit Camera(std::int64_t search_pause_ns = 100'000'000) : search_pause_ns_(search_pause_ns) {}
  /// For `do_next`: it was noticed that the camera is gone.
  [[nodiscard]] Delivery lose(const std::string& how);
  void note(std::string text) { notes_.push_back(std::move(text)); }

  virtual Expected<CameraIdentity> do_open(const std::string& name) = 0;
  virtual Expected<CameraSetup> do_configure(const CameraConfig& config) = 0;
  virtual Expected<void> do_start() = 0;
  virtual Expected<Delivery> do_next(std::int64_t timeout_ns) = 0;
  virtual Expected<void> do_trigger() = 0;
  virtual Expected<void> do_stop() = 0;
  /// What is left of a lost camera is given up, so that it can be had anew. More than once for one loss.
  virtual void do_let_go() {}
  /// Of a camera that does not stream. To be called by the destructor of the back end by way of `close`.
  virtual void do_close() = 0;

  CameraCounters counters_;  ///< Losses and returns are counted already.

 private:
  [[nodiscard]] Delivery search(std::int64_t timeout_ns);
  [[nodiscard]] Delivery back();
  /// What `next` brings where a lost camera was looked for and not had; nothing where it just is not there, or where
  /// that was said since it was lost.
  [[nodiscard]] std::optional<Delivery> refused(const Error& why);

  CameraState state_ = CameraState::closed;
  CameraIdentity identity_;
  CameraConfig config_;
  std::vector<std::string> notes_;
  std::int64_t search_pause_ns_;
  std::int64_t search_ns_ = 0;         ///< When the next try is due.
  bool is_gone_ = false;               ///< It was said that it is lost.
  std::vector<std::string> refusals_;  ///< Told since then.
};

/// A way to reach cameras.
class CameraBackend {
 public:
  virtual ~CameraBackend() = default;
  /// As the rig file says it: "aravis", "v4l2", "images".
  [[nodiscard]] virtual std::string_view name() const = 0;
  /// The cameras that are there, whoever holds them. May take about a second.
  [[nodiscard]] virtual Expected<std::vector<CameraIdentity>> enumerate() = 0;
  /// A closed camera; may outlive this.
  [[nodiscard]] virtual std::unique_ptr<Camera> make() = 0;
};

/// What errors say of a camera that is not there: that was asked for, or that was used.
inline constexpr const char* no_such_camera = "there is no such camera";
inline constexpr const char* camera_is_gone = "the camera is gone";

/// The one that has this id, serial number or address. Errors: none (says which there are), more than one.
[[nodiscard]] Expected<CameraIdentity> find_camera(const std::vector<CameraIdentity>& there, const std::string& name);

/// "BayerRG8, Mono8 and Mono16", "none".
[[nodiscard]] std::string list_text(const std::vector<std::string>& words);

}  // namespace rigcal::camera
