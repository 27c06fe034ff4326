// A long stream of a virtual camera to the driver over loopback, each in a process of its own: how many frames are
// whole to the bit, how many are said to be damaged, and what it costs. gige_stream_trial --seconds 300 --loss 0.01
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <type_traits>

#include "drivers/camera/aravis/aravis_backend.h"
#include "simdata/gige/camera_server.h"
#include "simdata/gige/test_pattern.h"
#include "tests/bench/cpu_seconds.h"

namespace {

using namespace rigcal;
using Clock = std::chrono::steady_clock;

struct Trial {
  double seconds = 60.0;
  double rate = 60.0;
  double loss = 0.0;
  bool no_resend = false;
  int packet_bytes = 1500;
  bool no_packet_socket = false;
};

constexpr const char* address = "127.0.7.41";
volatile std::sig_atomic_t is_over = 0;

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::exit(4);
}

// The device's process: serves until it is told to end, then tells its counts through the pipe.
struct DeviceReport {
  sim::CameraCounts counts;
  double cpu_s = 0.0;
};

void serve(const Trial& trial, int report) {
  std::signal(SIGTERM, [](int) { is_over = 1; });
  sim::ServedCamera camera;
  camera.device.identity.ip = {127, 0, 7, 41};
  camera.device.identity.mask = {255, 0, 0, 0};
  camera.device.identity.manufacturer = "Hikrobot";
  camera.device.identity.model = "MV-CA013-21UC";
  camera.device.identity.serial = "trial";
  camera.device.pixel_formats = {"BayerRG8"};
  camera.device.exposure_us = 1000.0;
  camera.device.can_resend = !trial.no_resend;
  camera.faults.loss = trial.loss;
  camera.source = std::make_shared<sim::TestPattern>();
  const auto server = sim::CameraServer::start({camera});
  if (!server) fail(server.error().message());
  while (is_over == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const DeviceReport told{(*server)->counts()[0], cpu_seconds()};
  if (write(report, &told, sizeof told) != sizeof told) std::exit(1);
  std::exit(0);
}

struct HostReport {
  camera::CameraCounters counters;
  std::uint64_t torn = 0;  // Passed as whole, and are not.
  double seconds = 0.0;
  double cpu_s = 0.0;
  double check_s = 0.0;
};

template <class T>
T must(Expected<T> value) {
  if (!value) fail(value.error().message());
  if constexpr (!std::is_void_v<T>) return *std::move(value);
}

void open_camera(camera::Camera& camera) {
  for (int i = 0; i < 100; ++i) {
    if (camera.open(address)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  fail("the camera does not appear");
}

HostReport receive(const Trial& trial) {
  camera::AravisOptions options;
  options.resend = !trial.no_resend;
  options.packet_socket = !trial.no_packet_socket;
  const auto camera = camera::AravisBackend(options).make();
  open_camera(*camera);
  camera::CameraConfig config;
  config.frame_rate = trial.rate;
  config.packet_bytes = trial.packet_bytes;
  config.buffers = 20;
  const camera::CameraSetup setup = must(camera->configure(config));
  sim::TestPattern pattern;
  sim::FrameWish wish;
  wish.pixel_format = setup.pixel_format;
  wish.width = setup.width;
  wish.height = setup.height;
  std::vector<std::uint8_t> expected;
  HostReport report;
  std::uint64_t last_id = 1;
  std::int64_t number = 0;
  const double cpu_before = cpu_seconds();
  const auto start = Clock::now();
  must(camera->start());
  while (std::chrono::duration<double>(Clock::now() - start).count() < trial.seconds) {
    const camera::Delivery delivery = must(camera->next(1'000'000'000));
    if (delivery.kind == camera::Delivery::Kind::lost) fail(delivery.text);
    if (delivery.kind != camera::Delivery::Kind::frame) continue;
    number += frame_steps(setup.frame_ids, last_id, delivery.frame.facts().frame_id);
    last_id = delivery.frame.facts().frame_id;
    if (!delivery.frame.is_whole()) continue;
    const auto check_start = Clock::now();
    wish.number = static_cast<std::uint64_t>(number);
    pattern.make(wish, expected);
    const ByteView pixels = delivery.frame.pixels();
    if (!std::equal(expected.begin(), expected.end(), pixels.begin(), pixels.end())) ++report.torn;
    report.check_s += std::chrono::duration<double>(Clock::now() - check_start).count();
  }
  must(camera->stop());
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  report.cpu_s = cpu_seconds() - cpu_before;
  report.counters = camera->counters();
  return report;
}

int run(const Trial& trial) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) fail("no pipe");
  const pid_t device = fork();
  if (device < 0) fail("no process");
  if (device == 0) serve(trial, pipe_ends[1]);
  const HostReport host = receive(trial);
  kill(device, SIGTERM);
  DeviceReport told;
  const bool is_told = read(pipe_ends[0], &told, sizeof told) == sizeof told;
  waitpid(device, nullptr, 0);
  if (!is_told) fail("the device has ended too soon");
  const camera::CameraCounters& counters = host.counters;
  const std::uint64_t all = counters.whole() + counters.damaged() + counters.missing;
  std::printf(
      "frames: %llu in %.1f s (%.2f a second); whole %llu (%.3f %%), of these torn %llu; flagged %llu, missing %llu "
      "(no "
      "buffer: %llu); packets sent again %llu\n",
      static_cast<unsigned long long>(all), host.seconds, static_cast<double>(all) / host.seconds,
      static_cast<unsigned long long>(counters.whole()),
      100.0 * static_cast<double>(counters.whole()) / static_cast<double>(all),
      static_cast<unsigned long long>(host.torn), static_cast<unsigned long long>(counters.damaged()),
      static_cast<unsigned long long>(counters.missing), static_cast<unsigned long long>(counters.no_buffer),
      static_cast<unsigned long long>(counters.resent_packets));
  std::printf(
      "device: %llu packets, %llu lost in %llu frames, %llu sent again, %llu refused by the system, %llu frames "
      "dropped\n",
      static_cast<unsigned long long>(told.counts.stream.packets),
      static_cast<unsigned long long>(told.counts.stream.lost),
      static_cast<unsigned long long>(told.counts.stream.damaged_blocks),
      static_cast<unsigned long long>(told.counts.stream.resent),
      static_cast<unsigned long long>(told.counts.unsent_packets),
      static_cast<unsigned long long>(told.counts.dropped_frames + told.counts.stream.skipped_blocks));
  std::printf("CPU share of a core: device %.1f %%, host %.1f %% (%.1f %% of it the comparison)\n",
              100.0 * told.cpu_s / host.seconds, 100.0 * host.cpu_s / host.seconds, 100.0 * host.check_s / host.cpu_s);
  return host.torn == 0 ? 0 : 1;
}

}  // namespace

int main(int count, char** words) {
  CLI::App app("A long stream of a virtual GigE Vision camera to the driver");
  Trial trial;
  app.add_option("--seconds", trial.seconds);
  app.add_option("--rate", trial.rate, "Frames a second of 1280 x 1024");
  app.add_option("--loss", trial.loss, "Share of packets that get lost");
  app.add_flag("--no-resend", trial.no_resend);
  app.add_option("--packet", trial.packet_bytes);
  app.add_flag("--no-packet-socket", trial.no_packet_socket, "As for a user without privileges");
  CLI11_PARSE(app, count, words);
  return run(trial);
}
