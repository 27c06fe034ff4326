#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/pcap_reader.h"
#include "tests/core/io/dump_bytes.h"

namespace rigcal {

/// All that a reader says of a dump.
struct ReadAll {
  std::vector<Bytes> payloads;
  std::vector<std::int64_t> stamps_ns;
  PcapCounters counters;
  std::string truncation;
  std::string error;
};

inline ReadAll read_all(const std::string& path) {
  ReadAll all;
  Expected<PcapReader> reader = PcapReader::open(path);
  if (!reader) {
    all.error = reader.error().message();
    return all;
  }
  Datagram datagram;
  while (true) {
    const Expected<bool> more = reader->next(datagram);
    if (!more) all.error = more.error().message();
    if (!more || !*more) break;
    EXPECT_EQ(to_string(datagram.from), "192.168.1.5:55000");
    EXPECT_EQ(to_string(datagram.to), "192.168.1.50:60001");
    all.payloads.emplace_back(datagram.bytes.begin(), datagram.bytes.end());
    all.stamps_ns.push_back(datagram.stamp_ns);
  }
  all.counters = reader->counters();
  all.truncation = reader->truncation();
  EXPECT_EQ(reader->truncated(), !all.truncation.empty());
  return all;
}

const Bytes payload{1, 2, 3, 4, 5};
constexpr std::int64_t start_ns = 1'600'000'000'000'000'000;

}  // namespace rigcal
