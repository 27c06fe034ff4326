#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

/// An image file of one camera. Files without a frames.csv are named by one number: `number` is that, a stamp where the
/// recording has times and the number of the stop where it has none.
struct ListedImage {
  std::string path;
  std::int64_t number = 0;  ///< Middle of the exposure, session time, ns; or the stop's number.
  std::optional<double> exposure_us;
  std::optional<int> stop;                   ///< What frames.csv remarks.
  std::optional<std::int64_t> trigger;       ///< As of `FrameRecord`,
  std::optional<std::int64_t> device_stamp;  ///< both.
};

struct ImageFolder {
  std::vector<ListedImage> images;   ///< By `number`, then by path.
  bool has_frames = false;           ///< There is a frames.csv, so the numbers are stamps.
  std::vector<std::string> unknown;  ///< Files that neither frames.csv nor their name tells anything of; sorted.
  std::string torn;                  ///< What of frames.csv was left out, one sentence; empty: nothing.
};

/// Whether it ends as the images do that are read, in small or large letters.
[[nodiscard]] bool is_image_name(const std::string& name);

/// Where images lie or how they are named instead, and the mend, in a clause; empty: nothing of that kind is unknown.
[[nodiscard]] std::string hint_of_unknown(const std::string& path, const ImageFolder& folder);

/// Lists the images of one camera: those of `<path>/frames.csv` (docs/manual.md, "Inputs"), or without it all files
/// named `<number>.png`, `.jpg` or `.jpeg`. Nothing is decoded. Of a session without an end, a last line of frames.csv
/// that is not whole is left out. Errors: no folder, a damaged frames.csv.
[[nodiscard]] Expected<ImageFolder> list_image_folder(const std::string& path);

}  // namespace rigcal
