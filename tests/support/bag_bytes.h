#pragma once

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "core/base/bytes.h"

namespace rigcal {

/// Writes ROS 1 bags (format 2.0) byte by byte, from the format's description, not by the code under test; also bags
/// that no recorder would write. `flush` ends a chunk.
class BagBytes {
 public:
  using Bytes = std::vector<std::uint8_t>;
  std::string compression = "none";

  BagBytes() { set_head(0); }

  void add(const std::string& topic, const std::string& type, const std::string& md5, std::int64_t stamp_ns,
           const Bytes& message) {
    const auto [place, is_new] = numbers_.try_emplace(topic, static_cast<std::uint32_t>(numbers_.size()));
    if (is_new) {
      const Bytes record = connection(place->second, topic, type, md5);
      connections_.insert(connections_.end(), record.begin(), record.end());
      chunk_.insert(chunk_.end(), record.begin(), record.end());
    }
    const Bytes record =
        make_record({{"op", word<std::uint8_t>(2)}, {"conn", word(place->second)}, {"time", time(stamp_ns)}}, message);
    chunk_.insert(chunk_.end(), record.begin(), record.end());
    first_ns_ = messages_ == 0 ? stamp_ns : std::min(first_ns_, stamp_ns);
    last_ns_ = messages_ == 0 ? stamp_ns : std::max(last_ns_, stamp_ns);
    ++messages_;
  }

  void flush() {
    if (chunk_.empty()) return;
    const auto at = static_cast<std::uint64_t>(bytes_.size());
    append(make_record({{"op", word<std::uint8_t>(5)},
                        {"compression", text(compression)},
                        {"size", word(static_cast<std::uint32_t>(chunk_.size()))}},
                       packed()));
    const Bytes info = make_record({{"op", word<std::uint8_t>(6)},
                                    {"ver", word<std::uint32_t>(1)},
                                    {"chunk_pos", word(at)},
                                    {"start_time", time(first_ns_)},
                                    {"end_time", time(last_ns_)},
                                    {"count", word<std::uint32_t>(0)}},
                                   {});
    infos_.insert(infos_.end(), info.begin(), info.end());
    ++chunks_;
    chunk_.clear();
    messages_ = 0;
  }

  /// A whole bag.
  [[nodiscard]] Bytes finish() {
    flush();
    Bytes out = bytes_;
    const Bytes head = head_record(out.size());
    std::copy(head.begin(), head.end(), out.begin() + 13);
    out.insert(out.end(), connections_.begin(), connections_.end());
    out.insert(out.end(), infos_.begin(), infos_.end());
    return out;
  }
  /// As a recorder leaves it that was killed: no index, the last chunk not closed.
  [[nodiscard]] Bytes killed() const {
    Bytes out = bytes_;
    const Bytes open = make_record(
        {{"op", word<std::uint8_t>(5)}, {"compression", text("none")}, {"size", word<std::uint32_t>(0)}}, {});
    out.insert(out.end(), open.begin(), open.end());
    out.insert(out.end(), chunk_.begin(), chunk_.end());
    return out;
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

  using Fields = std::vector<std::pair<std::string, Bytes>>;
  [[nodiscard]] static Bytes make_record(const Fields& fields, const Bytes& data) {
    Bytes header;
    ByteWriter writer(header);
    for (const auto& [name, value] : fields) {
      writer.write(static_cast<std::uint32_t>(name.size() + 1 + value.size()));
      writer.write_bytes(text(name + "="));
      writer.write_bytes(value);
    }
    Bytes record;
    ByteWriter out(record);
    out.write(static_cast<std::uint32_t>(header.size()));
    out.write_bytes(header);
    out.write(static_cast<std::uint32_t>(data.size()));
    out.write_bytes(data);
    return record;
  }
  [[nodiscard]] static Bytes text(const std::string& value) { return {value.begin(), value.end()}; }
  template <class T>
  [[nodiscard]] static Bytes word(T value) {
    Bytes bytes;
    ByteWriter(bytes).write(value);
    return bytes;
  }

 private:
  [[nodiscard]] static Bytes time(std::int64_t stamp_ns) {
    Bytes bytes = word(static_cast<std::uint32_t>(stamp_ns / 1'000'000'000));
    ByteWriter(bytes).write(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
    return bytes;
  }
  [[nodiscard]] static Bytes connection(std::uint32_t number, const std::string& topic, const std::string& type,
                                        const std::string& md5) {
    Bytes data;
    ByteWriter writer(data);
    for (const auto& [name, value] :
         std::map<std::string, std::string>{{"topic", topic}, {"type", type}, {"md5sum", md5}}) {
      const std::string field = name + "=" + value;
      writer.write(static_cast<std::uint32_t>(field.size()));
      writer.write_text(field, field.size());
    }
    return make_record({{"op", word<std::uint8_t>(7)}, {"conn", word(number)}, {"topic", text(topic)}}, data);
  }
  [[nodiscard]] Bytes head_record(std::size_t index_at) const {
    const Fields fields{{"op", word<std::uint8_t>(3)},
                        {"index_pos", word(static_cast<std::uint64_t>(index_at))},
                        {"conn_count", word(static_cast<std::uint32_t>(numbers_.size()))},
                        {"chunk_count", word(chunks_)}};
    const std::size_t empty = make_record(fields, {}).size();
    return make_record(fields, Bytes(4096 - empty, ' '));
  }
  void set_head(std::size_t index_at) {
    bytes_ = text("#ROSBAG V2.0\n");
    append(head_record(index_at));
  }
  void append(const Bytes& record) { bytes_.insert(bytes_.end(), record.begin(), record.end()); }
  [[nodiscard]] Bytes packed() {
    if (compression == "bz2") {
      Bytes out(chunk_.size() + chunk_.size() / 50 + 700);
      auto size = static_cast<unsigned>(out.size());
      if (BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(out.data()), &size, reinterpret_cast<char*>(chunk_.data()),
                                   static_cast<unsigned>(chunk_.size()), 9, 0, 30) != BZ_OK) {
        std::abort();
      }
      out.resize(size);
      return out;
    }
    if (compression == "lz4") {
      Bytes out(LZ4F_compressFrameBound(chunk_.size(), nullptr));
      out.resize(LZ4F_compressFrame(out.data(), out.size(), chunk_.data(), chunk_.size(), nullptr));
      return out;
    }
    return chunk_;
  }

  Bytes bytes_;
  Bytes chunk_;
  Bytes connections_;
  Bytes infos_;
  std::map<std::string, std::uint32_t> numbers_;
  std::uint32_t chunks_ = 0;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::size_t messages_ = 0;
};

}  // namespace rigcal
