#include "drivers/turntable/table.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal::turntable {
namespace {

constexpr std::int64_t read_wait_ns = 20'000'000;
constexpr double tick_s = 0.1;
constexpr std::chrono::milliseconds look_period(200);
constexpr std::size_t most_events = 10'000;

std::unique_ptr<TableProtocol> make_protocol(const TableOptions& options) {
  if (options.protocol == ProtocolKind::grbl) return std::make_unique<GrblProtocol>(options.grbl);
  return std::make_unique<AsciiProtocol>(options.ascii);
}

double now_s() { return seconds_of_ns(monotonic_now_ns()); }

}  // namespace

Expected<std::unique_ptr<Table>> Table::start(const TableOptions& options, const net::ClockReading& session_start) {
  if (options.protocol == ProtocolKind::ascii) {
    if (std::string fault = fault_of(options.ascii); !fault.empty())
      return input_error(std::move(fault), "turntable of the rig file", "see the manual on turntables");
  }
  Expected<SerialPort> port = SerialPort::open(options.port, options.baud);
  if (!port) return port.error();
  return std::unique_ptr<Table>(new Table(options, *std::move(port), session_start));
}

Table::Table(const TableOptions& options, SerialPort port, const net::ClockReading& session_start)
    : options_(options), clock_(session_start), protocol_(make_protocol(options)), port_(std::move(port)) {
  thread_ = std::thread([this] { run(); });
}

Table::~Table() {
  is_stopped_ = true;
  thread_.join();
}

void Table::turn_by(double degrees) {
  const std::lock_guard lock(mutex_);
  to_turn_ = options_.is_reversed ? -degrees : degrees;
}

std::vector<TableEvent> Table::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

std::size_t Table::most_waiting() const {
  const std::lock_guard lock(mutex_);
  return most_waiting_;
}

std::optional<double> Table::angle_deg() const {
  const std::lock_guard lock(mutex_);
  return angle_deg_;
}

double Table::angle_by_table() const {
  const double angle = angle_deg().value_or(0.0);
  return options_.is_reversed ? -angle : angle;
}

void Table::tell(const std::vector<TableNews>& news) {
  const std::int64_t stamp_ns = clock_.from_monotonic(monotonic_now_ns());
  const std::lock_guard lock(mutex_);
  for (const TableNews& each : news) {
    TableEvent event{each, stamp_ns};
    if (options_.is_reversed) event.angle_deg = -event.angle_deg;
    angle_deg_ = event.angle_deg;
    if (events_.size() < most_events) events_.push_back(std::move(event));
  }
  most_waiting_ = std::max(most_waiting_, events_.size());
}

Expected<void> Table::talk(SerialPort& port) {
  double ticked_s = 0.0;
  while (!is_stopped_) {
    heartbeat_.beat();
    const Expected<std::string> bytes = port.read(read_wait_ns);
    if (!bytes) return bytes.error();
    protocol_->receive(*bytes, now_s());
    std::optional<double> to_turn;
    {
      const std::lock_guard lock(mutex_);
      to_turn = std::exchange(to_turn_, std::nullopt);
    }
    if (to_turn) protocol_->turn_by(*to_turn, now_s());
    if (now_s() - ticked_s >= tick_s) {
      ticked_s = now_s();
      protocol_->tick(ticked_s);
    }
    if (const auto written = port.write(protocol_->take_output()); !written) return written;
    if (const std::vector<TableNews> news = protocol_->take_news(); !news.empty()) tell(news);
  }
  protocol_->close();
  return port.write(protocol_->take_output());
}

void Table::run() {
  while (!is_stopped_) {
    heartbeat_.beat();
    if (!port_) {
      std::this_thread::sleep_for(look_period);
      Expected<SerialPort> again = SerialPort::open(options_.port, options_.baud);
      if (!again) continue;
      port_ = *std::move(again);
    }
    protocol_->open(now_s());
    const auto talked = talk(*port_);
    tell(protocol_->take_news());
    if (!talked && !is_stopped_) tell({{TableNews::Kind::failed, angle_by_table(), talked.error().message()}});
    port_.reset();
  }
  heartbeat_.rest();
}

}  // namespace rigcal::turntable
