#pragma once

#include <cstdint>

/// Counts what asks for memory in this test program (operator new).
namespace rigcal {

[[nodiscard]] std::uint64_t allocations_in_this_thread();
/// In the driver's threads that receive, by their name.
[[nodiscard]] std::uint64_t allocations_in_receivers();

}  // namespace rigcal
