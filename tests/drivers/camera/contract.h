#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/camera/camera.h"

/// What every back end has to keep (contract_test.cpp). Another back end is tried by one more maker in subjects().
namespace rigcal::camera {

/// A back end with a camera that can be reached by it.
class ContractSubject {
 public:
  virtual ~ContractSubject() = default;
  [[nodiscard]] virtual CameraBackend& backend() = 0;
  /// The camera's id, as `enumerate` gives it.
  [[nodiscard]] virtual std::string camera() const = 0;
  /// What it is opened by: where a search takes long, its address.
  [[nodiscard]] virtual std::string name() const { return camera(); }
  /// Free running, at 20 to 100 small frames a second.
  [[nodiscard]] virtual CameraConfig config() const = 0;
  /// A part of the sensor other than that of `config`; nothing where the camera has no such thing.
  [[nodiscard]] virtual std::optional<Region> part() const { return std::nullopt; }
  [[nodiscard]] virtual std::string missing_format() const { return "BayerGB14"; }
  [[nodiscard]] virtual bool has_software_trigger() const { return true; }
  [[nodiscard]] virtual bool allocates_for_frames() const { return false; }
  /// How many of a test's frames may come in part: none but where frames travel in pieces that a busy machine may lose.
  [[nodiscard]] virtual std::uint64_t most_not_whole() const { return 0; }
};

struct SubjectMaker {
  std::string name;
  /// Nothing where the machine lacks what it needs; `reason` says what.
  std::unique_ptr<ContractSubject> (*make)(std::string& reason);
};

/// As GoogleTest shows it.
inline void PrintTo(const SubjectMaker& maker, std::ostream* out) { *out << maker.name; }

[[nodiscard]] std::unique_ptr<ContractSubject> make_images_subject(std::string& reason);
[[nodiscard]] std::unique_ptr<ContractSubject> make_virtual_gige_subject(std::string& reason);
[[nodiscard]] std::unique_ptr<ContractSubject> make_aravis_fake_subject(std::string& reason);

[[nodiscard]] std::unique_ptr<ContractSubject> make_fake_video_subject(std::string& reason);
[[nodiscard]] std::unique_ptr<ContractSubject> make_video_device_subject(std::string& reason);

[[nodiscard]] std::unique_ptr<ContractSubject> make_usb3_subject(std::string& reason);

[[nodiscard]] inline std::vector<SubjectMaker> subjects() {
  return {{"Images", make_images_subject},
          {"VirtualGige", make_virtual_gige_subject},
          {"AravisFakeGige", make_aravis_fake_subject},
          {"V4l2AnsweredByTheTest", make_fake_video_subject},
          {"V4l2Device", make_video_device_subject},
          {"Usb3", make_usb3_subject}};
}

}  // namespace rigcal::camera
