#include "apps/common/exit_code.h"

namespace rigcal {

ExitCode exit_code_of(const Error& error) {
  switch (error.kind) {
    case ErrorKind::input:
      return ExitCode::input;
    case ErrorKind::system:
      return ExitCode::system;
    case ErrorKind::cancelled:
      return ExitCode::not_trustworthy;
  }
  return ExitCode::system;
}

ExitCode exit_code_of(Status status) { return status == Status::good ? ExitCode::good : ExitCode::not_trustworthy; }

}  // namespace rigcal
