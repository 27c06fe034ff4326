#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "core/records/image.h"
#include "core/rig/rig.h"
#include "core/stops/still_listener.h"

namespace rigcal {

/// The turntable.csv of a session; empty where it has none. One that is damaged is not used, with a warning: the angles
/// are a start where nothing else tells of a turn, and most sessions do without.
[[nodiscard]] std::vector<TableAngle> session_table_angles(const std::string& session, Reporter& reporter);

/// Where the table says it was in the middle of a stop: the mean of what it said in it, by the shortest way from
/// one to the next, as a table may count within a turn; nothing where it said nothing.
[[nodiscard]] std::optional<double> angle_in_stop(const std::vector<TableAngle>& angles, const Stop& stop);

/// What a table's angles say of the turns between stops. They are a start where nothing else tells of a turn, never
/// more: a table may slip, or count steps that it did not make.
struct TableTurns {
  /// By stop: the rotation from the stop before in the base's axes; nothing where it is not known.
  std::vector<std::optional<Matrix3d>> R_previous_this;
};
/// Needs the axis of the rig file. Of a stop in which the table says nothing what it said last before counts, where it
/// had arrived then.
[[nodiscard]] TableTurns table_turns(const Rig& rig, const std::vector<TableAngle>& angles,
                                     const std::vector<Stop>& stops);

/// Takes the table's turns where no other is known, and says in a sentence where the two disagree by more than a table
/// may be off (2 degrees); empty where they do not.
[[nodiscard]] std::string merge_table_turns(const TableTurns& table,
                                            std::vector<std::optional<Matrix3d>>& R_previous_this);

}  // namespace rigcal
