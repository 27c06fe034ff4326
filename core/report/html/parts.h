#pragma once

#include <string>
#include <vector>

#include "core/quality/result.h"
#include "core/rig/rig.h"

/// The parts of report.html, each a <section> (or nothing where the result has nothing to show in it). They take the
/// result as it is and hold no state; texts that come from outside are escaped here.
namespace rigcal::html {

/// Of every plot that shows a result beside its guess.
constexpr int result_series = 0;
constexpr int guess_series = 1;

/// A table of plain texts; the first column names the rows. `remark` stands below, already HTML; may be empty.
[[nodiscard]] std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                                const std::string& remark = {});
[[nodiscard]] std::string section(const std::string& id, const std::string& title, const std::string& content);
/// A picture with words below it, which are HTML.
[[nodiscard]] std::string figure(const std::string& picture, const std::string& words);
/// Words between pictures; HTML.
[[nodiscard]] std::string paragraph(const std::string& words);
/// "good" with its mark, coloured.
[[nodiscard]] std::string badge(Status status);

[[nodiscard]] std::string status_part(const CalibrationResult& result, const Rig* rig);
[[nodiscard]] std::string numbers_part(const CalibrationResult& result);
[[nodiscard]] std::string cameras_part(const CalibrationResult& result);
[[nodiscard]] std::string view_part(const CalibrationResult& result, const Rig* rig);
[[nodiscard]] std::string maps_part(const CalibrationResult& result);
[[nodiscard]] std::string surfaces_part(const CalibrationResult& result);
[[nodiscard]] std::string hold_out_part(const CalibrationResult& result);
[[nodiscard]] std::string convergence_part(const CalibrationResult& result);
[[nodiscard]] std::string recording_part(const CalibrationResult& result);
[[nodiscard]] std::string run_part(const CalibrationResult& result);

/// The sensors with their colours, for pictures that have no legend of their own; `shown` has an entry for each.
[[nodiscard]] std::string colour_key(const CalibrationResult& result, const std::vector<char>& shown);

}  // namespace rigcal::html
