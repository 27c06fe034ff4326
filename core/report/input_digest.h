#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "core/quality/result_evidence.h"

namespace rigcal {

/// Larger files are told by their size and their first and last 16 MiB, so that a long recording costs no minute.
constexpr std::uint64_t digest_whole_bytes = std::uint64_t{1} << 30U;

/// What a result was made from: each of `paths` that is a file, and of each that is a folder its files, folders in it
/// taken together. A digest in part is that of the size in decimal digits, a newline, and the first and last bytes.
/// About 0.25 GB a second of a processor; ends early, with what it has, when it is told to stop. What cannot be read is
/// left out: whoever reads it for the calibration says so.
[[nodiscard]] std::vector<InputDigest> digest_inputs(const std::vector<std::string>& paths, const std::stop_token& stop,
                                                     std::uint64_t whole_bytes = digest_whole_bytes);

}  // namespace rigcal
