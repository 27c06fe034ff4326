#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/io/pcap_reader.h"
#include "tests/support/make_lvx.h"

namespace rigcal {

/// The devices of small_rig() as .lvx files tell of them.
[[nodiscard]] inline LvxDevice small_rig_avia() {
  LvxDevice avia;
  avia.broadcast_code = "3JEDHC900100791";
  avia.type = 7;
  return avia;
}
[[nodiscard]] inline LvxDevice small_rig_mid40() {
  LvxDevice mid40;
  mid40.broadcast_code = "0TFDG3B00600551";
  mid40.index = 1;
  mid40.type = 1;
  return mid40;
}

/// Saves the packets of a dump as a recorder of the vendor keeps them: without addresses and receive stamps, in frames.
/// `avia` sends from an address that ends in 179, and no other but `mid40` does send.
inline void save_as_lvx(const std::string& dump, const LvxDevice& avia, const LvxDevice& mid40,
                        const std::string& lvx) {
  constexpr std::int64_t frame_ns = 50'000'000;
  LvxBuilder file(1, {avia, mid40});
  Expected<PcapReader> reader = PcapReader::open(dump);
  ASSERT_TRUE(reader);
  std::int64_t frame_end_ns = 0;
  for (Datagram datagram; *reader->next(datagram);) {
    if (datagram.from.port != 60001 && datagram.from.port != 60003) continue;
    if (frame_end_ns == 0) frame_end_ns = datagram.stamp_ns + frame_ns;
    for (; datagram.stamp_ns >= frame_end_ns; frame_end_ns += frame_ns) file.end_frame();
    file.add_package(datagram.from.ip[3] == 179 ? 0 : 1, datagram.bytes);
  }
  file.end_frame();
  file.save(lvx);
}

}  // namespace rigcal
