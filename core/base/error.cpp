#include "core/base/error.h"

#include <cstdio>
#include <cstdlib>

namespace rigcal {

std::string Error::message() const {
  std::string text;
  if (!where.empty()) text += where + ": ";
  text += what;
  if (!mend.empty()) text += "; " + mend;
  return text;
}

Error input_error(std::string what, std::string where, std::string mend) {
  return {ErrorKind::input, std::move(what), std::move(where), std::move(mend)};
}

Error system_error(std::string what, std::string where, std::string mend) {
  return {ErrorKind::system, std::move(what), std::move(where), std::move(mend)};
}

Error cancelled_error(std::string what, std::string where) {
  return {ErrorKind::cancelled, std::move(what), std::move(where), {}};
}

const Error& Expected<void>::error() const {
  RIGCAL_ASSERT(failed_, "no error in an Expected that holds a value");
  return error_;
}

void abort_with(const std::string& message, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: internal error: %s\n", file, line, message.c_str());
  std::abort();
}

}  // namespace rigcal
