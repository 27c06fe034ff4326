// libgpiod 2.
#include <gpiod.h>

#include <algorithm>
#include <cerrno>

#include "drivers/trigger/gpio_chips.h"
#include "drivers/trigger/gpio_line.h"

namespace rigcal::trigger {
namespace {

template <auto Function>
struct Release {
  template <class T>
  void operator()(T* handle) const {
    Function(handle);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Release<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Release<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Release<gpiod_line_info_free>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Release<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Release<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Release<gpiod_request_config_free>>;
using LineRequest = std::unique_ptr<gpiod_line_request, Release<gpiod_line_request_release>>;
using EventBuffer = std::unique_ptr<gpiod_edge_event_buffer, Release<gpiod_edge_event_buffer_free>>;

constexpr std::size_t most_events = 64;
constexpr std::size_t kernel_events = 1024;  // That the kernel keeps: a second of pulses at 500 Hz.

Error refused(const LineAddress& address, const char* verb, int refusal, const LineUse& use = {}) {
  return line_error(address, verb, refusal, use, list_chips());
}

LineUse use_of(gpiod_chip* chip, unsigned line) {
  const LineInfo info(gpiod_chip_get_line_info(chip, line));
  if (!info) return {};
  const char* consumer = gpiod_line_info_get_consumer(info.get());
  return {gpiod_line_info_is_used(info.get()), consumer == nullptr ? "" : consumer};
}

enum class Direction { output, edges };

Expected<LineRequest> request_line(const LineAddress& address, const std::string& consumer, Direction direction) {
  const char* const verb = direction == Direction::output ? "be driven" : "be read";
  const Chip chip(gpiod_chip_open(chip_path(address.chip).c_str()));
  if (!chip) return refused(address, verb, errno);
  const LineUse use = use_of(chip.get(), address.line);
  const LineSettings settings(gpiod_line_settings_new());
  const LineConfig lines(gpiod_line_config_new());
  const RequestConfig config(gpiod_request_config_new());
  if (!settings || !lines || !config) return refused(address, verb, ENOMEM);
  if (direction == Direction::output) {
    gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT);
    gpiod_line_settings_set_output_value(settings.get(), GPIOD_LINE_VALUE_INACTIVE);
  } else {
    gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT);
    gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH);
    gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC);
    gpiod_request_config_set_event_buffer_size(config.get(), kernel_events);
  }
  gpiod_request_config_set_consumer(config.get(), consumer.c_str());
  if (gpiod_line_config_add_line_settings(lines.get(), &address.line, 1, settings.get()) != 0)
    return refused(address, verb, errno);
  LineRequest request(gpiod_chip_request_lines(chip.get(), config.get(), lines.get()));
  if (!request) return refused(address, verb, errno, use);
  return request;
}

}  // namespace

GpioChip describe_chip(const std::string& path) {
  GpioChip described;
  described.name = path.substr(path.rfind('/') + 1);
  const Chip chip(gpiod_chip_open(path.c_str()));
  const ChipInfo info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
  if (!info) {
    described.refusal = errno;
    return described;
  }
  described.label = gpiod_chip_info_get_label(info.get());
  described.lines = static_cast<unsigned>(gpiod_chip_info_get_num_lines(info.get()));
  return described;
}

Expected<LineUse> line_use(const LineAddress& address) {
  const Chip chip(gpiod_chip_open(chip_path(address.chip).c_str()));
  if (!chip) return refused(address, "be asked for", errno);
  const LineInfo info(gpiod_chip_get_line_info(chip.get(), address.line));
  if (!info) return refused(address, "be asked for", errno);
  return use_of(chip.get(), address.line);
}

struct OutputLine::State {
  ~State() {
    if (request) gpiod_line_request_set_value(request.get(), address.line, GPIOD_LINE_VALUE_INACTIVE);
  }
  LineAddress address;
  LineRequest request;
};

OutputLine::OutputLine(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutputLine::~OutputLine() = default;
OutputLine::OutputLine(OutputLine&&) noexcept = default;
OutputLine& OutputLine::operator=(OutputLine&&) noexcept = default;

Expected<OutputLine> OutputLine::request(const LineAddress& address, const std::string& consumer) {
  auto request = request_line(address, consumer, Direction::output);
  if (!request) return request.error();
  auto state = std::make_unique<State>();
  state->address = address;
  state->request = *std::move(request);
  return OutputLine(std::move(state));
}

Expected<void> OutputLine::set(bool is_high) {
  const gpiod_line_value value = is_high ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
  if (gpiod_line_request_set_value(state_->request.get(), state_->address.line, value) != 0)
    return refused(state_->address, "be driven", errno);
  return {};
}

struct InputLine::State {
  LineAddress address;
  LineRequest request;
  EventBuffer buffer;
};

InputLine::InputLine(std::unique_ptr<State> state) : state_(std::move(state)) {}
InputLine::~InputLine() = default;
InputLine::InputLine(InputLine&&) noexcept = default;
InputLine& InputLine::operator=(InputLine&&) noexcept = default;

Expected<InputLine> InputLine::request(const LineAddress& address, const std::string& consumer) {
  auto request = request_line(address, consumer, Direction::edges);
  if (!request) return request.error();
  auto state = std::make_unique<State>();
  state->address = address;
  state->request = *std::move(request);
  state->buffer.reset(gpiod_edge_event_buffer_new(most_events));
  if (!state->buffer) return refused(address, "be read", ENOMEM);
  return InputLine(std::move(state));
}

int InputLine::descriptor() const { return gpiod_line_request_get_fd(state_->request.get()); }

Expected<std::size_t> InputLine::read(std::span<Edge> edges) {
  const int count = gpiod_line_request_read_edge_events(state_->request.get(), state_->buffer.get(),
                                                        std::min(edges.size(), most_events));
  if (count < 0) return refused(state_->address, "be read", errno);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(state_->buffer.get(), i);
    edges[i] = {static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)),
                gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
                gpiod_edge_event_get_line_seqno(event)};
  }
  return static_cast<std::size_t>(count);
}

}  // namespace rigcal::trigger
