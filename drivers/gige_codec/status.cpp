#include "drivers/gige_codec/status.h"

namespace rigcal::gige {

const char* to_string(Status status) {
  switch (status) {
    case Status::success:
      return "success";
    case Status::packet_resent:
      return "packet resent";
    case Status::not_implemented:
      return "not implemented";
    case Status::invalid_parameter:
      return "invalid parameter";
    case Status::invalid_address:
      return "invalid address";
    case Status::write_protected:
      return "write protected";
    case Status::bad_alignment:
      return "bad alignment";
    case Status::access_denied:
      return "access denied";
    case Status::busy:
      return "busy";
    case Status::packet_unavailable:
      return "packet unavailable";
    case Status::data_overrun:
      return "data overrun";
    case Status::invalid_header:
      return "invalid header";
    case Status::packet_not_yet_available:
      return "packet not yet available";
    case Status::packet_and_earlier_removed:
      return "packet and all before it removed from memory";
    case Status::packet_removed:
      return "packet removed from memory";
    case Status::error:
      return "error";
  }
  return "unknown";
}

}  // namespace rigcal::gige
