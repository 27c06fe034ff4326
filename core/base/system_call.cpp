#include "core/base/system_call.h"

#include <cerrno>
#include <system_error>
#include <utility>

namespace rigcal {

std::string mend_of(int code) {
  switch (code) {
    case EACCES:
    case EPERM:
      return "this user may not do it: give him the permission, or run rigcal as a user who has it";
    case EROFS:
      return "it is mounted read-only: choose another place, or mount it for writing";
    case ENOSPC:
      return "there is no room left for it: make room, or choose another place";
    case EDQUOT:
      return "this user's share of the disk is used up (quota): remove what is not needed, or choose another disk";
    case EFBIG:
      return "choose another disk, or raise the limit of file sizes (ulimit -f)";
    case ENOENT:
      return "it is not there: check its name";
    case EEXIST:
      return "something of that name is there: choose another name, or move that away";
    case EISDIR:
      return "it is a folder: name a file";
    case ENOTDIR:
      return "a part of its path is a file and no folder: check the path";
    case ELOOP:
      return "its links lead in a circle: see where they lead (ls -l), and mend them";
    case ENAMETOOLONG:
      return "choose a shorter name";
    case EXDEV:
      return "choose a place on the same disk";
    case ENODEV:
    case ENXIO:
      return "the device is not there: plug it in, or load its driver";
    case EIO:
      return "look after the disk or device, its cable and its power (dmesg tells more)";
    case ESTALE:
      return "the network's disk lost it: try again, or mount that disk anew";
    case EBUSY:
    case ETXTBSY:
      return "something else uses it: end that, or wait until it has ended";
    case EMFILE:
      return "this program has too many files open: raise its limit (ulimit -n)";
    case ENFILE:
      return "the machine has too many files open: end other programs, or raise its limit (sysctl fs.file-max)";
    case ENOMEM:
    case ENOBUFS:
      return "the machine has not enough memory for it: end other programs";
    case EAGAIN:
      return "the system has no room for it now: end other programs, or try again later";
    case EADDRINUSE:
      return "another program has that address and port: end it (`ss -lntup` shows which), or take another port";
    case EADDRNOTAVAIL:
      return "no interface of this machine has that address: set it, or take another one (`ip addr` shows them)";
    case ENETUNREACH:
    case EHOSTUNREACH:
    case ENETDOWN:
      return "no way leads there: plug the cable in, and give an interface an address in that network (`ip addr`)";
    case ETIMEDOUT:
      return "the other side did not answer in time: look at its power, its cable and its address";
    case ECONNREFUSED:
      return "nothing takes connections there: start what should, or check its address and port";
    case ECONNRESET:
    case EPIPE:
      return "the other side ended it: see whether it still runs, and try again";
    case ENOSYS:
    case EOPNOTSUPP:
      return "the system or the device cannot do it: take a newer system, or another device or disk";
    default:
      return {};
  }
}

Error call_error(const std::string& what, int code, std::string where, std::string mend) {
  if (mend.empty()) mend = mend_of(code);
  return system_error(what + ": " + std::generic_category().message(code), std::move(where), std::move(mend));
}

}  // namespace rigcal
