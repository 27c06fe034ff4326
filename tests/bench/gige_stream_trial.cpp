// A long stream of a virtual camera to Aravis over loopback, each in a process of its own: how many frames are whole to
// the bit, how many are said to be damaged, and what it costs. gige_stream_trial --seconds 300 --loss 0.01
#include <arv.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

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
  std::uint64_t whole = 0;
  std::uint64_t flagged = 0;
  std::uint64_t torn = 0;
  std::uint64_t numbers = 0;  // From the first frame's to the last one's.
  double seconds = 0.0;
  double cpu_s = 0.0;
  double check_s = 0.0;
};

void check(GError* error) {
  if (error != nullptr) fail(error->message);
}

ArvCamera* open_camera() {
  for (int i = 0; i < 100; ++i) {
    if (ArvCamera* camera = arv_camera_new(address, nullptr)) return camera;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  fail("the camera does not appear");
}

HostReport receive(const Trial& trial) {
  ArvCamera* camera = open_camera();
  GError* error = nullptr;
  if (trial.no_packet_socket) arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  arv_camera_set_frame_rate(camera, trial.rate, &error);
  check(error);
  arv_camera_gv_set_packet_size(camera, trial.packet_bytes, &error);
  check(error);
  ArvStream* stream = arv_camera_create_stream(camera, nullptr, nullptr, &error);
  check(error);
  g_object_set(stream, "packet-resend",
               trial.no_resend ? ARV_GV_STREAM_PACKET_RESEND_NEVER : ARV_GV_STREAM_PACKET_RESEND_ALWAYS, nullptr);
  const guint payload = arv_camera_get_payload(camera, &error);
  check(error);
  for (int i = 0; i < 20; ++i) arv_stream_push_buffer(stream, arv_buffer_new(payload, nullptr));
  sim::TestPattern pattern;
  sim::FrameWish wish;
  wish.pixel_format = "BayerRG8";
  wish.width = 1280;
  wish.height = 1024;
  std::vector<std::uint8_t> expected;
  HostReport report;
  std::uint64_t last_id = 1;
  std::uint64_t number = 0;
  const double cpu_before = cpu_seconds();
  const auto start = Clock::now();
  arv_camera_start_acquisition(camera, &error);
  check(error);
  while (std::chrono::duration<double>(Clock::now() - start).count() < trial.seconds) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 1'000'000);
    if (buffer == nullptr) continue;
    // Ids have 16 bits and no 0. Frames come nearly in order.
    const std::uint64_t id = arv_buffer_get_frame_id(buffer);
    const std::uint64_t step = (id + 65535 - last_id) % 65535;
    const std::uint64_t this_number = step < 32768 ? number + step : number - (65535 - step);
    if (step < 32768) {
      number = this_number;
      last_id = id;
    }
    if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS) {
      ++report.flagged;
    } else {
      const auto check_start = Clock::now();
      wish.number = this_number;
      pattern.make(wish, expected);
      std::size_t size = 0;
      const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
      ++(std::equal(expected.begin(), expected.end(), data, data + size) ? report.whole : report.torn);
      report.check_s += std::chrono::duration<double>(Clock::now() - check_start).count();
    }
    arv_stream_push_buffer(stream, buffer);
  }
  arv_camera_stop_acquisition(camera, nullptr);
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  report.cpu_s = cpu_seconds() - cpu_before;
  report.numbers = number + 1;
  for (guint i = 0; i < arv_stream_get_n_infos(stream); ++i) {
    if (arv_stream_get_info_type(stream, i) == G_TYPE_UINT64)
      std::printf("  aravis %s: %llu\n", arv_stream_get_info_name(stream, i),
                  static_cast<unsigned long long>(arv_stream_get_info_uint64(stream, i)));
  }
  g_object_unref(stream);
  g_object_unref(camera);
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
  const std::uint64_t all = host.whole + host.flagged + host.torn;
  std::printf("frames: %llu in %.1f s (%.2f a second); whole %llu (%.3f %%), flagged %llu, torn %llu, not seen %lld\n",
              static_cast<unsigned long long>(all), host.seconds, static_cast<double>(all) / host.seconds,
              static_cast<unsigned long long>(host.whole),
              100.0 * static_cast<double>(host.whole) / static_cast<double>(host.numbers),
              static_cast<unsigned long long>(host.flagged), static_cast<unsigned long long>(host.torn),
              static_cast<long long>(host.numbers) - static_cast<long long>(all));
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
  CLI::App app("A long stream of a virtual GigE Vision camera to Aravis");
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
