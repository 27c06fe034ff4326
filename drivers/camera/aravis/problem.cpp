#include "drivers/camera/aravis/problem.h"

#include <arv.h>

namespace rigcal::camera {

Problem::~Problem() { g_clear_error(&error_); }

GError** Problem::put() {
  g_clear_error(&error_);
  return &error_;
}

std::string Problem::text() const { return error_ == nullptr ? std::string() : error_->message; }

bool Problem::is_absent() const { return g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_FOUND) != 0; }

bool Problem::is_held() const {
  return g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_CONTROLLER) != 0 ||
         g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED) != 0;
}

bool Problem::is_refusal() const {
  return error_ != nullptr && !g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TIMEOUT) &&
         !g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_CONNECTED) &&
         !g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TRANSFER_ERROR);
}

Expected<void> Problem::result(const std::string& tried, const std::string& where, const std::string& mend) const {
  if (is_none()) return {};
  std::string advice = mend;
  if (is_held()) {
    advice = "end the program that holds the camera";
  } else if (!is_refusal()) {
    advice = "the camera does not answer: look at its cable and its power";
  }
  return system_error(tried + ": " + text(), where, advice);
}

}  // namespace rigcal::camera
