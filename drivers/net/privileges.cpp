#include "drivers/net/privileges.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace rigcal::net {

std::string become_realtime() {
  sched_param parameters{};
  parameters.sched_priority = kRealtimePriority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error == 0) return {};
  return std::string("no real-time priority (") + std::strerror(error) + "): allow it with an rtprio of " +
         std::to_string(kRealtimePriority) + " in /etc/security/limits.d, or CAP_SYS_NICE";
}

void name_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

std::string lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("memory cannot be locked (") + std::strerror(errno) +
         "): allow it with an unlimited memlock in /etc/security/limits.d, or CAP_IPC_LOCK";
}

}  // namespace rigcal::net
