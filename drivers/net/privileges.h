#pragma once

#include <string>

namespace rigcal::net {

/// What `become_realtime` asks for, of 1 to 99: above all ordinary work, below the kernel's own threads.
inline constexpr int kRealtimePriority = 50;

/// Asks for real-time priority for the calling thread. What keeps it from that and the mend, or an empty text.
[[nodiscard]] std::string become_realtime();

/// Keeps all memory of the program from being swapped out. What keeps it from that and the mend, or an empty text.
[[nodiscard]] std::string lock_memory();

/// What the calling thread is called in `top -H`; at most 15 letters.
void name_thread(const char* name);

}  // namespace rigcal::net
