#pragma once

namespace rigcal {

/// Keeps freed memory for what comes next, however large the pieces are, instead of giving it back and having it
/// cleared again at once: the steps of a calibration need as much one after the other. For programs that end soon; not
/// for those that run for days. Large pieces are asked for in huge pages, as long as the program is linked with
/// jemalloc and the system has them.
void keep_freed_memory();

/// Gives the system back what is free all the same, so that what a process holds is what it needs.
void give_back_freed_memory();

}  // namespace rigcal
