#pragma once

#include <cstdint>
#include <string>

#include "apps/recording/recording.h"
#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// What an import has made.
struct ImportSummary {
  std::string kind;             ///< "dump", "lvx", "bag" or "patches".
  bool complete = true;         ///< False: the input was cut; what is whole was taken.
  std::uint64_t datagrams = 0;  ///< Of a dump or an .lvx file,
  std::uint64_t stops = 0;      ///< of the others,
  std::uint64_t points = 0;     ///< of the others,
  std::uint64_t images = 0;     ///< Of the cameras: of a bag, a patch folder, or those that were given.
};

/// Turns a foreign recording into a session, which appears as a whole at the end; an existing path is never touched.
/// Datagrams become lidar.pcapng, every one as it is; bags become the patches of their stops and their images, patch
/// folders are copied. `from.images`, where it is given, has the cameras' images, as calibrate takes them: then these
/// are the session's. The rig file is copied to the letter, unless it does not say of what Bayer layout images are.
/// What is worth telling goes to the reporter, cameras without images included. Errors: no rig, an input that cannot be
/// read or has nothing of this rig, a session (which needs no import), those of `check_images` and `copy_images`, the
/// disk.
[[nodiscard]] Expected<ImportSummary> import_session(const RecordingPaths& from, const std::string& out,
                                                     const RunContext& context);

}  // namespace rigcal
