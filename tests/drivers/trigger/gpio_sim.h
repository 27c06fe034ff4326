#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "drivers/net/privileges.h"

namespace rigcal::trigger {

/// A GPIO chip of the kernel's simulator (gpio-sim), made through configfs; needs root.
class GpioSim {
 public:
  static bool is_available() {
    std::error_code error;
    return std::filesystem::is_directory("/sys/kernel/config/gpio-sim", error) && geteuid() == 0;
  }

  explicit GpioSim(const std::string& label) : folder_("/sys/kernel/config/gpio-sim/" + label) {
    std::filesystem::create_directory(folder_);
    std::filesystem::create_directory(folder_ / "bank0");
    write(folder_ / "bank0/num_lines", "8");
    write(folder_ / "bank0/label", label);
    plug_in();
  }
  ~GpioSim() {
    unplug();
    std::error_code error;
    std::filesystem::remove(folder_ / "bank0", error);
    std::filesystem::remove(folder_, error);
  }
  GpioSim(const GpioSim&) = delete;
  GpioSim& operator=(const GpioSim&) = delete;

  void plug_in() { write(folder_ / "live", "1"); }
  void unplug() { write(folder_ / "live", "0"); }
  [[nodiscard]] std::string chip() const { return read(folder_ / "bank0/chip_name"); }
  [[nodiscard]] std::filesystem::path line(unsigned number) const {
    return std::filesystem::path("/sys/devices/platform") / read(folder_ / "dev_name") / chip() /
           ("sim_gpio" + std::to_string(number));
  }
  [[nodiscard]] bool is_high(unsigned number) const { return read(line(number) / "value") == "1"; }
  void pull(unsigned number, bool up) const { write(line(number) / "pull", up ? "pull-up" : "pull-down"); }

 private:
  static void write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string read(const std::filesystem::path& path) {
    std::string text;
    std::getline(std::ifstream(path) >> std::ws, text);
    return text;
  }
  std::filesystem::path folder_;
};

/// A wire from one line of a simulated chip to another, as fast as this machine can look.
class SimulatedWire {
 public:
  SimulatedWire(const GpioSim& chip, unsigned from, unsigned to)
      : value_(open((chip.line(from) / "value").c_str(), O_RDONLY)),
        pull_(open((chip.line(to) / "pull").c_str(), O_WRONLY)) {
    thread_ = std::thread([this] { run(); });
  }
  ~SimulatedWire() {
    is_running_.store(false);
    thread_.join();
    close(value_);
    close(pull_);
  }
  SimulatedWire(const SimulatedWire&) = delete;
  SimulatedWire& operator=(const SimulatedWire&) = delete;

  /// Rising edges that it has passed on: what it did not see, as the machine was busy, is no fault of the trigger.
  [[nodiscard]] std::uint64_t passed() const { return passed_.load(); }

 private:
  void run() {
    static_cast<void>(net::become_realtime());
    char last = '0';
    while (is_running_.load()) {
      char now = last;
      if (pread(value_, &now, 1, 0) == 1 && now != last) {
        const std::string level = now == '1' ? "pull-up" : "pull-down";
        if (pwrite(pull_, level.data(), level.size(), 0) > 0) last = now;
        if (last == '1') ++passed_;
      }
      usleep(300);
    }
  }
  int value_;
  int pull_;
  std::atomic<bool> is_running_{true};
  std::atomic<std::uint64_t> passed_{0};
  std::thread thread_;
};

}  // namespace rigcal::trigger
