#include "core/io/bag_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/bag_record.h"
#include "core/io/random_access_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::string_view magic = "#ROSBAG V2.0\n";
constexpr std::uint32_t max_header_bytes = 1U << 20;       // a header holds a topic's name at most
constexpr std::uint32_t max_connection_bytes = 16U << 20;  // type, md5sum and the text of the message's definition
constexpr std::uint64_t max_open_bytes = std::uint64_t{1} << 30;
constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

/// A record of the file itself; its data is still there.
struct FileRecord {
  std::vector<std::uint8_t> header;
  std::uint64_t data_at = 0;
  std::uint32_t data_bytes = 0;

  [[nodiscard]] BagFields fields() const { return BagFields(header); }
  [[nodiscard]] std::uint64_t end() const { return data_at + data_bytes; }
};

struct ChunkPlace {
  std::uint64_t at = 0;
  std::int64_t start_ns = never;
};

struct MessagePlace {
  std::int64_t stamp_ns = 0;
  const BagConnection* connection = nullptr;
  ByteView bytes;
};

/// A chunk with messages still to come.
struct OpenChunk {
  std::vector<std::uint8_t> bytes;
  std::vector<MessagePlace> messages;  ///< In order of time.
  std::size_t next = 0;
};

std::optional<FileRecord> record_at(const RandomAccessFile& file, std::uint64_t at) {
  std::array<std::uint8_t, 4> word{};
  if (!file.read_at(at, word)) return std::nullopt;
  const auto header_bytes = ByteReader(word).read<std::uint32_t>();
  if (header_bytes > max_header_bytes || at + 8 + header_bytes > file.size()) return std::nullopt;
  FileRecord record;
  record.header.resize(header_bytes);
  if (!file.read_at(at + 4, record.header) || !file.read_at(at + 4 + header_bytes, word)) return std::nullopt;
  record.data_at = at + 8 + header_bytes;
  record.data_bytes = ByteReader(word).read<std::uint32_t>();
  return record;
}

std::vector<std::uint8_t> data_of(const RandomAccessFile& file, const FileRecord& record, std::uint64_t most) {
  const std::uint64_t there = file.size() > record.data_at ? file.size() - record.data_at : 0;
  std::vector<std::uint8_t> data(std::min({std::uint64_t{record.data_bytes}, there, most}));
  if (!file.read_at(record.data_at, data)) data.clear();
  return data;
}

Error no_bag(const std::string& path) { return input_error("is no ROS bag of format 2.0", path, "give a .bag file"); }

}  // namespace

struct BagReader::State {
  explicit State(RandomAccessFile bag) : file(std::move(bag)) {}

  Expected<void> read_head();
  bool read_index(std::uint64_t index_at, std::uint32_t connection_count, std::uint32_t chunk_count);
  bool add_connection(const BagFields& fields, ByteView data);
  std::optional<ChunkPlace> peek_chunk();
  void load_chunk(std::uint64_t at);
  void load_loose_message(const FileRecord& record);
  bool add_message(OpenChunk& chunk, const BagFields& fields, ByteView data);
  void keep(std::unique_ptr<OpenChunk> chunk);
  void leave_out(std::uint64_t at, const std::string& why);
  OpenChunk* earliest();

  RandomAccessFile file;
  std::map<std::uint32_t, BagConnection> connections;
  bool indexed = false;
  std::vector<ChunkPlace> plan;  ///< With an index: all chunks by the time of their first message.
  std::size_t next_in_plan = 0;
  std::uint64_t scan_at = 0;  ///< Without: the next record.
  std::vector<std::unique_ptr<OpenChunk>> open;
  std::uint64_t open_bytes = 0;
  std::uint64_t left_out = 0;
  std::string first_reason;
};

Expected<void> BagReader::State::read_head() {
  std::vector<std::uint8_t> line(magic.size());
  if (!file.read_at(0, line)) return no_bag(file.path());
  const std::string_view start(reinterpret_cast<const char*>(line.data()), line.size());
  if (start != magic) {
    if (!start.starts_with("#ROSBAG V") && !start.starts_with("#ROSRECORD V")) return no_bag(file.path());
    return input_error("is a bag of another format version than 2.0", file.path(),
                       "play it with rosbag and record it anew");
  }
  const std::optional<FileRecord> head = record_at(file, magic.size());
  if (!head || head->fields().op() != BagOp::bag_header || head->end() > file.size()) {
    return input_error("its header is cut or damaged", file.path(), "copy it again");
  }
  const std::optional<std::string> encryptor = head->fields().text("encryptor");
  if (encryptor && !encryptor->empty()) {
    return input_error("is encrypted", file.path(), "decrypt it with rosbag decrypt");
  }
  const auto index_at = head->fields().number<std::uint64_t>("index_pos").value_or(0);
  const auto connection_count = head->fields().number<std::uint32_t>("conn_count").value_or(0);
  const auto chunk_count = head->fields().number<std::uint32_t>("chunk_count").value_or(0);
  scan_at = head->end();
  indexed = index_at >= scan_at && read_index(index_at, connection_count, chunk_count);
  if (!indexed) {
    connections.clear();
    plan.clear();
  }
  return {};
}

/// The index at the end: every connection, then the place and time of every chunk. False where it is not whole.
bool BagReader::State::read_index(std::uint64_t index_at, std::uint32_t connection_count, std::uint32_t chunk_count) {
  for (std::uint64_t at = index_at; at < file.size();) {
    const std::optional<FileRecord> record = record_at(file, at);
    if (!record || record->end() > file.size()) return false;
    const BagFields fields = record->fields();
    if (fields.op() == BagOp::connection) {
      if (!add_connection(fields, data_of(file, *record, max_connection_bytes))) return false;
    } else if (fields.op() == BagOp::chunk_info) {
      const auto chunk_at = fields.number<std::uint64_t>("chunk_pos");
      const auto start_ns = fields.time_ns("start_time");
      if (!chunk_at || !start_ns || *chunk_at < scan_at || *chunk_at >= index_at) return false;
      plan.push_back({*chunk_at, *start_ns});
    }
    at = record->end();
  }
  if (connections.size() != connection_count || plan.size() != chunk_count) return false;
  std::sort(plan.begin(), plan.end(), [](const ChunkPlace& a, const ChunkPlace& b) { return a.at < b.at; });
  const auto same = [](const ChunkPlace& a, const ChunkPlace& b) { return a.at == b.at; };
  if (std::adjacent_find(plan.begin(), plan.end(), same) != plan.end()) return false;
  std::stable_sort(plan.begin(), plan.end(),
                   [](const ChunkPlace& a, const ChunkPlace& b) { return a.start_ns < b.start_ns; });
  return true;
}

bool BagReader::State::add_connection(const BagFields& fields, ByteView data) {
  const auto number = fields.number<std::uint32_t>("conn");
  const auto topic = fields.text("topic");
  if (!number || !topic) return false;
  const BagFields details(data);
  // Each chunk says it again: the first word counts, so that what was handed out stays true.
  connections.try_emplace(*number, BagConnection{printable(*topic), printable(details.text("type").value_or("")),
                                                 printable(details.text("md5sum").value_or(""))});
  return true;
}

std::optional<ChunkPlace> BagReader::State::peek_chunk() {
  if (indexed) {
    if (next_in_plan == plan.size()) return std::nullopt;
    return plan[next_in_plan];
  }
  while (scan_at < file.size()) {
    const std::optional<FileRecord> record = record_at(file, scan_at);
    if (!record) {
      leave_out(scan_at, "the file is cut or damaged");
      scan_at = file.size();
      return std::nullopt;
    }
    const std::optional<BagOp> op = record->fields().op();
    if (op == BagOp::chunk && record->data_bytes > 0) return ChunkPlace{scan_at, never};
    // A recorder that was killed leaves its last chunk open: size 0, and its records stand in the file itself.
    if (op == BagOp::connection) {
      add_connection(record->fields(), data_of(file, *record, max_connection_bytes));
    } else if (op == BagOp::message) {
      if (!open.empty()) return ChunkPlace{scan_at, never};
      load_loose_message(*record);
    }
    scan_at = record->end();
    if (!open.empty()) return std::nullopt;
  }
  return std::nullopt;
}

void BagReader::State::load_loose_message(const FileRecord& record) {
  auto chunk = std::make_unique<OpenChunk>();
  chunk->bytes = data_of(file, record, max_chunk_bytes);
  if (chunk->bytes.size() < record.data_bytes) {
    leave_out(scan_at, "a message is cut");
    return;
  }
  if (!add_message(*chunk, record.fields(), chunk->bytes)) leave_out(scan_at, "a message is damaged");
  keep(std::move(chunk));
}

void BagReader::State::load_chunk(std::uint64_t at) {
  const std::optional<FileRecord> record = record_at(file, at);
  if (!record || record->fields().op() != BagOp::chunk) {
    leave_out(at, "it is no chunk, though the index says so");
    return;
  }
  scan_at = record->end();
  const std::string compression = record->fields().text("compression").value_or("none");
  auto chunk = std::make_unique<OpenChunk>();
  std::vector<std::uint8_t> packed = data_of(file, *record, max_chunk_bytes);
  const bool cut = packed.size() < record->data_bytes;
  if (compression == "none") {
    chunk->bytes = std::move(packed);
  } else if (!cut) {
    const auto size = record->fields().number<std::uint32_t>("size").value_or(0);
    const Expected<void> unpacked = unpack_chunk(compression, packed, size, chunk->bytes);
    if (!unpacked) {
      leave_out(at, unpacked.error().what);
      return;
    }
  }
  ByteReader reader(chunk->bytes);
  bool sound = true;
  while (const std::optional<BagRecord> inner = take_bag_record(reader)) {
    const std::optional<BagOp> op = inner->fields.op();
    if (op == BagOp::connection) {
      sound &= add_connection(inner->fields, inner->data);
    } else {  // A chunk holds nothing else.
      sound &= op == BagOp::message && add_message(*chunk, inner->fields, inner->data);
    }
  }
  if (cut || !reader.ok()) {
    leave_out(at, cut ? "the file is cut" : "its records do not fit");
  } else if (!sound) {
    leave_out(at, "a record in it is damaged");
  }
  keep(std::move(chunk));
}

/// False where the record does not say of which connection or from when it is.
bool BagReader::State::add_message(OpenChunk& chunk, const BagFields& fields, ByteView data) {
  const auto number = fields.number<std::uint32_t>("conn");
  const auto stamp_ns = fields.time_ns("time");
  const auto connection = number ? connections.find(*number) : connections.end();
  if (!stamp_ns || connection == connections.end()) return false;
  chunk.messages.push_back({*stamp_ns, &connection->second, data});
  return true;
}

void BagReader::State::keep(std::unique_ptr<OpenChunk> chunk) {
  if (chunk->messages.empty()) return;
  std::stable_sort(chunk->messages.begin(), chunk->messages.end(),
                   [](const MessagePlace& a, const MessagePlace& b) { return a.stamp_ns < b.stamp_ns; });
  open_bytes += chunk->bytes.size();
  open.push_back(std::move(chunk));
}

void BagReader::State::leave_out(std::uint64_t at, const std::string& why) {
  ++left_out;
  if (first_reason.empty()) first_reason = "at byte " + std::to_string(at) + ": " + why;
}

OpenChunk* BagReader::State::earliest() {
  OpenChunk* found = nullptr;
  for (const auto& chunk : open) {
    if (found == nullptr || chunk->messages[chunk->next].stamp_ns < found->messages[found->next].stamp_ns) {
      found = chunk.get();
    }
  }
  return found;
}

BagReader::BagReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
BagReader::BagReader(BagReader&&) noexcept = default;
BagReader& BagReader::operator=(BagReader&&) noexcept = default;
BagReader::~BagReader() = default;

Expected<BagReader> BagReader::open(const std::string& path) {
  Expected<RandomAccessFile> file = RandomAccessFile::open(path);
  if (!file) return file.error();
  auto state = std::make_unique<State>(std::move(*file));
  const Expected<void> head = state->read_head();
  if (!state->file.failure().empty()) return read_failure(path, state->file.failure());
  if (!head) return head.error();
  return BagReader(std::move(state));
}

Expected<bool> BagReader::next(BagMessage& message) {
  State& state = *state_;
  std::erase_if(state.open, [&state](const std::unique_ptr<OpenChunk>& chunk) {
    const bool done = chunk->next == chunk->messages.size();
    if (done) state.open_bytes -= chunk->bytes.size();
    return done;
  });
  OpenChunk* chunk = state.earliest();
  while (const std::optional<ChunkPlace> place = state.peek_chunk()) {
    if (chunk != nullptr && place->start_ns > chunk->messages[chunk->next].stamp_ns) break;
    ++state.next_in_plan;
    state.load_chunk(place->at);
    if (!state.file.failure().empty()) break;
    if (state.open_bytes > max_open_bytes) {
      return input_error("more than " + std::to_string(max_open_bytes >> 20U) + " MB of it overlap in time",
                         state.file.path(), "sort it: rosbag filter in.bag sorted.bag True");
    }
    chunk = state.earliest();
  }
  if (!state.file.failure().empty()) return read_failure(state.file.path(), state.file.failure());
  chunk = state.earliest();
  if (chunk == nullptr) return false;
  const MessagePlace& place = chunk->messages[chunk->next++];
  message = {place.connection, place.stamp_ns, place.bytes};
  return true;
}

const std::map<std::uint32_t, BagConnection>& BagReader::connections() const { return state_->connections; }
bool BagReader::indexed() const { return state_->indexed; }

std::string BagReader::truncation() const {
  std::string text;
  if (!state_->indexed) text = "has no whole index (rosbag reindex makes one): the recording or the copy was cut short";
  if (state_->left_out > 0) {
    text += (text.empty() ? "" : "; ") + std::to_string(state_->left_out) + " part(s) left out, the first " +
            state_->first_reason;
  }
  return text;
}

double BagReader::fraction() const {
  if (state_->indexed) {
    return state_->plan.empty() ? 1.0
                                : static_cast<double>(state_->next_in_plan) / static_cast<double>(state_->plan.size());
  }
  return std::min(1.0, static_cast<double>(state_->scan_at) / static_cast<double>(state_->file.size()));
}

}  // namespace rigcal
