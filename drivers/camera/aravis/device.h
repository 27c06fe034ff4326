#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/camera/aravis/feature_names.h"
#include "drivers/camera/aravis/problem.h"
#include "drivers/camera/camera_config.h"

struct _ArvCamera;

namespace rigcal::camera {

/// A camera that is ours, with its features as texts and numbers. One thread uses it; it may get lost at any time.
class Device {
 public:
  /// By an IP address or by Aravis' own id. Errors say what to do about them, except where there is no such device.
  [[nodiscard]] static Expected<std::unique_ptr<Device>> open(const std::string& name);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] const CameraIdentity& identity() const { return identity_; }
  [[nodiscard]] Vendor vendor() const { return vendor_of(identity_.vendor); }
  [[nodiscard]] bool is_gige() const;
  [[nodiscard]] bool is_usb() const;
  /// Whether its heartbeat is gone, or its plug.
  [[nodiscard]] bool is_lost() const { return lost_->load(); }
  /// Whether it answered when it was asked last. Each question that it leaves open takes seconds, and its heartbeat may
  /// be missed only later.
  [[nodiscard]] bool answers() const { return answers_; }
  /// To be told of calls that others make.
  void heard(const Problem& problem) const { answers_ = problem.is_none() || problem.is_refusal(); }

  [[nodiscard]] bool has(const std::string& feature) const;
  /// The first of the purpose's names that the camera has; empty: none.
  [[nodiscard]] std::string name_of(Purpose purpose) const;
  [[nodiscard]] Expected<std::string> get(const std::string& feature) const;
  [[nodiscard]] Expected<double> number(const std::string& feature) const;
  /// Errors name the feature and what it takes.
  Expected<void> set(const std::string& feature, const std::string& value);
  Expected<void> execute(const std::string& command);
  /// The least and the greatest value of a number; without limits where it does not say.
  [[nodiscard]] std::pair<double, double> range(const std::string& feature) const;
  /// Of a whole number; 1 where it does not say.
  [[nodiscard]] std::int64_t step(const std::string& feature) const;
  /// What an enumeration can be now; empty where there is none.
  [[nodiscard]] std::vector<std::string> entries(const std::string& feature) const;
  [[nodiscard]] bool has_entry(const std::string& feature, const std::string& entry) const;

  [[nodiscard]] _ArvCamera* get() const { return camera_; }

 private:
  explicit Device(_ArvCamera* camera);
  void read_identity(const std::string& name);
  [[nodiscard]] std::string what_it_takes(const std::string& feature) const;

  _ArvCamera* camera_;
  CameraIdentity identity_;
  /// Set in Aravis' thread.
  std::shared_ptr<std::atomic<bool>> lost_ = std::make_shared<std::atomic<bool>>(false);
  std::uint64_t handler_ = 0;
  mutable bool answers_ = true;
};

}  // namespace rigcal::camera
