#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"

/// Lines of GPIO chips. Which version of libgpiod is behind this is chosen at build: gpio_line_v1.cpp or
/// gpio_line_v2.cpp. Errors (kind system) name the chip, the line, who holds it where somebody does, and the mend.
namespace rigcal::trigger {

/// A line of a chip. The chip by its name ("gpiochip0"), its path, or its label.
struct LineAddress {
  std::string chip;
  unsigned line = 0;
};

/// A chip of this machine.
struct GpioChip {
  std::string name;   ///< gpiochip0
  std::string label;  ///< Empty where it cannot be opened.
  unsigned lines = 0;
  int refusal = 0;  ///< errno of opening it; 0: it can be opened.
};
[[nodiscard]] std::vector<GpioChip> list_chips();

/// What is known of a line.
struct LineUse {
  bool is_used = false;
  std::string consumer;  ///< Who has it, by the name that was given when it was taken; may be empty.
};
[[nodiscard]] Expected<LineUse> line_use(const LineAddress& address);

/// A line that this program drives. Low when it is taken, and low when it is given back, whatever happens before.
class OutputLine {
 public:
  [[nodiscard]] static Expected<OutputLine> request(const LineAddress& address, const std::string& consumer);
  ~OutputLine();
  OutputLine(OutputLine&&) noexcept;
  OutputLine& operator=(OutputLine&&) noexcept;

  /// Errors: the chip is gone.
  Expected<void> set(bool is_high);

 private:
  struct State;
  explicit OutputLine(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A change of a line's level.
struct Edge {
  std::int64_t kernel_ns = 0;  ///< Stamp of the kernel: CLOCK_MONOTONIC, before Linux 5.7 CLOCK_REALTIME.
  bool is_rising = false;
  std::uint64_t sequence = 0;  ///< Counts from 1; 0 where the library does not tell: then losses do not show.
};

/// A line whose edges are read with the stamps of the kernel.
class InputLine {
 public:
  [[nodiscard]] static Expected<InputLine> request(const LineAddress& address, const std::string& consumer);
  ~InputLine();
  InputLine(InputLine&&) noexcept;
  InputLine& operator=(InputLine&&) noexcept;

  /// Readable when there are edges, and when the chip is gone.
  [[nodiscard]] int descriptor() const;
  /// The edges that wait; blocks where there are none. Errors: the chip is gone.
  [[nodiscard]] Expected<std::size_t> read(std::span<Edge> edges);

 private:
  struct State;
  explicit InputLine(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace rigcal::trigger
