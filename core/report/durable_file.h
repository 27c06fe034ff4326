#pragma once

#include <string>
#include <string_view>

#include "core/base/error.h"

namespace rigcal {

/// A new file that is on the disk when `close` says so.
class DurableFile {
 public:
  DurableFile() = default;
  ~DurableFile();
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  /// Makes the file; an Error where it exists already.
  [[nodiscard]] Expected<void> create(const std::string& path);
  [[nodiscard]] Expected<void> write(std::string_view bytes);
  /// fsync and close.
  [[nodiscard]] Expected<void> close();

 private:
  std::string path_;
  int descriptor_ = -1;
};

/// Brings the names in a folder to the disk (fsync of the folder).
[[nodiscard]] Expected<void> sync_folder(const std::string& path);

}  // namespace rigcal
