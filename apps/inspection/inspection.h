#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "apps/recording/stop_reader.h"
#include "core/io/session_folder.h"

namespace rigcal {

/// What `inspect` shows, as JSON by docs/schema/inspect.json; the text is made from it, so that both say the same.
using Inspection = nlohmann::ordered_json;

/// Devices of a dump or topics of a bag without a rig file: nothing is known of sensors and stops then.
[[nodiscard]] Expected<Inspection> inspect_stream(const std::string& path, const RunContext& context);
[[nodiscard]] Expected<Inspection> inspect_recording(const StreamSource& source, const RunContext& context);
/// A patch folder; its sensors are those of the rig file, or, where `rig_path` is empty, its folders.
[[nodiscard]] Expected<Inspection> inspect_patches(const std::string& path, const std::string& rig_path,
                                                   const RunContext& context);
/// A session whose recording came as patches, not complete where it has no end; its rig file is taken where `rig_path`
/// is empty.
[[nodiscard]] Expected<Inspection> inspect_patch_session(const SessionFolder& session, const std::string& rig_path,
                                                         const RunContext& context);
/// A result folder or an extrinsics.yaml: the verdict, in the words of report.html.
[[nodiscard]] Expected<Inspection> inspect_result(const std::string& path);
/// Two of them: which sensors moved between them, and whether any did ("same").
[[nodiscard]] Expected<Inspection> inspect_two_results(const std::string& first, const std::string& second);
/// The beginning that all have in common.
[[nodiscard]] Inspection begin_inspection(const char* kind, const std::string& path);

[[nodiscard]] std::string inspection_text(const Inspection& inspection);

}  // namespace rigcal
