#pragma once

#include <string>

namespace rigcal::net {

/// Asks for real-time priority for the calling thread. What keeps it from that and the mend, or an empty text.
[[nodiscard]] std::string become_realtime();

/// Keeps all memory of the program from being swapped out. What keeps it from that and the mend, or an empty text.
[[nodiscard]] std::string lock_memory();

/// What the calling thread is called in `top -H`; at most 15 letters.
void name_thread(const char* name);

}  // namespace rigcal::net
