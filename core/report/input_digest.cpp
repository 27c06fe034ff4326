#include "core/report/input_digest.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "core/base/sha256.h"
#include "core/io/files_below.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t end_bytes = 16U << 20U;
constexpr std::size_t chunk_bytes = 1U << 20U;

ByteView bytes_of(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

// Adds `count` bytes from where the file stands; false: there are fewer, or it was told to stop.
bool add_bytes(std::ifstream& in, std::uint64_t count, const std::stop_token& stop, Sha256& sum) {
  std::string chunk(chunk_bytes, '\0');
  while (count > 0 && !stop.stop_requested()) {
    const auto part = static_cast<std::streamsize>(std::min<std::uint64_t>(count, chunk.size()));
    if (!in.read(chunk.data(), part)) return false;
    sum.add(bytes_of(chunk).first(static_cast<std::size_t>(part)));
    count -= static_cast<std::uint64_t>(part);
  }
  return count == 0;
}

std::optional<InputDigest> digest_file(const fs::path& path, std::uint64_t whole_bytes, const std::stop_token& stop) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;  // Opening a pipe may wait for ever.
  InputDigest digest;
  digest.path = path.string();
  digest.bytes = fs::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) return std::nullopt;
  digest.in_part = digest.bytes > whole_bytes;
  Sha256 sum;
  bool read = false;
  if (digest.in_part) {
    const std::uint64_t part = std::min(end_bytes, digest.bytes / 2);
    sum.add(bytes_of(std::to_string(digest.bytes) + "\n"));
    read = add_bytes(in, part, stop, sum);
    in.seekg(static_cast<std::streamoff>(digest.bytes - part));
    read = read && add_bytes(in, part, stop, sum);
  } else {
    read = add_bytes(in, digest.bytes, stop, sum);
  }
  if (!read) return std::nullopt;
  digest.sha256 = sum.finish();
  return digest;
}

// As `find -L . -type f -print0 | sort -z | xargs -0 sha256sum | sha256sum` in it gives it, names beginning with "./".
std::optional<InputDigest> digest_tree(const fs::path& folder, std::uint64_t whole_bytes, const std::stop_token& stop) {
  const Expected<std::vector<std::string>> names = files_below(folder);
  if (!names) return std::nullopt;
  InputDigest digest;
  digest.path = folder.string() + "/";
  digest.files = 0;
  Sha256 sum;
  std::error_code error;
  for (const std::string& name : *names) {
    if (!fs::is_regular_file(folder / name, error)) continue;
    const auto file = digest_file(folder / name, whole_bytes, stop);
    if (!file) return std::nullopt;
    ++digest.files;
    digest.bytes += file->bytes;
    digest.in_part |= file->in_part;
    sum.add(bytes_of(file->sha256 + "  ./" + name + "\n"));
  }
  if (digest.files == 0) return std::nullopt;
  digest.sha256 = sum.finish();
  return digest;
}

}  // namespace

std::vector<InputDigest> digest_inputs(const std::vector<std::string>& paths, const std::stop_token& stop,
                                       std::uint64_t whole_bytes) {
  std::vector<InputDigest> out;
  const auto keep = [&](std::optional<InputDigest> digest) {
    if (digest) out.push_back(std::move(*digest));
  };
  std::error_code error;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path, error)) {
      keep(digest_file(path, whole_bytes, stop));
      continue;
    }
    std::vector<fs::path> entries;
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
      entries.push_back(at->path());
    }
    std::sort(entries.begin(), entries.end());
    for (const fs::path& entry : entries) {
      keep(fs::is_directory(entry, error) ? digest_tree(entry, whole_bytes, stop)
                                          : digest_file(entry, whole_bytes, stop));
    }
  }
  return out;
}

}  // namespace rigcal
