#include <benchmark/benchmark.h>

#include "core/base/random.h"
#include "drivers/livox_codec/sample_packet.h"

/// Points a second through the codec, for each data type: a cone of returns between 2 and 60 m, every twentieth slot
/// without one. 64 different packets in turn, so that the branch predictor cannot learn them.
namespace {

using rigcal::Point;
using rigcal::livox::DataType;

struct Packets {
  std::vector<std::vector<std::uint8_t>> bytes;
  std::vector<std::vector<Point>> points;
  std::int64_t slots = 0;  ///< Points of a packet, empty ones included.
  rigcal::livox::SampleHeader header;
};

Packets make_packets(DataType type) {
  rigcal::Random random(5);
  Packets packets;
  packets.header.data_type = type;
  const auto& layout = rigcal::livox::record_layout(type);
  packets.slots = std::int64_t{layout.slots} * layout.echoes;
  for (int i = 0; i < 64; ++i) {
    std::vector<Point> points;
    for (std::uint16_t shot = 0; shot < layout.slots; ++shot) {
      if (random.uniform() < 0.05) continue;
      rigcal::Vector3d way(1.0, random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6));
      way.normalize();
      for (unsigned echo = 0; echo < layout.echoes; ++echo) {
        const rigcal::Vector3d at = way * random.uniform(2.0, 60.0);
        points.push_back(
            {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z()), 30, 0x10, shot});
      }
    }
    rigcal::livox::encode_points(packets.header, points, packets.bytes.emplace_back());
    packets.points.push_back(std::move(points));
  }
  return packets;
}

void decode(benchmark::State& state) {
  const Packets packets = make_packets(static_cast<DataType>(state.range(0)));
  std::vector<Point> points;
  std::size_t next = 0;
  for (auto _ : state) {
    const auto packet = rigcal::livox::parse_sample_packet(packets.bytes[next]);
    rigcal::livox::decode_points(*packet, points);
    benchmark::DoNotOptimize(points.data());
    benchmark::ClobberMemory();
    next = (next + 1) % packets.bytes.size();
  }
  state.SetItemsProcessed(state.iterations() * packets.slots);
}

void encode(benchmark::State& state) {
  const Packets packets = make_packets(static_cast<DataType>(state.range(0)));
  std::vector<std::uint8_t> bytes;
  std::size_t next = 0;
  for (auto _ : state) {
    rigcal::livox::encode_points(packets.header, packets.points[next], bytes);
    benchmark::DoNotOptimize(bytes.data());
    benchmark::ClobberMemory();
    next = (next + 1) % packets.points.size();
  }
  state.SetItemsProcessed(state.iterations() * packets.slots);
}

void point_types(benchmark::internal::Benchmark* bench) {
  bench->ArgName("data_type");
  for (const int type : {0, 1, 2, 3, 4, 5, 7, 8}) bench->Arg(type);
}

BENCHMARK(decode)->Apply(point_types);
BENCHMARK(encode)->Apply(point_types);

}  // namespace
