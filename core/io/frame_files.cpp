#include "core/io/frame_files.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <type_traits>

#include "core/base/text.h"
#include "core/io/csv_table.h"
#include "core/io/output_file.h"
#include "core/rig/rig.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::size_t max_bytes = std::size_t{256} << 20U;
constexpr std::string_view frames_header = "file,stamp_ns,trigger,exposure_us,device_stamp,stop";
constexpr std::string_view trigger_header = "pulse,stamp_ns";
constexpr std::string_view turntable_header = "stamp_ns,angle_deg";
constexpr double most_degrees = 1e6;

// Reads the values of one line; the first that is wrong stays in `error`.
class RowReader {
 public:
  RowReader(const CsvRow& row, const std::string& name) : row_(row), name_(name) {}

  template <class Number>
  Number required(std::size_t column, const char* title) {
    const auto value = row_.number<Number>(column);
    if (!value || *value < Number{}) fail(title, column);
    return value.value_or(Number{});
  }
  template <class Number>
  std::optional<Number> optional(std::size_t column, const char* title) {
    if (row_.values[column].empty()) return std::nullopt;
    const auto value = row_.number<Number>(column);
    if (!value || *value < Number{}) fail(title, column);
    return value;
  }
  void fail(const std::string& what, const std::string& mend) {
    if (!error_) error_ = input_error(what, name_ + ":" + std::to_string(row_.line), mend);
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  void fail(const char* title, std::size_t column) {
    fail(std::string(title) + " is '" + std::string(row_.values[column].substr(0, 40)) + "'",
         "write a number that is not below zero");
  }

  const CsvRow& row_;
  const std::string& name_;
  std::optional<Error> error_;
};

template <class Value>
std::string text_of(const std::optional<Value>& value) {
  if (!value) return {};
  if constexpr (std::is_floating_point_v<Value>) {
    return number_text(*value);
  } else {
    return std::to_string(*value);
  }
}

std::string line_of(const FrameRecord& frame) {
  std::string text = frame.file + "," + std::to_string(frame.stamp_ns);
  for (const std::string& value :
       {text_of(frame.trigger), text_of(frame.exposure_us), text_of(frame.device_stamp), text_of(frame.stop)})
    text.append(",").append(value);
  return text + '\n';
}

std::string line_of(const TriggerPulse& pulse) {
  return std::to_string(pulse.pulse) + "," + std::to_string(pulse.stamp_ns) + "\n";
}

Expected<OutputFile> begin_table(const std::string& path, std::string_view header) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  file->write(std::string(header) + "\n");
  if (const auto written = file->flush(); !written) return written.error();
  return file;
}

// `take` makes a record of a row, or tells the reader what is wrong with it.
template <class Record, class Take>
Expected<std::vector<Record>> parse_table(const std::string& text, std::string_view header, const std::string& name,
                                          std::size_t* good_bytes, const Take& take) {
  const CsvTable table = parse_damaged_csv(text, header, name);
  if (good_bytes != nullptr) *good_bytes = table.good_bytes;
  std::vector<Record> records;
  for (const CsvRow& row : table.rows) {
    RowReader reader(row, name);
    Record record = take(row, reader, records);
    if (reader.error()) {
      if (good_bytes != nullptr) *good_bytes = row.begin;
      return *reader.error();
    }
    records.push_back(std::move(record));
  }
  if (table.error) return *table.error;
  return records;
}

}  // namespace

Expected<std::vector<FrameRecord>> parse_frames(const std::string& text, const std::string& name,
                                                std::size_t* good_bytes) {
  std::set<std::string> files;
  const auto take = [&](const CsvRow& row, RowReader& reader, const std::vector<FrameRecord>&) {
    FrameRecord frame;
    frame.file = std::string(row.values[0]);
    frame.stamp_ns = reader.required<std::int64_t>(1, "stamp_ns");
    frame.trigger = reader.optional<std::int64_t>(2, "trigger");
    frame.exposure_us = reader.optional<double>(3, "exposure_us");
    frame.device_stamp = reader.optional<std::int64_t>(4, "device_stamp");
    frame.stop = reader.optional<int>(5, "stop");
    if (!is_plain_name(frame.file)) {
      reader.fail("the file's name is not plain", "use letters, digits, '_', '-' and '.', and no folder");
    } else if (!files.insert(frame.file).second) {
      reader.fail("the file " + frame.file + " stands here a second time", "keep one of the lines");
    }
    return frame;
  };
  return parse_table<FrameRecord>(text, frames_header, name, good_bytes, take);
}

Expected<std::vector<FrameRecord>> read_frames(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, max_bytes);
  if (!text) return text.error();
  return parse_frames(*text, path);
}

Expected<void> write_frames(const std::string& path, std::span<const FrameRecord> frames) {
  std::string text(frames_header);
  text += '\n';
  for (const FrameRecord& frame : frames) text += line_of(frame);
  return replace_file(path, text);
}

Expected<FrameTable> FrameTable::create(const std::string& path) {
  Expected<OutputFile> file = begin_table(path, frames_header);
  if (!file) return file.error();
  return FrameTable(*std::move(file));
}

Expected<void> FrameTable::add(const FrameRecord& frame) {
  file_.write(line_of(frame));
  return file_.flush();
}

Expected<std::vector<TriggerPulse>> parse_trigger(const std::string& text, const std::string& name,
                                                  std::size_t* good_bytes) {
  const auto take = [](const CsvRow&, RowReader& reader, const std::vector<TriggerPulse>& pulses) {
    const TriggerPulse pulse{reader.required<std::int64_t>(0, "pulse"), reader.required<std::int64_t>(1, "stamp_ns")};
    if (!pulses.empty() && (pulse.pulse <= pulses.back().pulse || pulse.stamp_ns <= pulses.back().stamp_ns))
      reader.fail("the pulse or its stamp does not lie after the one before", "sort the lines, and keep one of each");
    return pulse;
  };
  return parse_table<TriggerPulse>(text, trigger_header, name, good_bytes, take);
}

Expected<std::vector<TriggerPulse>> read_trigger(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, max_bytes);
  if (!text) return text.error();
  return parse_trigger(*text, path);
}

Expected<void> write_trigger(const std::string& path, std::span<const TriggerPulse> pulses) {
  std::string text(trigger_header);
  text += '\n';
  for (const TriggerPulse& pulse : pulses) text += line_of(pulse);
  return replace_file(path, text);
}

Expected<TriggerTable> TriggerTable::create(const std::string& path) {
  Expected<OutputFile> file = begin_table(path, trigger_header);
  if (!file) return file.error();
  return TriggerTable(*std::move(file));
}

Expected<void> TriggerTable::add(const TriggerPulse& pulse) {
  file_.write(line_of(pulse));
  return file_.flush();
}

Expected<std::vector<TableAngle>> parse_turntable(const std::string& text, const std::string& name,
                                                  std::size_t* good_bytes) {
  const auto take = [](const CsvRow& row, RowReader& reader, const std::vector<TableAngle>& angles) {
    const auto stamp_ns = reader.required<std::int64_t>(0, "stamp_ns");
    const std::optional<double> angle = row.number<double>(1);
    if (!angle || std::abs(*angle) > most_degrees)
      reader.fail("angle_deg is '" + std::string(row.values[1].substr(0, 40)) + "'", "write degrees");
    if (!angles.empty() && stamp_ns <= angles.back().stamp_ns)
      reader.fail("the stamp does not lie after the one before", "sort the lines, and keep one of each");
    return TableAngle{stamp_ns, angle.value_or(0.0)};
  };
  return parse_table<TableAngle>(text, turntable_header, name, good_bytes, take);
}

Expected<std::vector<TableAngle>> read_turntable(const std::string& path) {
  const Expected<std::string> text = read_text_file(path, max_bytes);
  if (!text) return text.error();
  return parse_turntable(*text, path);
}

Expected<TurntableTable> TurntableTable::create(const std::string& path) {
  Expected<OutputFile> file = begin_table(path, turntable_header);
  if (!file) return file.error();
  return TurntableTable(*std::move(file));
}

Expected<void> TurntableTable::add(const TableAngle& angle) {
  file_.write(std::to_string(angle.stamp_ns) + "," + number_text(angle.angle_deg) + "\n");
  return file_.flush();
}

}  // namespace rigcal
