#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"

namespace rigcal::hil {

/// A request on endpoint 0 (USB 2.0, 9.3).
struct SetupRequest {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
  [[nodiscard]] bool is_to_host() const { return (type & 0x80U) != 0; }
};

/// A USB device made of the kernel's raw_gadget on its dummy host (dummy_hcd): the requests to it come here. Calls
/// block; a signal ends them. It is unplugged when this is destroyed.
class RawGadget {
 public:
  /// Errors (kind system): no raw_gadget, no dummy host, or another program has it.
  [[nodiscard]] static Expected<std::unique_ptr<RawGadget>> plug_in();
  ~RawGadget();
  RawGadget(const RawGadget&) = delete;
  RawGadget& operator=(const RawGadget&) = delete;

  /// The next request; nothing where it was only plugged in, or a signal came.
  [[nodiscard]] Expected<std::optional<SetupRequest>> next();
  void answer(const SetupRequest& request, ByteView bytes);
  void acknowledge(const SetupRequest& request);
  void refuse();

  /// `descriptor` of the endpoint; what it is called in the transfers.
  [[nodiscard]] Expected<int> enable(ByteView descriptor);
  void set_configured();
  /// Bytes of a transfer; nothing where a signal came or the host does not want it.
  [[nodiscard]] std::optional<std::size_t> write(int endpoint, ByteView bytes);
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> read(int endpoint, std::size_t most);

 private:
  explicit RawGadget(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace rigcal::hil
