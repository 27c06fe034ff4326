#include <benchmark/benchmark.h>

#include "core/base/parallel.h"
#include "core/corner/rig_placement.h"
#include "simdata/targets/corner_clouds.h"

// The planes method from points to extrinsics, on the paper's corner. Aim: below a second (the paper: 27 to 106 s).
namespace rigcal {
namespace {

void planes_of_two_lidars(benchmark::State& state) {
  set_thread_count(static_cast<int>(state.range(1)));
  const auto clouds = sim::make_corner_clouds({.angle_deg = 75.0,
                                               .points = static_cast<int>(state.range(0)),
                                               .sigma_m = 0.02,
                                               .T_a_b = sim::paper_configuration(1)});
  for (auto _ : state) {
    RigViews views;
    views.names = {"a", "b"};
    views.stops = {{plane_view(plane_cloud(clouds.a.points)), plane_view(plane_cloud(clouds.b.points))}};
    RigPlacement placed = place_rig(views, {SE3{}, std::nullopt});
    if (!placed.lidars[1].known) state.SkipWithError("not found");
    benchmark::DoNotOptimize(placed.misfit);
  }
}
BENCHMARK(planes_of_two_lidars)
    ->Args({7500, 1})
    ->Args({7500, 2})
    ->Args({100000, 1})
    ->Args({100000, 2})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rigcal
