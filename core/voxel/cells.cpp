#include "core/voxel/cells.h"

#include <algorithm>
#include <array>

#include "core/base/packed_cube.h"
#include "core/base/wide.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double thin_size_m = 0.02;
constexpr std::uint64_t empty_key = ~std::uint64_t{0};

std::size_t hash(std::uint64_t key) { return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20); }

// Where a cell lies in the sensor's grid.
struct GridCell {
  std::int32_t x = 0, y = 0, z = 0;
};

// Sums about the cell's centre: small numbers, so no digits are lost, and one fixed point for all points of a cell.
struct Sums {
  double n = 0.0;
  double vx = 0.0, vy = 0.0, vz = 0.0;
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;

  Sums& operator+=(const Sums& other) {
    n += other.n;
    vx += other.vx;
    vy += other.vy;
    vz += other.vz;
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    return *this;
  }
};

constexpr std::size_t octants = 8;

// Which sums are those of each octant of a cell, all about the centre of the whole; most cells are hit in a few only.
constexpr std::uint32_t no_sums = ~std::uint32_t{0};
using OctantNumbers = std::array<std::uint32_t, octants>;

// The mean is seen from the cell's centre.
Cell cell_of(const Sums& s) {
  Cell cell;
  cell.N = s.n;
  const double mx = s.vx / s.n;
  const double my = s.vy / s.n;
  const double mz = s.vz / s.n;
  cell.mean = {mx, my, mz};
  cell.scatter << s.xx - s.n * mx * mx, s.xy - s.n * mx * my, s.xz - s.n * mx * mz, s.yy - s.n * my * my,
      s.yz - s.n * my * mz, s.zz - s.n * mz * mz;
  return cell;
}

// What the wire's whole millimetres alone are off by, m^2.
constexpr double rounding_variance = 1e-6 / 12.0;
// Fewer points tell no corner from noise.
constexpr double least_points = 8.0;
// Of the octants' middles about the cell's plane, over what their own thickness lets expect. Many a flat cell comes out
// above it, which takes time and no accuracy; with more, corners stay whole (docs/decisions/026).
constexpr double most_bent = 1.5;

// Whether the octants of a cell lie in one plane as far as their own thickness tells: variance between them over
// variance within. Any plane goes through three: those few are told apart rather than judged.
bool is_flat(const Cell& whole, const std::array<const Sums*, octants>& parts) {
  const auto groups =
      static_cast<double>(octants) - static_cast<double>(std::count(parts.begin(), parts.end(), nullptr));
  if (groups < 2.0 || whole.N < least_points) return true;
  if (groups < 4.0) return false;
  const SymmetricEigen eigen = symmetric_eigen_fast(whole.scatter_matrix());
  const Vector3d u = eigen.vectors.col(0);
  double between = 0.0;
  for (const Sums* part : parts) {
    // An octant of a few points may be the edge of another surface, as of a wall below a ceiling: it counts too.
    if (part == nullptr) continue;
    const double off = (u.x() * part->vx + u.y() * part->vy + u.z() * part->vz) / part->n - u.dot(whole.mean);
    between += part->n * off * off;
  }
  const double within = std::max(0.0, eigen.values[0] - between) / std::max(1.0, whole.N - groups);
  return between / (groups - 3.0) <= most_bent * (within + rounding_variance);
}

// Points are taken in blocks: what the next ones need is brought from memory while these are added.
constexpr std::size_t block = 128;

template <class Value>
using Each = std::array<Value, block>;

// Of the points of a block, coordinate by coordinate: their cells, where they lie in them, and in which 2 cm cube.
struct Placed {
  std::array<Each<float>, 3> point;
  std::array<Each<std::int32_t>, 3> cell;
  std::array<Each<double>, 3> off;  // from the cell's centre
  Each<std::uint64_t> key;
  Each<std::uint32_t> octant;
  Each<std::int32_t> thin_cube;
};

std::int32_t small_floor_of(double value) {
  const auto whole = static_cast<std::int32_t>(value);
  return whole - static_cast<std::int32_t>(static_cast<double>(whole) > value);
}

// For all of the block, however many points it has.
RIGCAL_WIDE void place(double size_m, Placed& at) {
  const double inverse = 1.0 / size_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* const point = at.point[axis].data();
    std::int32_t* const cell = at.cell[axis].data();
    double* const off = at.off[axis].data();
    for (std::size_t i = 0; i < block; ++i) {
      const double p = point[i];
      const std::int32_t whole = small_floor_of(p * inverse);
      cell[i] = whole;
      off[i] = p - (static_cast<double>(whole) + 0.5) * size_m;
    }
  }
  const std::int32_t* const x = at.cell[0].data();
  const std::int32_t* const y = at.cell[1].data();
  const std::int32_t* const z = at.cell[2].data();
  for (std::size_t i = 0; i < block; ++i) at.key[i] = packed_cube(x[i], y[i], z[i]);
  const auto upper = [](double off) { return static_cast<std::uint32_t>(off >= 0.0); };
  for (std::size_t i = 0; i < block; ++i)
    at.octant[i] = upper(at.off[0][i]) | upper(at.off[1][i]) << 1 | upper(at.off[2][i]) << 2;
}

// Up to 10 cubes a side fit the 1024 bits (cells of 0.2 m); larger cells share cubes, which only thins more.
RIGCAL_WIDE void place_in_cell(double size_m, Placed& at) {
  const double scale = std::min(1.0 / thin_size_m, 10.0 / size_m);
  const double half = 0.5 * size_m;
  const auto cube = [&](double d) { return std::min(9, std::max(0, static_cast<std::int32_t>((d + half) * scale))); };
  for (std::size_t i = 0; i < block; ++i) {
    at.thin_cube[i] = (cube(at.off[0][i]) * 10 + cube(at.off[1][i])) * 10 + cube(at.off[2][i]);
  }
}

}  // namespace

struct CellBuilder::Table {
  struct Slot {
    std::uint64_t key = empty_key;
    std::uint32_t index = 0;
  };

  int lidar = 0;
  int stop = 0;
  CellOptions options;
  std::uint64_t points = 0;
  std::vector<Slot> slots;  // open addressing, a power of two
  std::vector<GridCell> places;
  std::vector<OctantNumbers> octants_of;  // of each cell
  std::vector<Sums> sums;
  std::vector<Point> thinned;
  std::vector<std::array<std::uint64_t, 16>> thin_bits;  // a bit for each 2 cm cube of a cell
  Placed placed{};

  Table() : slots(1 << 12) {}

  void begin(int lidar_index, int stop_index, const CellOptions& cell_options) {
    lidar = lidar_index;
    stop = stop_index;
    options = cell_options;
    clear();
  }

  // The memory stays, but for what is given away.
  void clear() {
    points = 0;
    std::fill(slots.begin(), slots.end(), Slot{});
    places.clear();
    octants_of.clear();
    sums.clear();
    thinned = {};
    thin_bits.clear();
  }

  [[nodiscard]] double centre(std::int32_t at) const { return (static_cast<double>(at) + 0.5) * options.size_m; }

  [[nodiscard]] std::size_t first_slot(std::uint64_t key) const { return hash(key) & (slots.size() - 1); }

  void grow() {
    std::vector<Slot> old(slots.size() * 2);
    old.swap(slots);
    for (const Slot& slot : old) {
      if (slot.key == empty_key) continue;
      std::size_t at = first_slot(slot.key);
      while (slots[at].key != empty_key) at = (at + 1) & (slots.size() - 1);
      slots[at] = slot;
    }
  }

  std::uint32_t find_or_add(std::uint64_t key, const GridCell& cell) {
    std::size_t at = first_slot(key);
    while (slots[at].key != empty_key) {
      if (slots[at].key == key) return slots[at].index;
      at = (at + 1) & (slots.size() - 1);
    }
    const auto index = static_cast<std::uint32_t>(places.size());
    octants_of.emplace_back().fill(no_sums);
    places.push_back(cell);
    if (options.keep_thinned) thin_bits.emplace_back().fill(0);
    slots[at] = {key, index};
    if (places.size() * 2 > slots.size()) grow();
    return index;
  }

  [[nodiscard]] std::uint64_t& thin_word(std::uint32_t index, std::int32_t cube) {
    return thin_bits[index][static_cast<std::size_t>(cube) / 64];
  }

  // At most `block` points.
  void add_block(std::span<const Point> given) {
    const auto max_range = static_cast<float>(options.max_range_m);
    std::array<const Point*, block> near;
    std::array<std::uint32_t, block> index;
    std::array<std::uint32_t, block> octant;
    std::size_t count = 0;
    for (const Point& p : given) {
      near[count] = &p;
      placed.point[0][count] = p.x;
      placed.point[1][count] = p.y;
      placed.point[2][count] = p.z;
      count += p.x * p.x + p.y * p.y + p.z * p.z < max_range * max_range ? 1 : 0;
    }
    // What is left from the block before, or is too far, would be no number that fits.
    for (std::size_t i = count; i < block; ++i) {
      for (Each<float>& coordinate : placed.point) coordinate[i] = 0.0F;
    }
    place(options.size_m, placed);
    if (options.keep_thinned) place_in_cell(options.size_m, placed);
    for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&slots[first_slot(placed.key[i])]);
    for (std::size_t i = 0; i < count; ++i) {
      index[i] = i > 0 && placed.key[i] == placed.key[i - 1]
                     ? index[i - 1]
                     : find_or_add(placed.key[i], {placed.cell[0][i], placed.cell[1][i], placed.cell[2][i]});
      __builtin_prefetch(&octants_of[index[i]], 1);
      if (options.keep_thinned) __builtin_prefetch(&thin_word(index[i], placed.thin_cube[i]), 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t& number = octants_of[index[i]][placed.octant[i]];
      if (number == no_sums) {
        number = static_cast<std::uint32_t>(sums.size());
        sums.emplace_back();
      }
      octant[i] = number;
      __builtin_prefetch(&sums[number], 1);
      __builtin_prefetch(&sums[number].zz, 1);
    }
    for (std::size_t i = 0; i < count; ++i) add(i, sums[octant[i]]);
    if (options.keep_thinned) {
      for (std::size_t i = 0; i < count; ++i) thin(*near[i], index[i], placed.thin_cube[i]);
    }
    points += count;
  }

  void add(std::size_t i, Sums& s) const {
    const double x = placed.off[0][i];
    const double y = placed.off[1][i];
    const double z = placed.off[2][i];
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
  }

  void thin(const Point& p, std::uint32_t index, std::int32_t cube) {
    std::uint64_t& word = thin_word(index, cube);
    const std::uint64_t mask = std::uint64_t{1} << (cube % 64);
    if ((word & mask) != 0) return;
    word |= mask;
    thinned.push_back(p);
  }
};

CellBuilder::CellBuilder(int lidar, int stop, const CellOptions& options) : table_(std::make_unique<Table>()) {
  begin(lidar, stop, options);
}
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
  PatchCells out{t.lidar, t.stop, t.points, {}, {}, {}, std::move(t.thinned)};
  out.cells.reserve(t.places.size());
  std::array<const Sums*, octants> parts{};
  for (std::size_t i = 0; i < t.places.size(); ++i) {
    Sums all;
    for (std::size_t k = 0; k < octants; ++k) {
      const std::uint32_t number = t.octants_of[i][k];
      parts[k] = number == no_sums ? nullptr : &t.sums[number];
      if (parts[k] != nullptr) all += *parts[k];
    }
    const Vector3d centre(t.centre(t.places[i].x), t.centre(t.places[i].y), t.centre(t.places[i].z));
    Cell& whole = out.cells.emplace_back(cell_of(all));
    if (!is_flat(whole, parts)) {
      out.divided.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(out.parts.size())});
      for (const Sums* part : parts) {
        if (part != nullptr) out.parts.emplace_back(cell_of(*part)).mean += centre;
      }
    }
    whole.mean += centre;
  }
  t.clear();
  return out;
}

void CellBuilder::begin(int lidar, int stop, const CellOptions& options) { table_->begin(lidar, stop, options); }

}  // namespace rigcal
