#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

/// What the numbers that name images without a frames.csv are.
enum class ImageNumbers { stamps, stops };

/// Copies the images of the rig's cameras, which lie in `from` as in a session, into the images/ of a session, byte for
/// byte. Each camera gets a frames.csv, unless nothing but their stops is known of its images. `stops`, where there are
/// any: those of a recording whose session will not know their times; frames.csv then has the stop of each image.
/// Returns how many there are. What is left out goes to the reporter: images that cannot be opened, and what neither
/// frames.csv nor its name tells anything of. Errors: a damaged frames.csv, the disk, cancelled.
[[nodiscard]] Expected<std::uint64_t> copy_images(const std::string& from, ImageNumbers numbers,
                                                  const std::vector<Stop>& stops, const Rig& rig,
                                                  const std::string& session, const RunContext& context);

/// How many images of the rig's cameras a folder holds that lies as in a session. What nobody will use of it goes to
/// the reporter, and cameras of which nothing is left.
[[nodiscard]] std::uint64_t count_images(const std::string& from, const Rig& rig, Reporter& reporter);

/// Warns of the cameras of which a session that was made has no images. `given`: where they were to be, if the user
/// said so.
void warn_of_missing_images(const Rig& rig, const std::string& session, const std::string& given, Reporter& reporter);

}  // namespace rigcal
