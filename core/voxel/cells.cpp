#include "core/voxel/cells.h"

#include <algorithm>
#include <array>

#include "core/base/floor_of.h"

namespace rigcal {
namespace {

constexpr double thin_size_m = 0.02;
constexpr std::uint64_t empty_key = ~std::uint64_t{0};

std::size_t hash(std::uint64_t key) { return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20); }

// Where a cell lies in the sensor's grid.
struct GridCell {
  std::int64_t x = 0, y = 0, z = 0;

  [[nodiscard]] std::uint64_t key() const {
    const auto part = [](std::int64_t v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1FFFFF; };
    return part(x) << 42 | part(y) << 21 | part(z);
  }
};

// Sums about the cell's centre: small numbers, so no digits are lost, and one fixed point for all points of a cell.
struct Sums {
  double n = 0.0;
  double vx = 0.0, vy = 0.0, vz = 0.0;
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
};

// Points are taken in blocks: the next one's cell is brought from memory while this one is added.
constexpr std::size_t block = 128;

}  // namespace

struct CellBuilder::Table {
  int lidar;
  int stop;
  CellOptions options;
  std::uint64_t points = 0;
  std::vector<std::uint64_t> keys;  // open addressing, a power of two
  std::vector<std::uint32_t> slots;
  std::vector<GridCell> places;
  std::vector<Sums> sums;
  std::vector<Point> thinned;
  std::vector<std::array<std::uint64_t, 16>> thin_bits;  // a bit for each 2 cm cube of a cell

  Table(int lidar_index, int stop_index, const CellOptions& cell_options)
      : lidar(lidar_index), stop(stop_index), options(cell_options), keys(1 << 12, empty_key), slots(1 << 12, 0) {}

  [[nodiscard]] double centre(std::int64_t at) const { return (static_cast<double>(at) + 0.5) * options.size_m; }

  void grow() {
    const std::size_t size = keys.size() * 2;
    std::vector<std::uint64_t> new_keys(size, empty_key);
    std::vector<std::uint32_t> new_slots(size, 0);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == empty_key) continue;
      std::size_t at = hash(keys[i]) & (size - 1);
      while (new_keys[at] != empty_key) at = (at + 1) & (size - 1);
      new_keys[at] = keys[i];
      new_slots[at] = slots[i];
    }
    keys = std::move(new_keys);
    slots = std::move(new_slots);
  }

  std::uint32_t find_or_add(std::uint64_t key, const GridCell& place) {
    std::size_t at = hash(key) & (keys.size() - 1);
    while (keys[at] != empty_key) {
      if (keys[at] == key) return slots[at];
      at = (at + 1) & (keys.size() - 1);
    }
    const auto index = static_cast<std::uint32_t>(sums.size());
    sums.emplace_back();
    places.push_back(place);
    if (options.keep_thinned) thin_bits.emplace_back().fill(0);
    keys[at] = key;
    slots[at] = index;
    if (sums.size() * 2 > keys.size()) grow();
    return index;
  }

  void thin(std::uint32_t index, const Point& p, double dx, double dy, double dz) {
    // Up to 10 cubes a side fit the 1024 bits (cells of 0.2 m); larger cells share cubes, which only thins more.
    const double scale = std::min(1.0 / thin_size_m, 10.0 / options.size_m);
    const double half = 0.5 * options.size_m;
    const auto cube = [&](double d) { return std::min(9, std::max(0, static_cast<int>((d + half) * scale))); };
    const int bit = (cube(dx) * 10 + cube(dy)) * 10 + cube(dz);
    std::uint64_t& word = thin_bits[index][static_cast<std::size_t>(bit) / 64];
    const std::uint64_t mask = std::uint64_t{1} << (bit % 64);
    if ((word & mask) != 0) return;
    word |= mask;
    thinned.push_back(p);
  }

  // At most `block` points.
  void add_block(std::span<const Point> given) {
    const double inverse = 1.0 / options.size_m;
    const auto max_range = static_cast<float>(options.max_range_m);
    std::array<const Point*, block> near{};
    std::array<GridCell, block> place{};
    std::array<std::uint64_t, block> key{};
    std::array<std::uint32_t, block> index{};
    std::size_t count = 0;
    for (const Point& p : given) {
      if (!(p.x * p.x + p.y * p.y + p.z * p.z < max_range * max_range)) continue;
      near[count] = &p;
      place[count] = {floor_of(p.x * inverse), floor_of(p.y * inverse), floor_of(p.z * inverse)};
      key[count] = place[count].key();
      __builtin_prefetch(&keys[hash(key[count]) & (keys.size() - 1)]);
      ++count;
    }
    for (std::size_t i = 0; i < count; ++i) {
      index[i] = i > 0 && key[i] == key[i - 1] ? index[i - 1] : find_or_add(key[i], place[i]);
      __builtin_prefetch(&sums[index[i]], 1);
      __builtin_prefetch(&sums[index[i]].xz, 1);
    }
    for (std::size_t i = 0; i < count; ++i) add(*near[i], place[i], index[i]);
    points += count;
  }

  void add(const Point& p, const GridCell& place, std::uint32_t index) {
    Sums& s = sums[index];
    const double x = p.x - centre(place.x);
    const double y = p.y - centre(place.y);
    const double z = p.z - centre(place.z);
    s.n += 1.0;
    s.vx += x;
    s.vy += y;
    s.vz += z;
    s.xx += x * x;
    s.xy += x * y;
    s.xz += x * z;
    s.yy += y * y;
    s.yz += y * z;
    s.zz += z * z;
    if (options.keep_thinned) thin(index, p, x, y, z);
  }
};

CellBuilder::CellBuilder(int lidar, int stop, const CellOptions& options)
    : table_(std::make_unique<Table>(lidar, stop, options)) {}
CellBuilder::~CellBuilder() = default;
CellBuilder::CellBuilder(CellBuilder&&) noexcept = default;
CellBuilder& CellBuilder::operator=(CellBuilder&&) noexcept = default;

void CellBuilder::add(std::span<const Point> points) {
  while (!points.empty()) {
    const std::size_t count = std::min(block, points.size());
    table_->add_block(points.first(count));
    points = points.subspan(count);
  }
}

PatchCells CellBuilder::finish() {
  Table& t = *table_;
  PatchCells out{t.lidar, t.stop, t.points, {}, std::move(t.thinned)};
  out.cells.reserve(t.sums.size());
  for (std::size_t i = 0; i < t.sums.size(); ++i) {
    const Sums& s = t.sums[i];
    const GridCell& at = t.places[i];
    Cell cell;
    cell.N = s.n;
    const double mx = s.vx / s.n;
    const double my = s.vy / s.n;
    const double mz = s.vz / s.n;
    cell.mean = {t.centre(at.x) + mx, t.centre(at.y) + my, t.centre(at.z) + mz};
    cell.scatter << s.xx - s.n * mx * mx, s.xy - s.n * mx * my, s.xz - s.n * mx * mz, s.yy - s.n * my * my,
        s.yz - s.n * my * mz, s.zz - s.n * mz * mz;
    out.cells.push_back(cell);
  }
  *table_ = Table(t.lidar, t.stop, t.options);
  return out;
}

}  // namespace rigcal
