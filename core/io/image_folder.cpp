#include "core/io/image_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <string_view>
#include <tuple>

#include "core/base/parse_number.h"
#include "core/base/text.h"
#include "core/io/frame_files.h"
#include "core/io/recorded_table.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr const char* frames_name = "frames.csv";

constexpr std::array<std::string_view, 8> other_pictures{".bmp", ".tif",  ".tiff", ".pgm",
                                                         ".ppm", ".webp", ".raw",  ".gif"};

/// Whether it is "<digits>.<digits>.png" and so on, as stamps in seconds are written.
bool is_named_by_seconds(const std::string& name) {
  if (!is_image_name(name)) return false;
  const std::string number = fs::path(name).stem().string();
  return std::count(number.begin(), number.end(), '.') == 1 && number.front() != '.' && number.back() != '.' &&
         number.find_first_not_of("0123456789.") == std::string::npos;
}

/// Of a folder; 0 of anything else.
std::size_t images_in(const fs::path& folder) {
  std::error_code error;
  std::size_t count = 0;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error))
    count += is_image_name(file->path().filename().string()) ? 1 : 0;
  return count;
}

/// The number of "<digits>.png" and so on.
std::optional<std::int64_t> number_of(const std::string& name) {
  const std::size_t digits = name.find('.');
  if (!is_image_name(name) || name.find('.', digits + 1) != std::string::npos) return std::nullopt;
  if (name[0] < '0' || name[0] > '9') return std::nullopt;
  return parse_number<std::int64_t>(std::string_view(name).substr(0, digits));
}

/// A session holds the images of a camera in images/<camera>.
std::string session_of(const std::string& path) {
  std::error_code error;
  const fs::path folder = fs::absolute(path, error).lexically_normal();
  return (folder.has_filename() ? folder : folder.parent_path()).parent_path().parent_path().string();
}

}  // namespace

bool is_image_name(const std::string& any_case) {
  const std::string name = small_letters(any_case);
  constexpr std::array<std::string_view, 3> endings{".png", ".jpg", ".jpeg"};
  return std::any_of(endings.begin(), endings.end(), [&](std::string_view ending) { return name.ends_with(ending); });
}

Expected<ImageFolder> list_image_folder(const std::string& path) {
  std::error_code error;
  fs::directory_iterator entries(path, error);
  if (error) return cannot_read(path, error.value());
  std::set<std::string> names;
  for (const fs::directory_entry& entry : entries) names.insert(entry.path().filename().string());
  ImageFolder folder;
  folder.has_frames = names.erase(frames_name) > 0;
  if (folder.has_frames) {
    const std::string file = (fs::path(path) / frames_name).string();
    Expected<RecordedTable> table = read_recorded_table(file, session_of(path));
    if (!table) return table.error();
    folder.torn = std::move(table->torn);
    const Expected<std::vector<FrameRecord>> frames = parse_frames(table->text, file);
    if (!frames) return frames.error();
    for (const FrameRecord& frame : *frames) {
      folder.images.push_back({(fs::path(path) / frame.file).string(), frame.stamp_ns, frame.exposure_us, frame.stop,
                               frame.trigger, frame.device_stamp});
      names.erase(frame.file);
    }
  } else {
    for (auto name = names.begin(); name != names.end();) {
      const std::optional<std::int64_t> number = number_of(*name);
      if (number) folder.images.push_back({(fs::path(path) / *name).string(), *number, {}, {}, {}, {}});
      name = number ? names.erase(name) : std::next(name);
    }
  }
  folder.unknown.assign(names.begin(), names.end());
  std::sort(folder.images.begin(), folder.images.end(), [](const ListedImage& a, const ListedImage& b) {
    return std::tie(a.number, a.path) < std::tie(b.number, b.path);
  });
  return folder;
}

std::string hint_of_unknown(const std::string& path, const ImageFolder& folder) {
  bool has_seconds = false;
  for (const std::string& name : folder.unknown) {
    has_seconds |= !folder.has_frames && is_named_by_seconds(name);
    const std::size_t inside = images_in(fs::path(path) / name);
    if (inside > 0) {
      return "its folder " + name + " holds " + std::to_string(inside) + " images: move them up into " + path;
    }
  }
  if (has_seconds) return "seconds are not read: name them <stamp_ns>.png, or add a frames.csv";
  for (const std::string& name : folder.unknown) {
    const std::string ending = small_letters(fs::path(name).extension().string());
    if (std::find(other_pictures.begin(), other_pictures.end(), ending) != other_pictures.end())
      return "files that end in " + ending + " are not read: make them PNG";
  }
  return {};
}

}  // namespace rigcal
