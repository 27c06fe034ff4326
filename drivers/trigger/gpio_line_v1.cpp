// libgpiod 1.5 and later, before 2.0.
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "core/base/seconds.h"
#include "drivers/trigger/gpio_chips.h"
#include "drivers/trigger/gpio_line.h"

namespace rigcal::trigger {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }  // Gives its lines back, too.
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

constexpr std::size_t most_events = 16;  // The kernel keeps no more.

struct OpenLine {
  Chip chip;
  gpiod_line* line = nullptr;
};

Error refused(const LineAddress& address, const char* verb, int refusal, const LineUse& use = {}) {
  return line_error(address, verb, refusal, use, list_chips());
}

Expected<OpenLine> open_line(const LineAddress& address, const char* verb) {
  OpenLine open;
  open.chip.reset(gpiod_chip_open(chip_path(address.chip).c_str()));
  if (!open.chip) return refused(address, verb, errno);
  open.line = gpiod_chip_get_line(open.chip.get(), address.line);
  if (open.line == nullptr) return refused(address, verb, errno);
  return open;
}

LineUse use_of(gpiod_line* line) {
  const char* consumer = gpiod_line_consumer(line);
  return {gpiod_line_is_used(line), consumer == nullptr ? "" : consumer};
}

}  // namespace

GpioChip describe_chip(const std::string& path) {
  GpioChip described;
  described.name = path.substr(path.rfind('/') + 1);
  const Chip chip(gpiod_chip_open(path.c_str()));
  if (!chip) {
    described.refusal = errno;
    return described;
  }
  described.label = gpiod_chip_label(chip.get());
  described.lines = gpiod_chip_num_lines(chip.get());
  return described;
}

Expected<LineUse> line_use(const LineAddress& address) {
  const auto open = open_line(address, "be asked for");
  if (!open) return open.error();
  return use_of(open->line);
}

struct OutputLine::State {
  ~State() {
    if (open.line != nullptr) gpiod_line_set_value(open.line, 0);
  }
  LineAddress address;
  OpenLine open;
};

OutputLine::OutputLine(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutputLine::~OutputLine() = default;
OutputLine::OutputLine(OutputLine&&) noexcept = default;
OutputLine& OutputLine::operator=(OutputLine&&) noexcept = default;

Expected<OutputLine> OutputLine::request(const LineAddress& address, const std::string& consumer) {
  auto open = open_line(address, "be driven");
  if (!open) return open.error();
  const LineUse use = use_of(open->line);
  if (gpiod_line_request_output(open->line, consumer.c_str(), 0) != 0) return refused(address, "be driven", errno, use);
  auto state = std::make_unique<State>();
  state->address = address;
  state->open = *std::move(open);
  return OutputLine(std::move(state));
}

Expected<void> OutputLine::set(bool is_high) {
  if (gpiod_line_set_value(state_->open.line, is_high ? 1 : 0) != 0)
    return refused(state_->address, "be driven", errno);
  return {};
}

struct InputLine::State {
  LineAddress address;
  OpenLine open;
  int descriptor = -1;
};

InputLine::InputLine(std::unique_ptr<State> state) : state_(std::move(state)) {}
InputLine::~InputLine() = default;
InputLine::InputLine(InputLine&&) noexcept = default;
InputLine& InputLine::operator=(InputLine&&) noexcept = default;

Expected<InputLine> InputLine::request(const LineAddress& address, const std::string& consumer) {
  auto open = open_line(address, "be read");
  if (!open) return open.error();
  const LineUse use = use_of(open->line);
  if (gpiod_line_request_both_edges_events(open->line, consumer.c_str()) != 0)
    return refused(address, "be read", errno, use);
  auto state = std::make_unique<State>();
  state->address = address;
  state->open = *std::move(open);
  state->descriptor = gpiod_line_event_get_fd(state->open.line);
  return InputLine(std::move(state));
}

int InputLine::descriptor() const { return state_->descriptor; }

Expected<std::size_t> InputLine::read(std::span<Edge> edges) {
  std::array<gpiod_line_event, most_events> events{};
  const auto room = static_cast<unsigned>(std::min(edges.size(), events.size()));
  const int count = gpiod_line_event_read_fd_multiple(state_->descriptor, events.data(), room);
  if (count < 0) return refused(state_->address, "be read", errno);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    edges[i] = {static_cast<std::int64_t>(events[i].ts.tv_sec) * ns_per_second + events[i].ts.tv_nsec,
                events[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE, 0};
  }
  return static_cast<std::size_t>(count);
}

}  // namespace rigcal::trigger
