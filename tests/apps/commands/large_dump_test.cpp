#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/base/random.h"
#include "core/io/pcapng_writer.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// A turntable run of an AVIA and three MID-40 of any length: full packets at their real rates, 3 s of turning and 3 s
// of rest in turn by the gyro. What the points show does not matter here and is always the same.
class LongRun {
 public:
  explicit LongRun(const fs::path& path) : writer_(PcapngWriter::create(path.string())) {
    for (int k = 0; k < 4; ++k) {
      std::vector<Point> points;
      livox::SampleHeader header;
      header.data_type = k == 0 ? livox::DataType::cartesian_tagged : livox::DataType::cartesian;
      const std::uint16_t slots = livox::record_layout(header.data_type).slots;
      for (std::uint16_t i = 0; i < slots; ++i) {
        points.push_back({8.0F, 0.02F * static_cast<float>(i), 0.5F, 40, 0, i});
      }
      livox::encode_points(header, points, packets_[k]);
    }
  }

  /// Writes until the file has `bytes`.
  void write(std::uint64_t bytes) {
    ASSERT_TRUE(writer_);
    for (std::int64_t tick = 0; writer_->bytes() < bytes; ++tick) {  // a tick is 200 us
      const std::int64_t at_ns = tick * 200'000;
      if (tick % 2 == 0) send(0, 60001, packets_[0], at_ns);
      for (std::size_t k = 1; k < 4; ++k) {
        if (tick % 5 == static_cast<std::int64_t>(k)) send(k, 60001, packets_[k], at_ns);
      }
      if (tick % 25 == 0) send_imu(at_ns);
    }
    ASSERT_TRUE(writer_->close());
  }

 private:
  void send(std::size_t device, std::uint16_t port, std::vector<std::uint8_t>& bytes, std::int64_t at_ns) {
    constexpr std::size_t stamp_offset = 10;
    std::memcpy(bytes.data() + stamp_offset, &at_ns, sizeof at_ns);
    constexpr std::uint8_t last[] = {179, 21, 91, 161};
    ASSERT_TRUE(writer_->write({1'700'000'000'000'000'000 + at_ns + 300'000,
                                {{192, 168, 1, last[device]}, port},
                                {{192, 168, 1, 5}, 56001},
                                bytes}));
  }

  void send_imu(std::int64_t at_ns) {
    const double in_cycle_s = static_cast<double>(at_ns % 6'000'000'000) * 1e-9;
    const double turn_s = in_cycle_s - 3.0;
    // A smooth turn of 18 degrees.
    const double rate = turn_s <= 0.0 ? 0.0 : 0.105 * (1.0 - std::cos(2.0 * pi * turn_s / 3.0));
    livox::ImuReading reading;
    for (float& g : reading.gyro_rad_s) g = static_cast<float>(1e-3 * random_.normal());
    reading.gyro_rad_s[2] += static_cast<float>(rate);
    for (float& a : reading.acceleration_g) a = static_cast<float>(1e-3 * random_.normal());
    reading.acceleration_g[2] += 1.0F;
    livox::SampleHeader header;
    header.data_type = livox::DataType::imu;
    livox::encode_imu(header, reading, imu_);
    send(0, 60003, imu_, at_ns);
  }

  Expected<PcapngWriter> writer_;
  Random random_{7};
  std::vector<std::uint8_t> packets_[4];
  std::vector<std::uint8_t> imu_;
};

// Runs `rigcal inspect` and gives its largest resident memory, or a negative number where it failed.
double peak_memory_mb(const fs::path& dump) {
  const std::string rig = std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/turntable.yaml";
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    execl(RIGCAL_PROGRAM, "rigcal", "inspect", dump.c_str(), "--rig", rig.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return -1.0;
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;
}

// The size of the large dump: $RIGCAL_LARGE_DUMP_BYTES, 300 MB otherwise.
std::uint64_t large_bytes() {
  const char* wanted = std::getenv("RIGCAL_LARGE_DUMP_BYTES");
  return wanted == nullptr ? 300'000'000 : static_cast<std::uint64_t>(std::atof(wanted));
}

TEST(LargeDump, IsReadInTheMemoryOfASmallOne) {
  const fs::path folder = scratch_folder("large_dump");
  const std::uint64_t bytes[] = {10'000'000, 100'000'000, large_bytes()};
  double peak_mb[3];
  for (int k = 0; k < 3; ++k) {
    const fs::path dump = folder / "run.pcapng";
    LongRun(dump).write(bytes[k]);
    peak_mb[k] = peak_memory_mb(dump);
    std::printf("a dump of %.3f GB: %.1f MB of memory\n", static_cast<double>(fs::file_size(dump)) / 1e9, peak_mb[k]);
  }
  for (const double peak : peak_mb) ASSERT_GT(peak, 0.0);
  // Ten megabytes are over before the first stop is; from then on nothing grows. Which threads meet decides about a
  // buffer more or less: some 4 MB from run to run.
  EXPECT_LT(peak_mb[1], peak_mb[0] + 32.0);
  EXPECT_LT(peak_mb[2], peak_mb[1] + 16.0);
}

}  // namespace
}  // namespace rigcal
