#include "core/voxel/cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/base/radix_sort.h"
#include "core/base/wide.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr std::uint64_t empty_key = ~std::uint64_t{0};

std::size_t hash(std::uint64_t key) { return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20); }

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

// A cell's sixteenths, four by four as the sensor sees it: most cells are hit in a few only.
constexpr std::size_t sixteenths = 16;
constexpr std::uint32_t no_sums = ~std::uint32_t{0};
using SumsNumbers = std::array<std::uint32_t, sixteenths>;

// What tells whether sixteenths lie in one plane: how many points each has, and their middle in the sensor's frame.
// Without values where `hit` has no bit.
struct PartMeans {
  std::uint32_t hit = 0;
  std::array<double, sixteenths> n;
  std::array<Vector3d, sixteenths> mean;

  template <class F>
  void for_each(const F& f) const {
    for (std::uint32_t left = hit; left != 0; left &= left - 1) f(static_cast<std::size_t>(std::countr_zero(left)));
  }

  // Also of what lies behind.
  void add(const PartMeans& behind) {
    behind.for_each([&](std::size_t k) {
      if ((hit >> k & 1U) == 0) {
        n[k] = behind.n[k];
        mean[k] = behind.mean[k];
        return;
      }
      n[k] += behind.n[k];
      mean[k] += behind.n[k] / n[k] * (behind.mean[k] - mean[k]);
    });
    hit |= behind.hit;
  }
};

Cell cell_of(const Sums& s, const Vector3d& centre) {
  Cell cell;
  const double inverse = 1.0 / s.n;
  const double mx = s.vx * inverse;
  const double my = s.vy * inverse;
  const double mz = s.vz * inverse;
  cell.N = s.n;
  cell.mean = Vector3d(mx, my, mz) + centre;
  cell.scatter << s.xx - s.vx * mx, s.xy - s.vx * my, s.xz - s.vx * mz, s.yy - s.vy * my, s.yz - s.vy * mz,
      s.zz - s.vz * mz;
  return cell;
}

// Of two clusters together.
void add_to(Cell& sum, const Cell& part) {
  if (part.N == 0.0) return;
  const double N = sum.N + part.N;
  const Vector3d d = part.mean - sum.mean;
  const double w = sum.N * part.N / N;
  sum.mean += part.N / N * d;
  sum.scatter += part.scatter;
  sum.scatter += w * (Eigen::Matrix<double, 6, 1>() << d.x() * d.x(), d.x() * d.y(), d.x() * d.z(), d.y() * d.y(),
                      d.y() * d.z(), d.z() * d.z())
                         .finished();
  sum.N = N;
}

// What the wire's whole millimetres alone are off by, m^2.
constexpr double rounding_variance = 1e-6 / 12.0;
// Fewer points tell no corner from noise.
constexpr double least_points = 8.0;

// Whether some parts of a cell lie in one plane as far as their own thickness tells: variance between them over
// variance within. Any plane goes through three: those few are told apart rather than judged.
bool is_flat(const Cell& whole, const PartMeans& parts) {
  const auto groups = static_cast<double>(std::popcount(parts.hit));
  if (groups < 2.0 || whole.N < least_points) return true;
  if (groups < 4.0) return false;
  const SymmetricEigen eigen = symmetric_eigen_fast(whole.scatter_matrix());
  const Vector3d u = eigen.vectors.col(0);
  double between = 0.0;
  // One of a few points may be the edge of another surface, as of a wall below a ceiling: it counts too.
  parts.for_each([&](std::size_t k) { between += parts.n[k] * std::pow(u.dot(parts.mean[k] - whole.mean), 2); });
  const double within = std::max(0.0, eigen.values[0] - between) / std::max(1.0, whole.N - groups);
  // Many a flat cell comes out above it, which takes time and no accuracy; with more, corners stay whole
  // (docs/decisions/026).
  const double most_bent = 1.0 + 1.3 * std::sqrt(2.0 / (groups - 3.0));
  return between / (groups - 3.0) <= most_bent * (within + rounding_variance);
}

// As many cells one behind the other may hold one surface; what is met flatter yet has its noise along itself.
constexpr std::size_t most_deep = 4;
// Two halves of a surface's noise are nearer together, and so are the ends of what is seen from aside.
constexpr double most_apart_m = 0.1;

// A cell with its parts.
struct Gathered {
  Cell whole;
  PartMeans parts;
};

// Whether what lies behind goes on where the near cell ends: noise along the ray would share out such a surface between
// both, and take from each the half that is not its own.
bool is_one_surface(const Gathered& near, const Gathered& behind) {
  double common = 0.0;
  double apart = 0.0;
  behind.parts.for_each([&](std::size_t k) {
    if ((near.parts.hit >> k & 1U) == 0) return;
    const double w = std::min(near.parts.n[k], behind.parts.n[k]);
    common += w;
    apart += w * (behind.parts.mean[k] - near.parts.mean[k]).norm();
  });
  if (common > 0.0) return apart < most_apart_m * common;
  return near.whole.N + behind.whole.N < least_points && (behind.whole.mean - near.whole.mean).norm() < most_apart_m;
}

// Points are taken in blocks: what the next ones need is brought from memory while these are added.
constexpr std::size_t block = 128;

template <class Value>
using Each = std::array<Value, block>;

// Of the points of a block, coordinate by coordinate: how they lie before the sensor, and where in their cells.
struct Placed {
  std::array<Each<float>, 3> point;
  Each<double> depth, left, up;
  Each<std::int32_t> face, deep;
  Each<double> across;                       // how many cells side by side fill 45 degrees at that depth
  Each<double> off_ahead, off_left, off_up;  // from the cell's middle
  Each<std::uint64_t> key;
  Each<std::int32_t> part;
  Each<std::int32_t> thin_cube;
};

std::int32_t small_floor_of(double value) {
  const auto whole = static_cast<std::int32_t>(value);
  return whole - static_cast<std::int32_t>(static_cast<double>(whole) > value);
}

// Of what looks left and up in a key: both ways from the middle.
constexpr std::int32_t key_middle = 1 << 19;

// How many cells side by side fill 45 degrees, by how many cells deep they lie: what is one number over a range of
// depths that doubles in two steps. A cell more than points can lie deep.
std::vector<double> cells_across(double max_range_m, double size_m) {
  std::vector<double> across;
  const auto most = static_cast<std::size_t>(max_range_m / size_m) + 2;
  double end = 1.0;
  for (std::size_t k = 0; k < most; ++k) {
    while (static_cast<double>(k) >= std::round(end)) end *= std::numbers::sqrt2;
    across.push_back(std::round(end));
  }
  return across;
}

constexpr int thin_across = 8;
constexpr int thin_deep = 10;

// For all of the block, however many points it has. Along its greatest coordinate a point lies ahead; left and up are
// the two that follow.
RIGCAL_WIDE void place_by_depth(double size_m, Placed& at) {
  const double inverse = 1.0 / size_m;
  const float* const xs = at.point[0].data();
  const float* const ys = at.point[1].data();
  const float* const zs = at.point[2].data();
  for (std::size_t i = 0; i < block; ++i) {
    const double x = xs[i];
    const double y = ys[i];
    const double z = zs[i];
    const double ax = std::abs(x);
    const double ay = std::abs(y);
    const double az = std::abs(z);
    const double of_yz = az > ay ? az : ay;
    const double depth = of_yz > ax ? of_yz : ax;
    // x before y before z where two are the same.
    double ahead = ay == depth ? y : z;
    double left = ay == depth ? z : x;
    double up = ay == depth ? x : y;
    std::int32_t face = ay == depth ? 2 : 4;
    ahead = ax == depth ? x : ahead;
    left = ax == depth ? y : left;
    up = ax == depth ? z : up;
    face = ax == depth ? 0 : face;
    at.depth[i] = depth;
    at.left[i] = left;
    at.up[i] = up;
    at.deep[i] = static_cast<std::int32_t>(depth * inverse);
    at.face[i] = face + (ahead < 0.0 ? 1 : 0);
  }
}

// Where the cells of their depth are `across` as many.
RIGCAL_WIDE void place_in_cells(double size_m, Placed& at) {
  const double inverse = 1.0 / size_m;
  for (std::size_t i = 0; i < block; ++i) {
    const double depth = at.depth[i];
    const double across = at.across[i];
    const double deep = at.deep[i];
    const double scale = across / std::max(depth, 1e-9);
    const double inside = across * (1.0 - 1e-12);
    const double u = std::min(at.left[i] * scale, inside);
    const double v = std::min(at.up[i] * scale, inside);
    const std::int32_t iu = small_floor_of(u);
    const std::int32_t iv = small_floor_of(v);
    const double fu = u - static_cast<double>(iu);
    const double fv = v - static_cast<double>(iv);
    const double fd = depth * inverse - deep;
    const double middle = (deep + 0.5) * size_m;
    const double step = middle / across;
    at.off_ahead[i] = depth - middle;
    at.off_left[i] = at.left[i] - (static_cast<double>(iu) + 0.5) * step;
    at.off_up[i] = at.up[i] - (static_cast<double>(iv) + 0.5) * step;
    at.key[i] = static_cast<std::uint64_t>(at.face[i]) << 60 | static_cast<std::uint64_t>(iu + key_middle) << 40 |
                static_cast<std::uint64_t>(iv + key_middle) << 20 | static_cast<std::uint64_t>(at.deep[i]);
    at.part[i] = static_cast<std::int32_t>(4.0 * fu) * 4 + static_cast<std::int32_t>(4.0 * fv);
    at.thin_cube[i] =
        (static_cast<std::int32_t>(thin_across * fu) * thin_across + static_cast<std::int32_t>(thin_across * fv)) *
            thin_deep +
        static_cast<std::int32_t>(thin_deep * fd);
  }
}
// Which of the six ways a cell's points lie ahead: along x, y or z, and against them.
int face_of(std::uint64_t key) { return static_cast<int>(key >> 60); }

// The middle of a cell, from its key.
Vector3d centre_of(std::uint64_t key, double size_m, const std::vector<double>& across_at) {
  const int face = face_of(key);
  const auto deep = static_cast<std::size_t>(key & 0xFFFFF);
  const double middle = (static_cast<double>(deep) + 0.5) * size_m;
  const double step = middle / across_at[deep];
  const auto index = [&](int shift) {
    return static_cast<double>(static_cast<std::int32_t>(key >> shift & 0xFFFFF) - key_middle);
  };
  const double left = (index(40) + 0.5) * step;
  const double up = (index(20) + 0.5) * step;
  const double ahead = face % 2 == 1 ? -middle : middle;
  switch (face / 2) {
    case 0:
      return {ahead, left, up};
    case 1:
      return {up, ahead, left};
    default:
      return {left, up, ahead};
  }
}

// Sums were of what lies ahead, left and up; they become those of x, y and z.
Sums in_sensor(Sums s, int face) {
  if (face % 2 == 1) {
    s.vx = -s.vx;
    s.xy = -s.xy;
    s.xz = -s.xz;
  }
  switch (face / 2) {
    case 0:
      return s;
    case 1:
      return {s.n, s.vz, s.vx, s.vy, s.zz, s.xz, s.yz, s.xx, s.xy, s.yy};
    default:
      return {s.n, s.vy, s.vz, s.vx, s.yy, s.yz, s.xy, s.zz, s.xz, s.xx};
  }
}

}  // namespace

struct CellBuilder::Table {
  // A cell's key, and which one it is.
  struct Keyed {
    std::uint64_t key = empty_key;
    std::uint32_t index = 0;
  };

  int lidar = 0;
  int stop = 0;
  CellOptions options;
  std::uint64_t points = 0;
  std::vector<Keyed> slots;    // open addressing, a power of two
  std::vector<double> across;  // see cells_across
  std::vector<std::uint64_t> keys;
  std::vector<SumsNumbers> sums_of;  // of each cell
  std::vector<Sums> sums;
  std::vector<Point> thinned;
  std::vector<std::array<std::uint64_t, thin_across * thin_across * thin_deep / 64>>
      thin_bits;  // a bit for each 2 cm cube of a cell
  Placed placed{};

  Table() : slots(1 << 12) {}

  void begin(int lidar_index, int stop_index, const CellOptions& cell_options) {
    lidar = lidar_index;
    stop = stop_index;
    options = cell_options;
    across = cells_across(options.max_range_m, options.size_m);
    clear();
  }

  // The memory stays, but for what is given away.
  void clear() {
    points = 0;
    std::fill(slots.begin(), slots.end(), Keyed{});
    keys.clear();
    sums_of.clear();
    sums.clear();
    thinned = {};
    thin_bits.clear();
  }

  [[nodiscard]] std::size_t first_slot(std::uint64_t key) const { return hash(key) & (slots.size() - 1); }

  void grow() {
    std::vector<Keyed> old(slots.size() * 2);
    old.swap(slots);
    for (const Keyed& slot : old) {
      if (slot.key == empty_key) continue;
      std::size_t at = first_slot(slot.key);
      while (slots[at].key != empty_key) at = (at + 1) & (slots.size() - 1);
      slots[at] = slot;
    }
  }

  std::uint32_t find_or_add(std::uint64_t key) {
    std::size_t at = first_slot(key);
    while (slots[at].key != empty_key) {
      if (slots[at].key == key) return slots[at].index;
      at = (at + 1) & (slots.size() - 1);
    }
    const auto index = static_cast<std::uint32_t>(keys.size());
    sums_of.emplace_back().fill(no_sums);
    keys.push_back(key);
    if (options.keep_thinned) thin_bits.emplace_back().fill(0);
    slots[at] = {key, index};
    if (keys.size() * 2 > slots.size()) grow();
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
    std::array<std::uint32_t, block> part;
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
    place_by_depth(options.size_m, placed);
    for (std::size_t i = 0; i < block; ++i) placed.across[i] = across[static_cast<std::size_t>(placed.deep[i])];
    place_in_cells(options.size_m, placed);
    for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&slots[first_slot(placed.key[i])]);
    for (std::size_t i = 0; i < count; ++i) {
      index[i] = i > 0 && placed.key[i] == placed.key[i - 1] ? index[i - 1] : find_or_add(placed.key[i]);
      __builtin_prefetch(&sums_of[index[i]][static_cast<std::size_t>(placed.part[i])], 1);
      if (options.keep_thinned) __builtin_prefetch(&thin_word(index[i], placed.thin_cube[i]), 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t& number = sums_of[index[i]][static_cast<std::size_t>(placed.part[i])];
      if (number == no_sums) {
        number = static_cast<std::uint32_t>(sums.size());
        sums.emplace_back();
      }
      part[i] = number;
      __builtin_prefetch(&sums[number], 1);
      __builtin_prefetch(&sums[number].zz, 1);
    }
    for (std::size_t i = 0; i < count; ++i) add(i, sums[part[i]]);
    if (options.keep_thinned) {
      for (std::size_t i = 0; i < count; ++i) thin(*near[i], index[i], placed.thin_cube[i]);
    }
    points += count;
  }

  void add(std::size_t i, Sums& s) const {
    const double x = placed.off_ahead[i];
    const double y = placed.off_left[i];
    const double z = placed.off_up[i];
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

  void gather(std::uint32_t cell, Gathered& out) const {
    const Vector3d centre = centre_of(keys[cell], options.size_m, across);
    const int face = face_of(keys[cell]);
    Sums all;
    out.parts.hit = 0;
    for (std::size_t k = 0; k < sixteenths; ++k) {
      const std::uint32_t number = sums_of[cell][k];
      if (number == no_sums) continue;
      const Sums s = in_sensor(sums[number], face);
      all += s;
      out.parts.hit |= 1U << k;
      out.parts.n[k] = s.n;
      out.parts.mean[k] = Vector3d(s.vx, s.vy, s.vz) / s.n + centre;
    }
    out.whole = cell_of(all, centre);
  }

  // One sixteenth of some cells that lie one behind the other; no points where nothing was hit.
  [[nodiscard]] Cell part_of(std::span<const Keyed> cells, std::size_t k) const {
    Cell part;
    for (const Keyed& cell : cells) {
      const std::uint32_t number = sums_of[cell.index][k];
      if (number == no_sums) continue;
      add_to(part, cell_of(in_sensor(sums[number], face_of(cell.key)), centre_of(cell.key, options.size_m, across)));
    }
    return part;
  }

  // Those of a cell that is not flat: quarters that are, and the sixteenths of the others.
  void divide(std::span<const Keyed> cells, std::vector<Cell>& out) const {
    for (std::size_t quarter = 0; quarter < 4; ++quarter) {
      const std::size_t first = (quarter / 2) * 8 + (quarter % 2) * 2;
      std::array<Cell, 4> four;
      PartMeans means;
      Cell sum;
      for (std::size_t i = 0; i < 4; ++i) {
        four[i] = part_of(cells, first + (i / 2) * 4 + i % 2);
        if (four[i].N == 0.0) continue;
        means.hit |= 1U << i;
        means.n[i] = four[i].N;
        means.mean[i] = four[i].mean;
        add_to(sum, four[i]);
      }
      if (sum.N == 0.0) continue;
      if (is_flat(sum, means)) {
        out.push_back(sum);
        continue;
      }
      for (const Cell& one : four) {
        if (one.N > 0.0) out.push_back(one);
      }
    }
  }

  // Of cells that are gathered soon: they lie all over the memory.
  void prefetch(std::uint32_t cell) const {
    for (const std::uint32_t number : sums_of[cell]) {
      if (number == no_sums) continue;
      __builtin_prefetch(&sums[number]);
      __builtin_prefetch(&sums[number].zz);
    }
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
  out.cells.reserve(t.keys.size());
  std::vector<Table::Keyed> order(t.keys.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = {t.keys[i], i};
  radix_sort(order);
  constexpr std::size_t soon = 4;
  constexpr std::size_t later = 12;
  Gathered all;
  Gathered behind;
  for (std::size_t i = 0; i < order.size();) {
    if (i + later < order.size()) __builtin_prefetch(&t.sums_of[order[i + later].index]);
    if (i + soon < order.size()) t.prefetch(order[i + soon].index);
    t.gather(order[i].index, all);
    std::size_t end = i + 1;
    for (; end < order.size() && end < i + most_deep && order[end].key == order[end - 1].key + 1; ++end) {
      t.gather(order[end].index, behind);
      if (!is_one_surface(all, behind)) break;
      all.parts.add(behind.parts);
      add_to(all.whole, behind.whole);
    }
    const std::span<const Table::Keyed> cells = std::span(order).subspan(i, end - i);
    i = end;
    out.cells.push_back(all.whole);
    if (is_flat(all.whole, all.parts)) continue;
    out.divided.push_back(
        {static_cast<std::uint32_t>(out.cells.size() - 1), static_cast<std::uint32_t>(out.parts.size())});
    t.divide(cells, out.parts);
  }
  t.clear();
  return out;
}

void CellBuilder::begin(int lidar, int stop, const CellOptions& options) { table_->begin(lidar, stop, options); }

}  // namespace rigcal
