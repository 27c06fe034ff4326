#include "core/io/file_copy.h"

#include <filesystem>

#include "core/io/input_file.h"
#include "core/io/output_file.h"
#include "core/rig/text_file.h"

namespace rigcal {

// The library's own copying says no more of a full disk than that there was an error.
Expected<void> copy_file(const std::string& from, const std::string& to) {
  std::error_code error;
  if (std::filesystem::is_other(from, error))  // a pipe that waits for ever, a device that has no end
    return input_error("is no regular file", from, "copy it to a file first");
  Expected<InputFile> in = InputFile::open(from);
  if (!in) return in.error();
  Expected<OutputFile> out = OutputFile::create(to);
  if (!out) return out.error();
  constexpr std::size_t part_bytes = std::size_t{256} << 10;
  for (ByteView part = in->take(part_bytes); !part.empty() && out->status(); part = in->take(part_bytes))
    out->write(part);
  if (!in->failure().empty()) return read_failure(from, in->failure());
  return out->close();
}

}  // namespace rigcal
