#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

enum class PcdEncoding { ascii, binary, binary_compressed };

/// A column of a PCD file.
struct PcdField {
  std::string name;
  char type = 'F';         ///< F, I or U.
  std::size_t size = 4;    ///< Bytes of one value.
  std::size_t count = 1;   ///< Values a point.
  std::size_t offset = 0;  ///< Of the first value in a point, in bytes.
  std::size_t column = 0;  ///< Of the first value in a line of an ASCII file.
};

/// The header of a PCD file (version .7).
struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint64_t points = 0;
  bool size_missing = false;  ///< WIDTH or HEIGHT is 0 although there are points, as some recorders write it.
  PcdEncoding encoding = PcdEncoding::ascii;
  std::size_t point_bytes = 0;
  std::size_t columns = 0;  ///< Values in a line of an ASCII file.
  int lines = 0;            ///< Lines of the header.
  bool moved = false;       ///< VIEWPOINT is another pose than the sensor's own.

  /// The first field that has one of the names, or null.
  [[nodiscard]] const PcdField* find(std::initializer_list<std::string_view> names) const;
};

/// Reads a header line by line, the DATA line last.
class PcdHeaderParser {
 public:
  explicit PcdHeaderParser(std::string file) : file_(std::move(file)) {}

  /// Takes one line without its end. True after the DATA line: then `header()` is whole and checked.
  [[nodiscard]] Expected<bool> take(std::string_view line);
  [[nodiscard]] const PcdHeader& header() const { return header_; }

 private:
  [[nodiscard]] Error wrong(
      std::string what,
      std::string mend = "correct the header, or save the cloud anew as a PCD file, version 0.7") const;
  [[nodiscard]] Error wrong_at(int line, std::string what, std::string mend) const;
  [[nodiscard]] Expected<void> take_list(std::string_view key, const std::vector<std::string_view>& words);
  [[nodiscard]] Expected<void> check_coordinates() const;
  [[nodiscard]] Expected<bool> finish(const std::vector<std::string_view>& words);

  std::string file_;
  PcdHeader header_;
  std::vector<std::uint64_t> sizes_;
  std::vector<char> types_;
  std::vector<std::uint64_t> counts_;
  std::uint64_t width_ = 0;
  std::uint64_t height_ = 1;
  bool has_width_ = false;
  bool has_points_ = false;
  int fields_line_ = 0;
  int types_line_ = 0;
};

}  // namespace rigcal
