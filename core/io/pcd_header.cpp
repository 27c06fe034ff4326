#include "core/io/pcd_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "core/base/parse_number.h"

namespace rigcal {
namespace {

constexpr std::size_t max_fields = 256;
constexpr std::uint64_t max_count = 4096;
/// More points than any disk holds; keeps products of sizes far from overflow.
constexpr std::uint64_t max_points = std::uint64_t{1} << 40;

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while (true) {
    at = line.find_first_not_of(" \t\r", at);
    if (at == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
}

bool parse_all(const std::vector<std::string_view>& words, std::vector<std::uint64_t>& values) {
  values.assign(words.size() - 1, 0);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto value = parse_number<std::uint64_t>(words[i]);
    if (!value) return false;
    values[i - 1] = *value;
  }
  return true;
}

/// Of "VIEWPOINT tx ty tz qw qx qy qz"; what is no such line says nothing.
bool is_moved(const std::vector<std::string_view>& words) {
  constexpr std::array<double, 7> identity{0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  if (words.size() != identity.size() + 1) return false;
  bool moved = false;
  for (std::size_t i = 0; i < identity.size(); ++i) {
    double value = 0.0;
    const std::string_view word = words[i + 1];
    if (std::from_chars(word.data(), word.data() + word.size(), value).ec != std::errc{}) return false;
    // A quaternion and its opposite are the same turn.
    moved |= std::abs((i == 3 ? std::abs(value) : value) - identity[i]) > 1e-9;
  }
  return moved;
}

}  // namespace

const PcdField* PcdHeader::find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    for (const PcdField& field : fields) {
      if (field.name == name) return &field;
    }
  }
  return nullptr;
}

Error PcdHeaderParser::wrong(std::string what, std::string mend) const {
  return wrong_at(header_.lines, std::move(what), std::move(mend));
}

Error PcdHeaderParser::wrong_at(int line, std::string what, std::string mend) const {
  return input_error(std::move(what), file_ + ":" + std::to_string(line), std::move(mend));
}

Expected<bool> PcdHeaderParser::take(std::string_view line) {
  ++header_.lines;
  const std::vector<std::string_view> words = split(line);
  if (words.empty() || words[0].front() == '#') return false;
  if (words[0] == "DATA") return finish(words);
  const Expected<void> taken = take_list(words[0], words);
  if (!taken) return taken.error();
  return false;
}

Expected<void> PcdHeaderParser::take_list(std::string_view key, const std::vector<std::string_view>& words) {
  if (words.size() > max_fields + 1) return wrong("has more than " + std::to_string(max_fields) + " fields");
  if (key == "VERSION") return {};
  if (key == "VIEWPOINT") {
    header_.moved = is_moved(words);
    return {};
  }
  if (key == "FIELDS" || key == "COLUMNS") {
    header_.fields.clear();
    fields_line_ = header_.lines;
    for (std::size_t i = 1; i < words.size(); ++i) {
      PcdField field;
      field.name = std::string(words[i]);
      header_.fields.push_back(std::move(field));
    }
    return {};
  }
  if (key == "TYPE") {
    types_.clear();
    types_line_ = header_.lines;
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (words[i] != "F" && words[i] != "I" && words[i] != "U") return wrong("has a TYPE that is not F, I or U");
      types_.push_back(words[i].front());
    }
    return {};
  }
  if (key == "SIZE" || key == "COUNT") {
    if (!parse_all(words, key == "SIZE" ? sizes_ : counts_))
      return wrong(std::string(key) + " is not a list of numbers");
    return {};
  }
  if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
    const auto value = parse_number<std::uint64_t>(words.size() == 2 ? words[1] : std::string_view());
    if (!value || *value > max_points) {
      return wrong(std::string(key) + " is no possible number");
    }
    if (key == "WIDTH") has_width_ = true;
    if (key == "POINTS") has_points_ = true;
    (key == "WIDTH" ? width_ : (key == "HEIGHT" ? height_ : header_.points)) = *value;
    return {};
  }
  return wrong("is no PCD file: its header has a line that does not belong there", "give a .pcd file, version 0.7");
}

Expected<void> PcdHeaderParser::check_coordinates() const {
  for (const char* name : {"x", "y", "z"}) {
    const PcdField* field = header_.find({name});
    if (field == nullptr) {
      return wrong_at(fields_line_, std::string("FIELDS has no ") + name,
                      "a cloud needs x, y and z, metres in the sensor's frame");
    }
    if (field->type != 'F') {
      return wrong_at(types_line_, std::string("the field ") + name + " is of TYPE " + field->type + ", not F",
                      "write x, y and z as floats, in metres");
    }
  }
  return {};
}

Expected<bool> PcdHeaderParser::finish(const std::vector<std::string_view>& words) {
  if (words.size() == 2 && words[1] == "ascii") {
    header_.encoding = PcdEncoding::ascii;
  } else if (words.size() == 2 && words[1] == "binary") {
    header_.encoding = PcdEncoding::binary;
  } else if (words.size() == 2 && words[1] == "binary_compressed") {
    header_.encoding = PcdEncoding::binary_compressed;
  } else {
    return wrong("DATA is not ascii, binary or binary_compressed");
  }
  const std::size_t count = header_.fields.size();
  if (count == 0) return wrong("has no FIELDS before DATA");
  if (counts_.empty()) counts_.assign(count, 1);
  if (sizes_.size() != count || types_.size() != count || counts_.size() != count) {
    return wrong("FIELDS, SIZE, TYPE and COUNT differ in length");
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    PcdField& field = header_.fields[i];
    const bool possible = sizes_[i] == 4 || sizes_[i] == 8 || (types_[i] != 'F' && (sizes_[i] == 1 || sizes_[i] == 2));
    if (!possible) return wrong("SIZE " + std::to_string(sizes_[i]) + " does not go with TYPE " + types_[i]);
    if (counts_[i] == 0 || counts_[i] > max_count) return wrong("COUNT is out of the range 1 to 4096");
    if (field.name != "_" && !names.insert(field.name).second) return wrong("has two fields of one name");
    field.type = types_[i];
    field.size = static_cast<std::size_t>(sizes_[i]);
    field.count = static_cast<std::size_t>(counts_[i]);
    field.offset = header_.point_bytes;
    field.column = header_.columns;
    header_.point_bytes += field.size * field.count;
    header_.columns += field.count;
  }
  if (const Expected<void> there = check_coordinates(); !there) return there.error();
  if (!has_points_ && !has_width_) return wrong("has neither POINTS nor WIDTH");
  const bool too_many = height_ > 0 && width_ > max_points / height_;
  const std::uint64_t product = too_many ? max_points + 1 : width_ * height_;
  if (!has_points_) header_.points = product;
  header_.size_missing = product == 0 && header_.points > 0;
  if ((product != header_.points && !header_.size_missing) || header_.points > max_points) {
    return wrong("WIDTH times HEIGHT is not POINTS");
  }
  return true;
}

}  // namespace rigcal
