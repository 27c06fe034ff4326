#include <benchmark/benchmark.h>

#include <cstring>

#include "apps/ingest/lidar_ingest.h"
#include "core/base/random.h"
#include "drivers/livox_codec/sample_packet.h"

/// Datagrams of an Avia (single return, Cartesian) through everything that stands before the stop finder: checks,
/// identity, decoding, clock, ledger, noise and range filter. Slots a second.
namespace {

using namespace rigcal;

void ingest(benchmark::State& state) {
  Random random(5);
  Rig rig;
  Sensor& sensor = rig.sensors.emplace_back();
  sensor.name = "avia";
  sensor.lidar.emplace();
  sensor.lidar->model = LidarModel::livox_avia;
  sensor.lidar->ip = {192, 168, 1, 179};
  livox::SampleHeader header;
  header.data_type = livox::DataType::cartesian_tagged;
  std::vector<std::vector<std::uint8_t>> packets(64);
  for (auto& bytes : packets) {
    std::vector<Point> points;
    for (std::uint16_t shot = 0; shot < 96; ++shot) {
      if (random.uniform() < 0.05) continue;
      points.push_back({static_cast<float>(random.uniform(1.0, 60.0)), static_cast<float>(random.uniform(-30.0, 30.0)),
                        1.0F, 30, random.uniform() < 0.02 ? std::uint8_t{0x11} : std::uint8_t{0x10}, shot});
    }
    livox::encode_points(header, points, bytes);
  }
  std::size_t kept = 0;
  LidarIngest ingest(rig, [&kept](PointBatch& batch) { kept += batch.points.size(); }, {});
  std::int64_t stamp = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    std::vector<std::uint8_t>& bytes = packets[next];
    std::memcpy(bytes.data() + 10, &stamp, sizeof stamp);
    ingest.add({1'000'000'000 + stamp, {{192, 168, 1, 179}, 60001}, {{192, 168, 1, 5}, 56001}, bytes});
    stamp += 400'000;
    next = (next + 1) % packets.size();
  }
  benchmark::DoNotOptimize(kept);
  state.SetItemsProcessed(state.iterations() * 96);
}

BENCHMARK(ingest);

}  // namespace
