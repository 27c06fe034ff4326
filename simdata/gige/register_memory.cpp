#include "simdata/gige/register_memory.h"

#include <algorithm>
#include <bit>

#include "core/base/error.h"
#include "core/base/network_order.h"

namespace rigcal::sim {

void RegisterMemory::define(std::uint32_t address, std::uint32_t value, Access access) {
  set(address, value);
  access_[address / 4] = access;
}

void RegisterMemory::define_bytes(std::uint32_t address, ByteView bytes, Access access) {
  RIGCAL_ASSERT(address % 4 == 0 && address <= bytes_.size() && bytes.size() <= bytes_.size() - address,
                "bytes outside of the memory");
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + address);
  std::fill_n(access_.begin() + address / 4, (bytes.size() + 3) / 4, access);
}

std::uint32_t RegisterMemory::value(std::uint32_t address) const {
  ByteReader reader(view(address, 4));
  return read_network<std::uint32_t>(reader);
}

void RegisterMemory::set(std::uint32_t address, std::uint32_t value) {
  RIGCAL_ASSERT(address % 4 == 0 && address < bytes_.size(), "a register outside of the memory");
  for (unsigned i = 0; i < 4; ++i) bytes_[address + i] = static_cast<std::uint8_t>(value >> (24U - 8U * i));
}

float RegisterMemory::real(std::uint32_t address) const { return std::bit_cast<float>(value(address)); }

void RegisterMemory::set_real(std::uint32_t address, double value) {
  set(address, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

gige::Status RegisterMemory::check(std::uint32_t address, std::size_t size, Access wanted) const {
  if (address % 4 != 0 || size % 4 != 0) return gige::Status::bad_alignment;
  if (address > bytes_.size() || size > bytes_.size() - address) return gige::Status::invalid_address;
  for (std::size_t i = address / 4; i < (address + size) / 4; ++i) {
    if (access_[i] == Access::none) return gige::Status::invalid_address;
    if (wanted == Access::write && access_[i] != Access::write) return gige::Status::write_protected;
  }
  return gige::Status::success;
}

}  // namespace rigcal::sim
