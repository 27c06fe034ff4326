#include "core/io/pcd_file.h"

#include <lzf.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "core/base/seconds.h"
#include "core/io/output_file.h"
#include "core/io/pcd_header.h"
#include "core/io/point_values.h"
#include "core/io/random_access_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
constexpr std::size_t chunk_points = 16384;
constexpr std::size_t max_header_line = 16384;
constexpr int max_header_lines = 1000;

/// Gathers points, leaves out what is no return, and hands on full chunks.
class Collector {
 public:
  explicit Collector(const std::function<void(std::span<const Point>)>& take) : take_(take) {
    chunk_.reserve(chunk_points);
  }

  void add(const Point& point) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) {
      ++summary_.not_finite;
    } else if (point.x == 0.0F && point.y == 0.0F && point.z == 0.0F) {
      ++summary_.at_origin;
    } else {
      chunk_.push_back(point);
      if (chunk_.size() == chunk_points) flush();
    }
  }
  void flush() {
    summary_.points += chunk_.size();
    if (!chunk_.empty()) take_(chunk_);
    chunk_.clear();
  }
  [[nodiscard]] PcdSummary& summary() { return summary_; }

 private:
  const std::function<void(std::span<const Point>)>& take_;
  std::vector<Point> chunk_;
  PcdSummary summary_;
};

/// The fields that make up a Point.
struct PointFields {
  const PcdField* x;
  const PcdField* y;
  const PcdField* z;
  const PcdField* reflectivity;
  const PcdField* tag;
  const PcdField* ring;

  explicit PointFields(const PcdHeader& header)
      : x(header.find({"x"})),
        y(header.find({"y"})),
        z(header.find({"z"})),
        reflectivity(header.find({"reflectivity", "intensity"})),
        tag(header.find({"tag"})),
        ring(header.find({"ring", "line"})) {}

  /// Whether the fields are of the types that rigcal and most other programs write: then `assemble_usual` gives the
  /// same, and sooner.
  [[nodiscard]] bool are_usual() const {
    const auto is = [](const PcdField* field, char type, std::size_t size) {
      return field != nullptr && field->type == type && field->size == size;
    };
    return is(x, 'F', 4) && is(y, 'F', 4) && is(z, 'F', 4) && is(reflectivity, 'F', 4) && is(tag, 'U', 1) &&
           ring == nullptr;
  }
  [[nodiscard]] Point assemble_usual(const std::uint8_t* at, IntensityRange& intensity) const {
    Point point;
    std::memcpy(&point.x, at + x->offset, sizeof(float));
    std::memcpy(&point.y, at + y->offset, sizeof(float));
    std::memcpy(&point.z, at + z->offset, sizeof(float));
    const double value = load_value<float>(at + reflectivity->offset);
    intensity.add(value);
    point.reflectivity = rounded<std::uint8_t>(value);
    point.tag = at[tag->offset];
    return point;
  }

  /// `value(field)` gives the number of a field, `x`, `y` and `z` come as doubles.
  template <class Value>
  [[nodiscard]] Point assemble(const Value& value, IntensityRange& intensity) const {
    Point point;
    point.x = to_float(value(*x));
    point.y = to_float(value(*y));
    point.z = to_float(value(*z));
    if (reflectivity != nullptr) {
      intensity.add(value(*reflectivity));
      point.reflectivity = rounded<std::uint8_t>(value(*reflectivity));
    }
    if (tag != nullptr) point.tag = rounded<std::uint8_t>(value(*tag));
    if (ring != nullptr) point.shot = rounded<std::uint16_t>(value(*ring));
    return point;
  }
};

class PcdReader {
 public:
  PcdReader(std::string path, File file, std::uint64_t file_bytes)
      : path_(std::move(path)), file_(std::move(file)), file_bytes_(file_bytes), parser_(path_) {}

  Expected<PcdSummary> read(Collector& out) {
    Expected<void> done = read_header();
    if (!done) return done.error();
    const PointFields fields(header());
    out.summary().has_reflectivity = fields.reflectivity != nullptr;
    out.summary().has_ring = fields.ring != nullptr;
    out.summary().size_missing = header().size_missing;
    out.summary().moved = header().moved;
    if (header().encoding == PcdEncoding::ascii) done = read_ascii(fields, out);
    if (header().encoding == PcdEncoding::binary) done = read_binary(fields, out);
    if (header().encoding == PcdEncoding::binary_compressed) done = read_compressed(fields, out);
    if (!done) return done.error();
    out.flush();
    return out.summary();
  }

 private:
  [[nodiscard]] const PcdHeader& header() const { return parser_.header(); }

  [[nodiscard]] Error too_short(std::uint64_t found) const {
    return input_error("promises " + std::to_string(header().points) + " points, but holds " + std::to_string(found),
                       path_, "copy or record it again");
  }

  /// A line without its end; nothing at the end of the file, and `too_long_` set where it does not fit.
  [[nodiscard]] std::optional<std::string_view> read_line() {
    if (std::fgets(line_.data(), static_cast<int>(line_.size()), file_.get()) == nullptr) return std::nullopt;
    std::size_t length = std::strlen(line_.data());
    too_long_ = length + 1 == line_.size();
    while (length > 0 && (line_[length - 1] == '\n' || line_[length - 1] == '\r')) --length;
    return std::string_view(line_.data(), length);
  }

  Expected<void> read_header() {
    while (const std::optional<std::string_view> line = read_line()) {
      if (too_long_ || header().lines >= max_header_lines) break;
      const Expected<bool> last = parser_.take(*line);
      if (!last) return last.error();
      if (*last) return {};
    }
    return input_error("is no PCD file: it has no DATA line", path_, "give a .pcd file, version 0.7");
  }

  [[nodiscard]] std::uint64_t bytes_left() const {
    const long at = std::ftell(file_.get());
    return at < 0 || static_cast<std::uint64_t>(at) > file_bytes_ ? 0 : file_bytes_ - static_cast<std::uint64_t>(at);
  }

  Expected<void> read_ascii(const PointFields& fields, Collector& out) {
    std::vector<double> values(header().columns);
    std::uint64_t line_number = static_cast<std::uint64_t>(header().lines);
    std::uint64_t found = 0;
    while (found < header().points) {
      const std::optional<std::string_view> line = read_line();
      if (!line) return too_short(found);
      ++line_number;
      const std::size_t count = parse_values(*line, values);
      if (count == 0 && line->find_first_not_of(" \t") == std::string_view::npos) continue;
      if (too_long_ || count != values.size()) {
        return input_error("has no " + std::to_string(values.size()) + " numbers",
                           path_ + ":" + std::to_string(line_number), "copy or record it again");
      }
      out.add(fields.assemble([&](const PcdField& field) { return values[field.column]; }, out.summary().intensity));
      ++found;
    }
    return {};
  }

  /// How many numbers from the front of the line could be read.
  static std::size_t parse_values(std::string_view line, std::vector<double>& values) {
    const char* at = line.data();
    const char* const end = at + line.size();
    for (std::size_t i = 0; i < values.size(); ++i) {
      while (at != end && (*at == ' ' || *at == '\t')) ++at;
      if (at != end && *at == '+') ++at;
      const auto [rest, code] = std::from_chars(at, end, values[i]);
      if (code == std::errc::invalid_argument) return i;
      if (code == std::errc::result_out_of_range) values[i] = std::numeric_limits<double>::quiet_NaN();
      if (rest != end && *rest != ' ' && *rest != '\t') return i;
      at = rest;
    }
    return values.size();
  }

  Expected<void> read_binary(const PointFields& fields, Collector& out) {
    const std::size_t step = header().point_bytes;
    if (header().points > bytes_left() / step) return too_short(bytes_left() / step);
    // A chunk of at least one point and about a MiB.
    const std::uint64_t points_a_chunk = std::max<std::uint64_t>(1, (std::uint64_t{1} << 20) / step);
    std::vector<std::uint8_t> chunk;
    const bool usual = fields.are_usual();
    for (std::uint64_t done = 0; done < header().points;) {
      const auto count = static_cast<std::size_t>(std::min(points_a_chunk, header().points - done));
      chunk.resize(count * step);
      if (std::fread(chunk.data(), step, count, file_.get()) != count) return too_short(done);
      if (usual) {
        IntensityRange intensity;  // of its own, so that it stays in registers
        for (std::size_t i = 0; i < count; ++i) out.add(fields.assemble_usual(chunk.data() + i * step, intensity));
        out.summary().intensity.add(intensity);
        done += count;
        continue;
      }
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* at = chunk.data() + i * step;
        out.add(fields.assemble([&](const PcdField& f) { return load_value(at + f.offset, f.type, f.size); },
                                out.summary().intensity));
      }
      done += count;
    }
    return {};
  }

  /// Compressed files hold all values of a field together, and one field after the other.
  Expected<void> read_compressed(const PointFields& fields, Collector& out) {
    if (header().points == 0) return {};
    std::array<std::uint32_t, 2> sizes{};
    if (std::fread(sizes.data(), sizeof(sizes), 1, file_.get()) != 1) return too_short(0);
    const auto [packed_bytes, bytes] = sizes;
    const std::uint64_t wanted = header().points * header().point_bytes;
    if (bytes != wanted) {
      return input_error(
          "its compressed part says " + std::to_string(bytes) + " bytes, but its points take " + std::to_string(wanted),
          path_, "copy or record it again");
    }
    if (packed_bytes > bytes_left()) return too_short(0);
    // LZF stores at most 264 bytes in 3: what claims more is no LZF, and is not given the memory.
    if (packed_bytes == 0 || bytes / 88 > packed_bytes) return damaged();
    std::vector<std::uint8_t> packed(packed_bytes);
    if (std::fread(packed.data(), 1, packed.size(), file_.get()) != packed.size()) return too_short(0);
    std::vector<std::uint8_t> values(bytes);
    if (lzf_decompress(packed.data(), packed_bytes, values.data(), bytes) != bytes) return damaged();
    const auto points = static_cast<std::size_t>(header().points);
    for (std::size_t i = 0; i < points; ++i) {
      const auto value = [&](const PcdField& f) {
        return load_value(values.data() + points * f.offset + i * f.size * f.count, f.type, f.size);
      };
      out.add(fields.assemble(value, out.summary().intensity));
    }
    return {};
  }

  [[nodiscard]] Error damaged() const {
    return input_error("its compressed part is damaged", path_, "copy or record it again");
  }

  std::string path_;
  File file_;
  std::uint64_t file_bytes_;
  PcdHeaderParser parser_;
  std::array<char, max_header_line> line_{};
  bool too_long_ = false;
};

/// As long for every number of points, so that it can be written again over itself.
std::string binary_header(std::uint64_t points, PcdColumns columns) {
  std::string count = std::to_string(points);
  count.resize(20, ' ');
  const auto line = [&](const char* usual, const char* ring, const char* timestamp) {
    return std::string(usual) + (columns.ring ? ring : "") + (columns.timestamp ? timestamp : "");
  };
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7" +
         line("\nFIELDS x y z intensity tag", " ring", " timestamp") + line("\nSIZE 4 4 4 4 1", " 2", " 8") +
         line("\nTYPE F F F F U", " U", " F") + line("\nCOUNT 1 1 1 1 1", " 1", " 1") + "\nWIDTH " + count +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
}

}  // namespace

Expected<PcdSummary> read_pcd(const std::string& path, const std::function<void(std::span<const Point>)>& take) {
  Expected<RandomAccessFile> opened = RandomAccessFile::open(path);
  if (!opened) return opened.error();
  FileDescriptor descriptor = std::move(*opened).release();
  File file(::fdopen(descriptor.get(), "rb"), &std::fclose);
  if (!file) return cannot_read(path, errno);
  static_cast<void>(descriptor.release());  // The stream closes it.
  Collector collector(take);
  return PcdReader(path, std::move(file), opened->size()).read(collector);
}

Expected<PcdCloud> read_pcd(const std::string& path) {
  PcdCloud cloud;
  const Expected<PcdSummary> summary = read_pcd(
      path, [&](std::span<const Point> chunk) { cloud.points.insert(cloud.points.end(), chunk.begin(), chunk.end()); });
  if (!summary) return summary.error();
  cloud.summary = *summary;
  return cloud;
}

Expected<PcdWriter> PcdWriter::create(const std::string& path, PcdColumns columns) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  PcdWriter writer(std::move(*file), columns);
  writer.file_.write(binary_header(0, columns));
  return writer;
}

void PcdWriter::write(std::span<const Point> points, std::int64_t stamp_ns, double shot_interval_ns) {
  const std::size_t size =
      4 * sizeof(float) + 1 + (columns_.ring ? sizeof(Point::shot) : 0) + (columns_.timestamp ? sizeof(double) : 0);
  for (const Point& point : points) {
    const std::array<float, 4> values{point.x, point.y, point.z, static_cast<float>(point.reflectivity)};
    std::uint8_t* room = file_.reserve(size);
    std::memcpy(room, values.data(), sizeof(values));
    room += sizeof(values);
    *room++ = point.tag;
    if (columns_.ring) {
      std::memcpy(room, &point.shot, sizeof(point.shot));
      room += sizeof(point.shot);
    }
    if (!columns_.timestamp) continue;
    const std::int64_t time_ns = stamp_ns + static_cast<std::int64_t>(point.shot * shot_interval_ns);
    const double time_s = seconds_of_ns(time_ns);
    std::memcpy(room, &time_s, sizeof(time_s));
  }
  points_ += points.size();
}

Expected<void> PcdWriter::finish() {
  file_.overwrite(0, binary_header(points_, columns_));
  return file_.close();
}

Expected<void> write_pcd(const std::string& path, std::span<const Point> points) {
  Expected<PcdWriter> writer = PcdWriter::create(path);
  if (!writer) return writer.error();
  writer->write(points);
  return writer->finish();
}

}  // namespace rigcal
