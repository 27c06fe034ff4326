#include "apps/capture/table_recorder.h"

#include <filesystem>
#include <utility>

namespace rigcal {
namespace {

constexpr std::int64_t write_again_ns = 1'000'000'000;  // An angle that stays the same.

std::string words(const std::string& given, const std::string& usual) {
  if (given == "none") return {};
  return given.empty() ? usual : given;
}

}  // namespace

std::optional<turntable::TableOptions> table_options(const Rig& rig) {
  if (!rig.turntable || rig.turntable->driver != "serial") return std::nullopt;
  const TurntableSettings& given = *rig.turntable;
  turntable::TableOptions options;
  options.port = given.port;
  options.baud = given.baud.value_or(options.baud);
  options.is_reversed = given.is_reversed;
  if (given.protocol == "ascii") options.protocol = turntable::ProtocolKind::ascii;
  if (!given.letter.empty()) options.grbl.letter = given.letter.front();
  options.grbl.degrees_per_s = given.speed_deg_s.value_or(options.grbl.degrees_per_s);
  options.ascii.move = words(given.move, options.ascii.move);
  options.ascii.ask = words(given.ask, options.ascii.ask);
  options.ascii.answer = words(given.answer, options.ascii.answer);
  options.ascii.done = words(given.done, options.ascii.done);
  options.ascii.fault = words(given.fault, options.ascii.fault);
  return options;
}

Expected<std::unique_ptr<TableRecorder>> TableRecorder::create(std::unique_ptr<turntable::Table> table,
                                                               const std::string& session) {
  auto angles = TurntableTable::create((std::filesystem::path(session) / "turntable.csv").string());
  if (!angles) return angles.error();
  return std::unique_ptr<TableRecorder>(new TableRecorder(std::move(table), *std::move(angles)));
}

std::vector<turntable::TableEvent> TableRecorder::take_events() {
  std::vector<turntable::TableEvent> events = table_->take_events();
  for (const turntable::TableEvent& event : events) {
    if (event.kind == turntable::TableNews::Kind::failed) continue;
    const bool is_same = written_ && written_->angle_deg == event.angle_deg;
    if (written_ && event.stamp_ns < written_->stamp_ns + (is_same ? write_again_ns : 1)) continue;
    written_ = TableAngle{event.stamp_ns, event.angle_deg};
    if (failure_) continue;
    if (const auto added = angles_.add(*written_); !added) failure_ = added.error();
  }
  return events;
}

}  // namespace rigcal
