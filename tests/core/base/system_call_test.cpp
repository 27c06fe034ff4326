#include "core/base/system_call.h"

#include <gtest/gtest.h>

#include <cerrno>

namespace rigcal {
namespace {

TEST(SystemCall, EveryCommonRefusalHasAMend) {
  for (const int code :
       {EACCES,       EPERM,  EROFS,   ENOSPC, EDQUOT, EFBIG,        ENOENT,      EEXIST,     EISDIR,        ENOTDIR,
        ELOOP,        ENODEV, ENXIO,   EIO,    ESTALE, ENAMETOOLONG, EXDEV,       EBUSY,      ETXTBSY,       EMFILE,
        ENFILE,       ENOMEM, ENOBUFS, EAGAIN, ENOSYS, ETIMEDOUT,    ENETUNREACH, EADDRINUSE, EADDRNOTAVAIL, ENETDOWN,
        EHOSTUNREACH, EPIPE,  EINTR,   EINVAL, 0,      ECONNREFUSED, ECONNRESET,  EOPNOTSUPP})
    EXPECT_EQ(mend_of(code).empty(), code == EINTR || code == EINVAL || code == 0) << code;
}

TEST(SystemCall, ErrorsSayWhatTheSystemSaidAndTheMendOfWhoKnowsBetter) {
  const Error error = call_error("cannot make a socket", EMFILE, "UDP 1.2.3.4:5");
  EXPECT_EQ(error.kind, ErrorKind::system);
  EXPECT_EQ(error.message(),
            "UDP 1.2.3.4:5: cannot make a socket: Too many open files; this program has too many files open: raise its "
            "limit (ulimit -n)");
  EXPECT_EQ(call_error("cannot listen", EACCES, {}, "take a port above 1023").mend, "take a port above 1023");
}

}  // namespace
}  // namespace rigcal
